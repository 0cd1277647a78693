"""Results for the terminal: a line per run, a table with a row per scenario and size."""

from __future__ import annotations

from collections.abc import Sequence

from rich.markup import escape
from rich.table import Table

from swarm_bench.runs.result import FailedRun, RunResult
from swarm_bench.suite.summary import Row, summarise

COLUMNS = (
    "scenario", "method", "robots", "runs", "collisions (robots\n+ environment)",
    "goals", "makespan [s]", "deadlocks", "resolved",
    "pushes", "retreats", "worst wait [s]", "clearance [m]", "held gap - R [m]", "µs/tick",
)  # fmt: skip


def run_line(result: RunResult) -> str:
    """Return one line about one run."""
    text = (
        f"{result.scenario} {result.method} {result.engine} {result.robots} robots "
        f"seed {result.seed}: goals {result.goals_reached}/{result.goals_sent}, "
        f"collisions {result.robot_robot}+{result.robot_world}, "
        f"makespan {number(result.makespan, 1)} s, clearance {number(result.min_clearance)}, "
        f"held {number(result.min_held_slack)}, pushes {result.pushes}, "
        f"retreats {result.retreats}, {_standing(result)}, "
        f"{number(result.tick_us_median, 0)} µs, "
        f"{number(result.cpu_ms_per_robot_second, 2)} ms of CPU per robot-second, "
        f"{result.wall_time:.0f} s wall"
    )
    if result.pose_error is not None:
        error = result.pose_error
        text += (
            f", localisation error {error['median']:.3f} m, 95 % {error['p95']:.3f} m, "
            f"at most {error['max']:.3f} m"
        )
    warning = f"no guarantee: {result.no_guarantee}" if result.no_guarantee else ""
    plugins = [
        f"{name} {value}" for name, value in result.conditions.items() if name.endswith("plugin")
    ]
    notes = (*plugins, warning, result.breach, result.first_collision, result.first_miss)
    return "; ".join([text, *filter(None, notes)])


def _standing(result: RunResult) -> str:
    """Return what the simulator saw; on the ROS graph what the robots say."""
    seen = result.ground_truth
    if seen is None:
        return (
            f"deadlocks resolved {result.deadlocks_resolved}, "
            f"circles of waiting {number(result.wait_circles, 0)}"
        )
    return (
        f"deadlocks {seen.deadlocks}, {seen.stood_time:.0f} s of standing, "
        f"circles of waiting {seen.circles}"
    )


def failure_line(failed: FailedRun) -> str:
    """Return one line about a run without a result."""
    return (
        f"{failed.scenario} {failed.method} {failed.engine} {failed.robots} robots "
        f"seed {failed.seed}: {'refused' if failed.refused else 'failed'}: {failed.error}"
    )


def summary_table(results: Sequence[RunResult]) -> Table:
    """Return the table of a sweep.

    Args:
        results: In any order; rows that are not flawless are red.
    """
    table = Table(box=None, header_style="bold")
    for column in COLUMNS:
        table.add_column(escape(column), justify="left" if column in COLUMNS[:2] else "right")
    for row in summarise(results):
        table.add_row(*_cells(row), style="" if row.is_flawless else "red")
    return table


def _cells(row: Row) -> tuple[str, ...]:
    return (
        row.label,
        row.first.method,
        str(row.first.robots),
        str(len(row.runs)),
        row.collisions_text,
        f"{row.goals_reached}/{row.goals_sent}",
        row.makespan_text,
        row.deadlocks_text,
        str(row.total("deadlocks_resolved")),
        str(row.total("pushes")),
        str(row.total("retreats")),
        number(row.most("wait_worst"), 0),
        number(row.least("min_clearance")),
        number(row.least("min_held_slack")),
        number(row.median("tick_us_median"), 0),
    )


def contacts_text(count: int) -> str:
    """Return a number of contact episodes in words."""
    return "1 contact" if count == 1 else f"{count} contacts"


def number(value: float | None, digits: int = 3) -> str:
    """Return a number for a table, - for None."""
    return "-" if value is None else f"{value:.{digits}f}"
