"""Cost of one robot's decision, by the number of neighbours that it hears.

A decision is everything that a brain does in a tick: odometry, beacons and scan in, route,
traffic, controller and beacon out. CPU time of the thread is counted, so that the figures do not
depend on what else the machine does.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import typer

from benchmarks.app import Robots, benchmarks_app
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import check_size
from swarm_bench.suite.command import new_console
from swarm_bench.suite.selection import select
from swarm_bench.tables import BenchTable, number
from swarm_common.model.errors import ConfigError
from swarm_nav.core.goals import Output

WARM_TICKS = 30  # at the start, in which kernels are loaded and all robots plan
CLASS_WIDTH = 10  # neighbours


@dataclass(frozen=True, slots=True)
class DecisionRow:
    """Decisions with about as many neighbours."""

    least: int  # neighbours heard, at least; at most `least` + `CLASS_WIDTH` - 1
    count: int  # number of decisions
    median: float  # [ms] CPU time of a decision
    percentile_99: float  # [ms] likewise


COLUMNS: dict[str, Callable[[DecisionRow], str]] = {
    "neighbours": lambda row: f"{row.least}-{row.least + CLASS_WIDTH - 1}",
    "decisions": lambda row: str(row.count),
    "median [ms]": lambda row: number(row.median),
    "99 % [ms]": lambda row: number(row.percentile_99),
}


class _Timed(Harness):
    """Brains decide one by one; records neighbours heard and CPU time [ns] of each decision."""

    def __init__(self, options: RunOptions) -> None:
        super().__init__(options, times_all=True)
        self.decisions: list[tuple[int, int]] = []

    def _timed(self, index: int, tick: int) -> Output:
        started = time.thread_time_ns()
        output = super()._timed(index, tick)
        heard = len(self.observed[index].reception.rows)
        self.decisions.append((heard, time.thread_time_ns() - started))
        return output


def measure_decisions(options: RunOptions, ticks: int) -> list[DecisionRow]:
    """Run some ticks and return what decisions cost, by ascending number of neighbours."""
    harness = _Timed(options)
    try:
        for _ in range(WARM_TICKS + ticks):
            if harness.world.tick == WARM_TICKS:
                harness.decisions.clear()
            if not harness.advance():
                break
    finally:
        harness.world.close()
    heard, times = np.array(harness.decisions).T
    rows = []
    for least in np.unique(heard // CLASS_WIDTH * CLASS_WIDTH):
        of_class = times[(heard >= least) & (heard < least + CLASS_WIDTH)] / 1e6
        median, high = np.percentile(of_class, (50, 99))
        rows.append(DecisionRow(int(least), len(of_class), float(median), float(high)))
    return rows


@benchmarks_app.command()
def decisions(
    scenario: Annotated[str, typer.Option(help="Name or file.")] = "slim_blockage",
    robots: Robots = 50,
    ticks: Annotated[int, typer.Option(help="Number of ticks to measure.")] = 300,
    seed: Annotated[int, typer.Option(help="Seed of all random numbers.")] = 0,
    lidar: Annotated[bool, typer.Option(help="With scans and costmaps.")] = False,
) -> None:
    """Measure one robot's decision in CPU time, by the number of neighbours that it hears."""
    if ticks < 1:
        raise ConfigError(f"--ticks is {ticks}; expected 1 or more")
    options = select(scenario, [check_size(robots, "--robots")], [seed], lidar=lidar)
    new_console().print(BenchTable.of(COLUMNS, measure_decisions(options[0], ticks)).rich())
