"""What one robot's decision costs, by the number of neighbours that it hears.

A decision is everything that a brain does in a tick: odometry, beacons and scan in, route,
traffic, controller and beacon out. CPU time of the thread is counted, so that the figures do not
depend on what else the machine does.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_bench.runs.episode import RunOptions, build
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.methods import Driver
from swarm_common.model.beacon import Reception
from swarm_common.model.records import Odometry, Scan
from swarm_nav.core.goals import Goal, Output, Status

WARM_TICKS = 30  # at the start, in which kernels are loaded and all robots plan
CLASS_WIDTH = 10  # neighbours


@dataclass(frozen=True, slots=True)
class DecisionRow:
    """Decisions with about as many neighbours."""

    least: int  # neighbours heard, at least; at most `least` + `CLASS_WIDTH` - 1
    count: int  # number of decisions
    median: float  # [ms] CPU time of a decision
    percentile_99: float  # [ms] likewise


class Stopwatch:
    """A driver that notes how long another one takes and how many robots it hears.

    Attributes:
        heard: Neighbours of each tick.
        durations: [ns] of CPU time of each tick.
    """

    def __init__(self, driver: Driver) -> None:
        """Watch a driver."""
        self._driver = driver
        self.heard: list[int] = []
        self.durations: list[int] = []
        self._started = 0

    def on_odom(self, odom: Odometry) -> None:
        """Begin a tick: pass the odometry on."""
        self._started = time.thread_time_ns()
        self._driver.on_odom(odom)

    def on_scan(self, scan: Scan) -> None:
        """Take a scan."""
        self._driver.on_scan(scan)

    def on_reception(self, reception: Reception) -> None:
        """Take the beacons heard in this tick."""
        self.heard.append(len(reception.rows))
        self._driver.on_reception(reception)

    def tick(self, tick: int) -> Output:
        """End a tick: let the driver decide."""
        output = self._driver.tick(tick)
        self.durations.append(time.thread_time_ns() - self._started)
        return output

    def set_goal(self, goal: Goal) -> None:
        """Take a goal."""
        self._driver.set_goal(goal)

    def status(self) -> Status:
        """Return the driver's counters."""
        return self._driver.status()


def measure_decisions(options: RunOptions, ticks: int) -> list[DecisionRow]:
    """Run some ticks and return what decisions cost, by ascending number of neighbours."""
    stage = build(options)
    watches = [Stopwatch(driver) for driver in stage.drivers]
    stage.drivers[:] = watches
    harness = Harness(options, stage=stage)
    try:
        for _ in range(WARM_TICKS + ticks):
            if not harness.advance():
                break
    finally:
        stage.world.close()
    heard = np.concatenate([watch.heard[WARM_TICKS:] for watch in watches]).astype(np.int64)
    times = np.concatenate([watch.durations[WARM_TICKS:] for watch in watches]) / 1e6
    rows = []
    for least in np.unique(heard // CLASS_WIDTH * CLASS_WIDTH):
        of_class = times[(heard >= least) & (heard < least + CLASS_WIDTH)]
        median, high = np.percentile(of_class, (50, 99))
        rows.append(DecisionRow(int(least), len(of_class), float(median), float(high)))
    return rows


def decision_markdown(rows: Sequence[DecisionRow]) -> str:
    """Return the rows as a Markdown table."""
    lines = ["| neighbours | decisions | median [ms] | 99 % [ms] |", "|---|---|---|---|"]
    for row in rows:
        last = row.least + CLASS_WIDTH - 1
        times = f"{row.median:.3f} | {row.percentile_99:.3f}"
        lines.append(f"| {row.least}-{last} | {row.count} | {times} |")
    return "\n".join(lines)
