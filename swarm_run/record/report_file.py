"""`report.json` of a record, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from swarm_common.model.breaches import breaches_json
from swarm_run.record.compose import totals
from swarm_run.record.figures import rounded
from swarm_run.record.run_record import SCHEMA, Breaches, Goals, Merits, RobotRecord, RunRecord

MERITS = Merits.__struct_fields__
EQUAL = ("seed", "sim_time", "wall_time", "throughput_per_minute", "fairness", *MERITS)
OF_ROBOT = ("goals_reached", "goals_failed", "restarts", "finish_time", "distance", "collisions",
            *MERITS)  # fmt: skip
IF_KNOWN = ("zones", "orders", "centre")
BATTERY = "battery_"  # begins the names of a battery's figures


def report_of(record: RunRecord) -> dict[str, Any]:
    """Return report.json but for the keys below; what could not be measured is null.

    `cli/session.py` adds `exit_code`, `failures` and `incidents`, and those that
    `swarm_report/headline.py` works out from the time series. `hosts/world_run.py` adds
    `hosts`. A goal that was missed is in `breaches.missed_goals`; `goals.failed` and
    `goals_failed` count such goals.
    """
    breaches = record.breaches
    contacts = {name: getattr(record, name) for name in ("robot_robot", "robot_world")}
    if not record.processes.get("has_verdict", True):  # unknown is whether there was one
        contacts = {name: count or None for name, count in contacts.items()}
    report: dict[str, Any] = rounded(
        {
            "schema": SCHEMA,
            "swarm_size": record.robots,
            **{name: getattr(record, name) for name in EQUAL},
            "goals": record.goals,
            "collisions": contacts,
            "makespan": record.settled_time,
            "worst_wait": record.wait_worst,
            "goal_duration": {"median": record.goal_median, "worst": record.goal_worst},
            "waits": record.waits,
            "trajectory_sha256": record.trajectory_sha256 or None,
            **{name: value for name in IF_KNOWN if (value := getattr(record, name))},
            "breaches": breaches_json(
                breaches.collisions, breaches.missed_goals, breaches.unfinished_goals
            ),
            "robots": {name: _entry(robot) for name, robot in record.per_robot.items()},
            **record.processes,
        }
    )
    return report


def _entry(robot: RobotRecord) -> dict[str, Any]:
    return {
        **{name: getattr(robot, name) for name in OF_ROBOT},
        "worst_goal_duration": robot.goal_worst,
        **{f"{BATTERY}{name}": value for name, value in (robot.battery or {}).items()},
    }


def record_of(report: Mapping[str, Any]) -> RunRecord:
    """Return the record in a report.json; what only a bench knows is None."""
    robots = {
        name: _robot(entry)
        for name, entry in report["robots"].items()
        if name not in (report.get("broken") or ())
    }
    breaches = msgspec.convert(report["breaches"], Breaches)
    cpu, conditions = report.get("cpu_ms_per_robot_second") or {}, report.get("conditions") or {}
    used = [cpu[group] for group in ("world", "navigators") if cpu.get(group) is not None]
    equal: dict[str, Any] = {name: report.get(name) for name in (*EQUAL, *IF_KNOWN)}
    found = totals(
        Goals(**report["goals"]), report["makespan"], robots, breaches, report.get("waits") or {}
    )
    return RunRecord(
        **found | equal,
        scenario=report["world"],
        robots=report["swarm_size"],
        robot_robot=report["collisions"]["robot_robot"] or 0,
        robot_world=report["collisions"]["robot_world"] or 0,
        goal_median=report["goal_duration"]["median"],
        goal_worst=report["goal_duration"]["worst"],
        trajectory_sha256=report["trajectory_sha256"] or "",
        cpu_ms_per_robot_second=sum(used) if used else None,
        no_guarantee="; ".join(conditions.get("findings") or ()),
    )


def _robot(entry: Mapping[str, Any]) -> RobotRecord:
    battery = {
        key.removeprefix(BATTERY): value for key, value in entry.items() if key.startswith(BATTERY)
    }
    known = {name: entry[name] for name in OF_ROBOT if name in entry}
    return RobotRecord(**known, goal_worst=entry["worst_goal_duration"], battery=battery or None)
