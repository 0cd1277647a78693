"""Results for the terminal: a line per run, a table with a row per scenario and size."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from swarm_bench.result import RunResult
from swarm_bench.summary import Row, summarise

COLUMNS = (
    "scenario", "robots", "runs", "collisions", "goals", "makespan [s]", "deadlocks", "pushes",
    "retreats", "worst wait [s]", "clearance [m]", "held gap [m]", "µs/tick",
)  # fmt: skip


def run_line(result: RunResult) -> str:
    """Return one line about one run."""
    makespan = "-" if result.makespan is None else f"{result.makespan:.1f}"
    text = (
        f"{result.scenario} {result.method} {result.robots} robots seed {result.seed}: "
        f"goals {result.goals_reached}/{result.goals_sent}, "
        f"collisions {result.robot_robot}+{result.robot_world}, makespan {makespan} s, "
        f"clearance {_number(result.min_clearance)}, held {_number(result.min_held_slack)}, "
        f"pushes {result.pushes}, retreats {result.retreats}, "
        f"deadlocks {result.deadlocks_resolved}, "
        f"{result.tick_us_median or 0.0:.0f} µs, {result.wall_time:.0f} s wall"
    )
    return text if not result.first_collision else f"{text}; first: {result.first_collision}"


def summary_table(results: Sequence[RunResult]) -> Table:
    """Return the table of a sweep."""
    table = Table(box=None, header_style="bold")
    for column in COLUMNS:
        table.add_column(column, justify="left" if column == "scenario" else "right")
    for row in summarise(results):
        table.add_row(*_cells(row), style="" if row.is_flawless else "red")
    return table


def _cells(row: Row) -> tuple[str, ...]:
    return (
        row.name,
        str(row.robots),
        str(row.runs),
        str(row.collisions),
        f"{row.goals_reached}/{row.goals_sent}",
        row.makespan_text,
        str(row.deadlocks_resolved),
        str(row.pushes),
        str(row.retreats),
        _number(row.wait_worst, 0),
        _number(row.min_clearance),
        _number(row.min_held_gap),
        _number(row.tick_us, 0),
    )


def _number(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
