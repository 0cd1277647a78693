"""From what robots, world and mission say at the end of a run to its record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from swarm_common.model.breaches import Collision, MissedGoal, UnfinishedGoal
from swarm_run.record.figures import fairness, finite, per_minute, waiting
from swarm_run.record.run_record import COUNTERS, Breaches, Goals, RobotRecord, RunRecord


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotFacts:
    """Last words of a robot, and of whoever sent it about."""

    reached: int  # goals
    failed: int  # goals given up, or that it was to reach and did not
    ends: Sequence[tuple[float, float]]  # time and duration [s] of each goal reached
    is_done: bool  # whether its mission is over
    hold_time: float  # [s]
    wait_time: float  # [s]
    counts: Mapping[str, int]  # by name of `COUNTERS`
    restarts: int = 0


def compose_record(
    facts_of: Mapping[str, RobotFacts],
    goals: Goals,
    settled_time: float | None,
    verdict: Mapping[str, Any],
    *,
    missed: Sequence[MissedGoal] = (),
    unfinished: Sequence[UnfinishedGoal] = (),
    waits: Mapping[str, Any],
    is_endless: bool = False,
    **others: Any,
) -> RunRecord:
    """Return the record of a run that is over.

    Args:
        facts_of: Facts by name of the robot.
        settled_time: [s] at which the last goal was reached or given up; None without any.
        verdict: What the world measured, as `Verdict.as_json` has it.
        missed: Goals that were given up.
        unfinished: Goals under way at the end, of a run that was to reach them.
        waits: Result of `WaitGraph.as_json`.
        is_endless: Whether goals go on for as long as the run does, so that none is missed by its
            end.
        others: Further fields of the record.
    """
    served = fairness([duration for facts in facts_of.values() for _, duration in facts.ends])
    measured = verdict.get("robots", {})
    robots = {
        name: _robot(facts, measured.get(name, {}), is_endless=is_endless)
        for name, facts in facts_of.items()
    }
    breaches = Breaches(
        collisions=tuple(Collision.from_json(each) for each in verdict.get("collisions", ())),
        missed_goals=tuple(sorted(missed, key=lambda miss: miss.sim_time)),
        unfinished_goals=tuple(unfinished),
    )
    return RunRecord(
        **totals(goals, settled_time, robots, breaches, waits, is_endless=is_endless),
        robot_robot=verdict.get("robot_robot") or 0,
        robot_world=verdict.get("robot_world") or 0,
        near_misses=verdict.get("near_misses"),
        min_clearance=finite(verdict.get("min_clearance")),
        sim_time=verdict["sim_time"],
        trajectory_sha256=verdict.get("trajectory_sha256") or "",
        zones=verdict.get("zones"),
        goal_median=served.median,
        goal_worst=served.worst,
        fairness=served.ratio,
        **others,
    )


def totals(
    goals: Goals,
    settled_time: float | None,
    robots: Mapping[str, RobotRecord],
    breaches: Breaches,
    waits: Mapping[str, Any],
    *,
    is_endless: bool = False,
) -> dict[str, Any]:
    """Return the parts of a record, and its fields that follow from them."""
    asked = goals.reached + goals.failed if is_endless else goals.total
    is_complete = goals.reached == asked and not is_endless
    waited = waiting([robot.hold_time + robot.wait_time for robot in robots.values()])
    stops = (*breaches.missed_goals, *breaches.unfinished_goals)
    summed = ("hold_time", "wait_time", *COUNTERS)
    return {
        "goals": goals,
        "goals_sent": asked,
        "goals_reached": goals.reached,
        "goals_failed": asked - goals.reached,
        "settled_time": settled_time,
        "makespan": settled_time if is_complete else None,
        "throughput_per_minute": per_minute(goals.reached, settled_time),
        "breaches": breaches,
        "first_collision": str(breaches.collisions[0]) if breaches.collisions else "",
        "first_miss": str(stops[0]) if stops else "",
        "waits": waits,
        "wait_circles": waits.get("lasting_circles"),
        "longest_wait_circle": waits.get("longest_circle"),
        "wait_median": waited.median,
        "wait_worst": waited.worst,
        "per_robot": robots,
        **{name: sum(getattr(each, name) for each in robots.values()) for name in summed},
    }


def _robot(facts: RobotFacts, measured: Mapping[str, Any], *, is_endless: bool) -> RobotRecord:
    has_all = facts.is_done and facts.ends and not facts.failed and not is_endless
    return RobotRecord(
        goals_reached=facts.reached,
        goals_failed=facts.failed,
        finish_time=max(time for time, _ in facts.ends) if has_all else None,
        hold_time=facts.hold_time,
        wait_time=facts.wait_time,
        goal_worst=max((duration for _, duration in facts.ends), default=None),
        restarts=facts.restarts,
        distance=measured.get("distance"),
        collisions=measured.get("collisions"),
        near_misses=measured.get("near_misses"),
        min_clearance=finite(measured.get("min_clearance")),
        battery=measured.get("battery"),
        **facts.counts,
    )
