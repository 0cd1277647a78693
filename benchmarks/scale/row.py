"""One table row for the runs of one system, workload and size, for terminal and Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rich.markup import escape
from rich.table import Table

from benchmarks.scale.result import ScaleResult, median_of
from swarm_bench.suite.table import number

NOISY = 0.1  # share of the processors that others had, from which figures are marked


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

    def median(self, figure: Callable[[ScaleResult], float | None]) -> float | None:
        """Return the median of a figure over the runs that have it; None if none has."""
        return median_of([figure(run) for run in self.runs])

    def cpu(self, part: str) -> float | None:
        """Return CPU time [ms] per robot and simulated second of a part; None if unknown."""
        return self.median(lambda run: run.cpu_ms.get(part))

    @property
    def cpu_total(self) -> float:
        """CPU time [ms] per robot and simulated second of everything."""
        return self.median(lambda run: run.cpu_total) or 0.0

    @property
    def factor(self) -> float:
        """Real-time factor."""
        return self.median(lambda run: run.real_time_factor) or 0.0

    def memory(self, kind: str) -> float | None:
        """Return memory [MB], `total`, `robot` or `rss`; None if it was not measured."""
        return self.median(lambda run: run.memory_mb.get(kind))

    def total(self, name: str) -> int | None:
        """Return the largest value of a field of `ScaleResult`; None if no run has it."""
        values = [getattr(run, name) for run in self.runs]
        known = [value for value in values if value is not None]
        return max(known) if known else None


Column = Callable[[ScaleRow], str]
COMMON: dict[str, Column] = {
    "robots": lambda row: str(row.first.robots),
    "workload": lambda row: row.label,
    "runs": lambda row: str(len(row.runs)),
    "start-up [s]": lambda row: number(row.median(lambda run: run.start_up), 1),
    "real-time factor": lambda row: f"{row.factor:.2f}" if row.factor < 10 else f"{row.factor:.1f}",
    "CPU [ms]": lambda row: number(row.cpu_total, 2),
    "world": lambda row: number(row.cpu("world"), 2),
    "navigators": lambda row: number(row.cpu("navigators"), 2),
    "other": lambda row: number(row.cpu("other"), 2),
}
ENDS: dict[str, Column] = {
    "collisions": lambda row: _count(row.total("collisions")),
    "others [%]": lambda row: number(row.median(_percent_of_others), 0),
}
GRAPH_COLUMNS: dict[str, Column] = {
    **COMMON,
    "of it DDS threads": lambda row: number(row.cpu("dds"), 2),
    "memory [MB]": lambda row: number(row.memory("total"), 0),
    "USS per process [MB]": lambda row: number(row.memory("robot"), 1),
    "late ticks": lambda row: _count(row.total("late_ticks")),
    **ENDS,
}
HARNESS_COLUMNS: dict[str, Column] = {
    **COMMON,
    "µs per tick": lambda row: number(row.median(lambda run: run.tick_us.get("median")), 0),
    "99 %": lambda row: number(row.median(lambda run: run.tick_us.get("p99")), 0),
    "RSS [MB]": lambda row: number(row.memory("rss"), 0),
    **ENDS,
}


def rows_of(results: Iterable[ScaleResult]) -> list[ScaleRow]:
    """Return a row per system, workload, size and setting, by size."""
    groups: dict[tuple[Any, ...], list[ScaleResult]] = {}
    for result in results:
        groups.setdefault(result.kind, []).append(result)
    rows = [ScaleRow(tuple(runs)) for runs in groups.values()]
    return sorted(rows, key=lambda row: (row.first.system, row.first.robots, row.label))


def columns_of(rows: Sequence[ScaleRow]) -> dict[str, Column]:
    """Return the columns for rows of one system."""
    return GRAPH_COLUMNS if rows and rows[0].first.system == "graph" else HARNESS_COLUMNS


def scale_table(rows: Sequence[ScaleRow], columns: dict[str, Column]) -> Table:
    """Return the table for the terminal; rows measured on a busy machine are dim."""
    table = Table(box=None, header_style="bold")
    for name in columns:
        table.add_column(
            escape(name), justify="left" if name in ("workload", "system") else "right"
        )
    for row in rows:
        cells = (cell(row) for cell in columns.values())
        table.add_row(*cells, style="dim" if row.is_noisy else "")
    return table


def growth(rows: Sequence[ScaleRow], few: int = 20, many: int = 100) -> float | None:
    """Return the growth of a robot-second's CPU time from few to many robots, if known."""
    costs = {row.first.robots: row.cpu_total for row in rows}
    if few not in costs or many not in costs or not costs[few]:
        return None
    return costs[many] / costs[few]


def _count(value: int | None) -> str:
    return "-" if value is None else str(value)


def _percent_of_others(run: ScaleResult) -> float | None:
    return None if run.others is None else 100.0 * run.others
