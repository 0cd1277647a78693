"""`report.json`: the result of a run in the form that tools outside rely on."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarm_commander.run.processes.usage import UsageMeter
from swarm_commander.run.results.run_statistics import COUNTS, RunStatistics
from swarm_common.files.whole_file import write_whole
from swarm_common.model.breaches import Collision, breaches_json
from swarm_mission.fairness import fairness
from swarm_mission.orders.floor_use import joined
from swarm_run.command_line import COMPONENT_FAILED, MISSED, OK
from swarm_run.spec import RunSpec

SCHEMA = 1


@dataclass(frozen=True, slots=True)
class RunTimes:
    """Wall-clock figures of a run, and how often something was started again."""

    wall_time: float  # [s] from the start of the command until the run began to stop
    active_after_wall: float | None  # [s] until every navigator was active
    restarts: int = 0  # of processes


def compose_report(
    spec: RunSpec,
    statistics: RunStatistics,
    verdict: Mapping[str, Any],
    usage: UsageMeter,
    times: RunTimes,
) -> dict[str, Any]:
    """Return the report except for the keys below; what could not be measured is null.

    `cli/session.py` adds `exit_code`, `failures` and `incidents`, and those that
    `swarm_report/report_fields.py` works out from the time series. `hosts/hosted_navigators.py`
    adds `hosts`. A goal that was missed is in
    `breaches.missed_goals`; `goals.failed` and `goals_failed` count such goals.

    Args:
        verdict: What the world measured; empty if it could not say.
    """
    sim_time = float(verdict.get("sim_time", statistics.sim_time))
    seconds = spec.size * sim_time
    cpu = {group: usage.cpu(group) for group in ("world", "navigators", "operator")}
    cpu["onlookers"] = usage.cpu("recorder") + usage.cpu("viewer")
    per_second = {
        "world": cpu["world"],
        "navigators": cpu["navigators"],
        "onlookers": cpu["onlookers"],
        "total": sum(cpu.values()),
    }
    makespan = statistics.last_goal_time if math.isfinite(statistics.last_goal_time) else None
    return {
        "schema": SCHEMA,
        "has_verdict": bool(verdict),
        "swarm_size": spec.size,
        "world": spec.world,
        "robot": spec.model,
        "mission": spec.mission,
        "seed": spec.seed,
        "sim_time": rounded(sim_time),
        "wall_time": rounded(times.wall_time),
        "real_time_factor": rounded(verdict.get("real_time_factor", statistics.real_time_factor)),
        "active_after_wall": rounded(times.active_after_wall),
        "goals": {
            "sent": statistics.sent,
            "reached": statistics.reached,
            "failed": statistics.failed,
            "pending": statistics.pending,
        },
        "collisions": {
            # without a verdict it is unknown whether there was one
            "robot_robot": verdict.get("robot_robot", statistics.robot_robot or None),
            "robot_world": verdict.get("robot_world", statistics.robot_world or None),
        },
        "conditions": _conditions(statistics),
        "near_misses": verdict.get("near_misses"),
        "min_clearance": rounded(verdict.get("min_clearance"), 4),
        "makespan": rounded(makespan),
        "throughput_per_minute": rounded(60.0 * statistics.reached / makespan if makespan else 0.0),
        **_service(statistics),
        "waits": statistics.waits.as_json(sim_time),
        "late_ticks": verdict.get("late_ticks"),
        "restarts": times.restarts,
        "rejected": dict(sorted(statistics.rejected.items())),
        "foreign_publishers": [
            {"topic": topic, "node": node} for topic, node in statistics.foreign
        ],
        "cpu_ms_per_robot_second": {
            name: rounded(1000.0 * value / seconds) if seconds else None
            for name, value in per_second.items()
        },
        "memory_mb": {
            group: rounded(usage.memory_mb(group), 1) for group in ("world", "navigators")
        },
        "private_mb": {
            group: rounded(usage.private_mb(group), 1) for group in ("world", "navigators")
        },
        "rss_mb": {group: rounded(usage.rss_mb(group), 1) for group in ("world", "navigators")},
        "trajectory_sha256": verdict.get("trajectory_sha256"),
        **({"zones": verdict["zones"]} if verdict.get("zones") else {}),
        **_orders(statistics, sim_time),
        **_centre(statistics, usage, seconds),
        "breaches": breaches_json(
            _collisions(statistics, verdict), statistics.misses, statistics.unfinished
        ),
        "robots": _robots(statistics, verdict.get("robots", {})),
    }


def _collisions(statistics: RunStatistics, verdict: Mapping[str, Any]) -> list[Collision]:
    """Return the contact episodes of the verdict; without one, those that were reported."""
    if "collisions" not in verdict:
        return statistics.collisions_seen
    return [Collision.from_json(collision) for collision in verdict["collisions"]]


def _orders(statistics: RunStatistics, sim_time: float) -> dict[str, Any]:
    if statistics.orders is None:
        return {}
    figures = statistics.orders.as_json(sim_time)
    return {"orders": {**figures, **joined(statistics.floors.values())}}


def _centre(statistics: RunStatistics, usage: UsageMeter, seconds: float) -> dict[str, Any]:
    """Return what the centre has cost, its whole process included; nothing without one."""
    if not statistics.centre:
        return {}
    cpu = rounded(1000.0 * usage.cpu("central") / seconds) if seconds else None
    figures = {name: rounded(value) for name, value in statistics.centre.items()}
    return {"centre": {**figures, "process_cpu_ms_per_robot_second": cpu}}


def _conditions(statistics: RunStatistics) -> dict[str, Any] | None:
    """Return which conditions hold, None if nobody looked at the map."""
    found, unseen = statistics.conditions, statistics.unseen
    if found is None:
        return None
    return {
        "guaranteed": found.guaranteed and not unseen,
        "places": found.places,
        "robots": found.robots,
        "findings": [*unseen, *found.findings],
    }


def _service(statistics: RunStatistics) -> dict[str, Any]:
    """Return the totals over robots: waits, holds, pushes, retreats and the like."""
    robots = statistics.robots.values()
    served = fairness([duration for robot in robots for duration in robot.durations])
    return {
        "hold_time": rounded(sum(robot.hold_time for robot in robots)),
        "wait_time": rounded(sum(robot.wait_time for robot in robots)),
        "worst_wait": rounded(max(robot.hold_time + robot.wait_time for robot in robots)),
        "goal_duration": {"median": rounded(served.median), "worst": rounded(served.worst)},
        "fairness": rounded(served.ratio),
        **{name: sum(robot.counts[name] for robot in robots) for name in COUNTS.values()},
    }


def _robots(statistics: RunStatistics, measured: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    return {
        name: {
            "goals_reached": robot.reached,
            "goals_failed": robot.failed,
            "restarts": robot.restarts,
            "hold_time": rounded(robot.hold_time),
            "wait_time": rounded(robot.wait_time),
            "worst_goal_duration": rounded(max(robot.durations, default=None)),
            **robot.counts,
            "distance": rounded(measured.get(name, {}).get("distance")),
            "collisions": measured.get(name, {}).get("collisions"),
            "near_misses": measured.get(name, {}).get("near_misses"),
            "min_clearance": rounded(measured.get(name, {}).get("min_clearance"), 4),
            **_battery(measured.get(name, {})),
        }
        for name, robot in statistics.robots.items()
    }


def _battery(measured: Mapping[str, Any]) -> dict[str, Any]:
    battery = measured.get("battery") or {}
    return {
        f"battery_{name}": value if isinstance(value, int) else rounded(value)
        for name, value in battery.items()
    }


def exit_code(report: Mapping[str, Any], *, is_unfinished: bool, component_failed: bool) -> int:
    """Return the exit code of a run.

    Args:
        is_unfinished: Whether the run ended before its mission although it was to finish it
            (--until-done) and the user did not stop it.
        component_failed: Whether a process or a robot died.
    """
    if component_failed:
        return COMPONENT_FAILED
    goals, collisions = report["goals"], report["collisions"]
    missed = goals["failed"] or is_unfinished or report.get("recording", {}).get("missing")
    if missed or collisions["robot_robot"] or collisions["robot_world"]:
        return MISSED
    return OK


def load_verdict(path: Path) -> dict[str, Any]:
    """Return what the world wrote at its end; empty if it could not.

    Args:
        path: Path of the file, which may be missing or damaged.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def write_report(path: Path, report: Mapping[str, Any]) -> str:
    """Write the report, whole or not at all; return what to say if it cannot be written.

    Returns:
        Empty if it is written.
    """
    try:
        write_whole(path, json.dumps(report, indent=2, allow_nan=False) + "\n")
    except OSError as error:
        return f"the report {path} cannot be written: {error.strerror}"
    return ""


def rounded(value: Any, digits: int = 3) -> float | None:
    """Return a number for JSON; None for what is unknown or not finite.

    Args:
        value: None, infinities and NaN become None.
    """
    if value is None or not math.isfinite(value):
        return None
    return round(float(value), digits)
