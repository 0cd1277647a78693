"""Results for the terminal: a line per run, a table with a row per scenario and size."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from swarm_bench.runs.result import FailedRun
from swarm_bench.suite.summary import Row, summarise
from swarm_bench.tables import BenchTable, number
from swarm_run.record.run_record import RunRecord

COLUMNS: dict[str, Callable[[Row], str]] = {
    "scenario": lambda row: row.label,
    "method": lambda row: row.first.method,
    "robots": lambda row: str(row.first.robots),
    "runs": lambda row: str(len(row.runs)),
    "seeds": lambda row: str(len(row.runs)),
    "contacts": lambda row: str(row.collisions),
    "collisions (robots + environment)": lambda row: row.collisions_text,
    "goals": lambda row: row.goals_text,
    "makespan [s]": lambda row: row.makespan_text,
    "mean, 95 % [s]": lambda row: row.mean_text,
    "target [s]": lambda row: row.target_text,
    "goals/min": lambda row: number(row.median("throughput_per_minute"), 1),
    "deadlocks": lambda row: row.deadlocks_text,
    "deadlocks resolved": lambda row: str(row.total("deadlocks_resolved")),
    "pushes": lambda row: str(row.total("pushes")),
    "retreats": lambda row: str(row.total("retreats")),
    "worst wait [s]": lambda row: number(row.worst_wait, 0),
    "worst over median wait": lambda row: number(row.wait_ratio, 1),
    "clearance [m]": lambda row: number(row.least("min_clearance")),
    "near misses": lambda row: str(row.total("near_misses")),
    "held gap [m]": lambda row: number(row.least("min_held_slack")),
    "µs per tick": lambda row: number(row.median("tick_us_median"), 0),
}
SHORT = {  # on a terminal
    "collisions (robots + environment)": "collisions (robots\n+ environment)",
    "deadlocks resolved": "resolved",
    "held gap [m]": "held gap - R [m]",
    "µs per tick": "µs/tick",
}
NOT_ON_TERMINAL = {
    "seeds",
    "contacts",
    "mean, 95 % [s]",
    "target [s]",
    "goals/min",
    "worst over median wait",
    "near misses",
}


def run_line(result: RunRecord) -> str:
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


def _standing(result: RunRecord) -> str:
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


def summary_table(results: Sequence[RunRecord]) -> BenchTable:
    """Return the table of a sweep.

    Args:
        results: In any order; rows that are not flawless are red.
    """
    return BenchTable.of(
        {SHORT.get(name, name): COLUMNS[name] for name in COLUMNS if name not in NOT_ON_TERMINAL},
        summarise(results),
        texts=("scenario", "method"),
        style=lambda row: "" if row.is_flawless else "red",
    )
