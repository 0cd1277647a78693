"""`report.json` of a run on the ROS graph, from what its processes said and used."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from swarm_commander.run.processes.usage import UsageMeter
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_common.files.storage import write_whole
from swarm_mission.orders.floor_use import joined
from swarm_run.command_line import COMPONENT_FAILED, MISSED, OK
from swarm_run.record.compose import RobotFacts, compose_record
from swarm_run.record.figures import finite, per_robot_second, rounded
from swarm_run.record.report_file import report_of
from swarm_run.record.run_record import Goals
from swarm_run.spec import RunSpec

MEASURED = ("world", "navigators")  # groups of processes whose memory is told


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
    """Return report.json as `report_of` has it.

    Args:
        verdict: What the world measured; empty if it could not say.
    """
    seen: dict[str, Any] = {
        "sim_time": statistics.sim_time,
        "robot_robot": statistics.robot_robot,
        "robot_world": statistics.robot_world,
        "collisions": [asdict(collision) for collision in statistics.collisions_seen],
    }
    measured = seen | dict(verdict)
    sim_time = float(measured["sim_time"])
    is_done = statistics.has_mission and not statistics.pending
    orders, last = statistics.orders, finite(statistics.last_goal_time)
    floor = joined(statistics.floors.values())
    record = compose_record(
        {
            name: RobotFacts(
                reached=robot.reached,
                failed=robot.failed,
                ends=robot.ends,
                is_done=is_done,
                hold_time=robot.hold_time,
                wait_time=robot.wait_time,
                counts=robot.counts,
                restarts=robot.restarts,
            )
            for name, robot in statistics.robots.items()
        },
        Goals(statistics.sent, statistics.reached, statistics.failed, statistics.pending),
        last,
        measured,
        missed=statistics.misses,
        unfinished=statistics.unfinished,
        waits=statistics.waits.as_json(sim_time),
        robots=spec.size,
        seed=spec.seed,
        wall_time=times.wall_time,
        orders=None if orders is None else {**orders.as_json(sim_time), **floor},
        centre=_centre(statistics, usage, spec.size, sim_time),
        processes={
            "has_verdict": bool(verdict),
            "world": spec.world,
            "robot": spec.model,
            "mission": spec.mission,
            "real_time_factor": verdict.get("real_time_factor", statistics.real_time_factor),
            "active_after_wall": times.active_after_wall,
            "conditions": _conditions(statistics),
            "late_ticks": verdict.get("late_ticks"),
            "restarts": times.restarts,
            "rejected": dict(sorted(statistics.rejected.items())),
            "foreign_publishers": [
                {"topic": topic, "node": node} for topic, node in statistics.foreign
            ],
            **_costs(usage, spec.size, sim_time),
        },
    )
    return report_of(record)


def _costs(usage: UsageMeter, robots: int, sim_time: float) -> dict[str, Any]:
    """Return what processes have used: CPU per robot and second, memory."""
    cpu = {group: usage.cpu(group) for group in MEASURED}
    cpu["onlookers"] = usage.cpu("recorder") + usage.cpu("viewer")
    cpu["total"] = sum(cpu.values()) + usage.cpu("operator")
    meters = {"memory_mb": usage.memory_mb, "private_mb": usage.private_mb, "rss_mb": usage.rss_mb}
    return {
        "cpu_ms_per_robot_second": {
            name: per_robot_second(1000.0 * value, robots, sim_time) for name, value in cpu.items()
        },
        **{
            name: {group: rounded(read(group), 1) for group in MEASURED}
            for name, read in meters.items()
        },
    }


def _centre(
    statistics: RunStatistics, usage: UsageMeter, robots: int, sim_time: float
) -> dict[str, float] | None:
    """Return what the centre has cost, its whole process included; None without one."""
    if not statistics.centre:
        return None
    cpu = per_robot_second(1000.0 * usage.cpu("central"), robots, sim_time)
    return {**statistics.centre, "process_cpu_ms_per_robot_second": cpu or 0.0}


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
    missed = missed or report.get("fleet_control", {}).get("is_failed")
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
