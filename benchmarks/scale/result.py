"""Cost of one run of `python -m benchmarks scale`, and a table row of several."""

from __future__ import annotations

import dataclasses
import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

from swarm_bench.tables import BenchTable, number
from swarm_run.record.figures import rounded

NOISY = 0.1  # share of the processors that others had, from which figures are marked
FEW, MANY = 20, 100  # robots, between which growth is told


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleResult:
    """One run; None where a system has no such thing, or it could not be measured."""

    system: str  # `graph` or `harness`
    workload: str  # hall and mission
    robots: int  # swarm size
    repeat: int  # number of the run
    setting: Mapping[str, Any]  # how it ran: seconds, goals, pack, engine
    start_up: float | None  # [s] of wall time until every robot could decide
    sim_time: float  # [s] at the end
    wall_time: float  # [s] that these took, without the start-up
    # CPU time [ms] per robot and simulated second, of `world`, `navigators` and `other`
    cpu_ms: Mapping[str, float | None]
    # `total`: proportional share of all processes; `robot`: private memory of a robot (of a process
    # with its share of robots), `rss`: resident, shared pages counted in each process
    memory_mb: Mapping[str, float | None]
    late_ticks: int | None = None  # answers that came too late
    collisions: int | None = None  # contact episodes
    goals_reached: int | None = None  # in time
    # [µs] of a robot's decisions in a tick: `median`, `p99`
    tick_us: Mapping[str, float | None] = field(default_factory=dict)
    # share of the machine's processors that something else used meanwhile
    others: float | None = None
    code: str = ""  # commit
    machine: str = ""  # in one line
    trajectory_sha256: str = ""  # of the true poses

    @property
    def real_time_factor(self) -> float:
        """Simulated by wall time."""
        return self.sim_time / self.wall_time if self.wall_time else math.nan

    @property
    def cpu_total(self) -> float:
        """CPU time [ms] per robot and simulated second, of everything."""
        return sum(self.cpu_ms.get(part) or 0.0 for part in ("world", "navigators", "other"))

    @property
    def kind(self) -> tuple[Any, ...]:
        """Tuple that repeats of one run share."""
        return (self.system, self.workload, self.robots, *self.setting.values())

    @property
    def key(self) -> tuple[Any, ...]:
        """Key of the job whose result it is."""
        return (self.system, self.workload, self.robots, self.repeat, *self.setting.values())

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump."""
        return {"schema": 1, **rounded(dataclasses.asdict(self))}


@dataclass(frozen=True, slots=True)
class ScaleRow:
    """Repeats of one run; every figure is the median over them."""

    runs: tuple[ScaleResult, ...]  # at least one

    @property
    def first(self) -> ScaleResult:
        """The first run; used for the properties that all runs share."""
        return self.runs[0]

    @property
    def label(self) -> str:
        """Workload, and how it ran if that was not as usual."""
        setting = self.first.setting
        notes = [f"pack {setting['pack']}"] if setting["pack"] > 1 else []
        usual = "bullet" if self.first.system == "graph" else "planar"
        notes += [setting["engine"]] if setting["engine"] != usual else []
        return ", ".join([self.first.workload, *notes])

    @property
    def is_noisy(self) -> bool:
        """Whether something else used the machine meanwhile."""
        return (self.median(lambda run: run.others) or 0.0) > NOISY

    @property
    def cpu_total(self) -> float:
        """CPU time [ms] per robot and simulated second of everything."""
        return self.median(lambda run: run.cpu_total) or 0.0

    def median(self, figure: Callable[[ScaleResult], float | None]) -> float | None:
        """Return the median of a figure over the runs that have it; None if none has."""
        known = [value for run in self.runs if (value := figure(run)) is not None]
        return statistics.median(known) if known else None


class Figure(NamedTuple):
    """Figure of runs, as tables show it."""

    of: Callable[[ScaleResult], float | None]
    digits: int = 0
    only: str = ""  # system that has it; empty for both


FIGURES = {
    "start-up [s]": Figure(lambda run: run.start_up, 1),
    "real-time factor": Figure(lambda run: run.real_time_factor, 2),
    "CPU [ms]": Figure(lambda run: run.cpu_total, 2),
    "world": Figure(lambda run: run.cpu_ms.get("world"), 2),
    "navigators": Figure(lambda run: run.cpu_ms.get("navigators"), 2),
    "other": Figure(lambda run: run.cpu_ms.get("other"), 2),
    "memory [MB]": Figure(lambda run: run.memory_mb.get("total"), 0, "graph"),
    "USS per process [MB]": Figure(lambda run: run.memory_mb.get("robot"), 1, "graph"),
    "late ticks": Figure(lambda run: run.late_ticks, 0, "graph"),
    "µs per tick": Figure(lambda run: run.tick_us.get("median"), 0, "harness"),
    "99 %": Figure(lambda run: run.tick_us.get("p99"), 0, "harness"),
    "RSS [MB]": Figure(lambda run: run.memory_mb.get("rss"), 0, "harness"),
    "collisions": Figure(lambda run: run.collisions),
    "others [%]": Figure(lambda run: None if run.others is None else 100.0 * run.others),
}


def rows_of(results: Iterable[ScaleResult]) -> list[ScaleRow]:
    """Return a row per system, workload, size and setting, by size."""
    groups: dict[tuple[Any, ...], list[ScaleResult]] = {}
    for result in results:
        groups.setdefault(result.kind, []).append(result)
    rows = [ScaleRow(tuple(runs)) for runs in groups.values()]
    return sorted(rows, key=lambda row: (row.first.system, row.first.robots, row.label))


HEADS: dict[str, Callable[[ScaleRow], str]] = {
    "robots": lambda row: str(row.first.robots),
    "workload": lambda row: row.label,
    "runs": lambda row: str(len(row.runs)),
}


def scale_table(
    rows: Sequence[ScaleRow], names: Sequence[str], heads: Sequence[str] = tuple(HEADS)
) -> BenchTable:
    """Return a table of figures; rows measured on a busy machine are dim.

    Args:
        names: Names in `FIGURES`.
        heads: Names in `HEADS`.
    """
    columns = {name: HEADS[name] for name in heads}
    columns |= {name: partial(_cell, name) for name in names}
    return BenchTable.of(
        columns, rows, texts=("workload",), style=lambda row: "dim" if row.is_noisy else ""
    )


def _cell(name: str, row: ScaleRow) -> str:
    value, digits = row.median(FIGURES[name].of), FIGURES[name].digits
    if name == "real-time factor" and value is not None and value >= 10:
        digits = 1
    return number(value, digits)


def growth(rows: Sequence[ScaleRow]) -> float | None:
    """Return the growth of a robot-second's CPU time from `FEW` to `MANY` robots, if known."""
    costs = {row.first.robots: row.cpu_total for row in rows}
    if FEW not in costs or MANY not in costs or not costs[FEW]:
        return None
    return costs[MANY] / costs[FEW]
