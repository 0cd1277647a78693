"""Announcements of a robot: its beacon to the robots, its status and feedback to the operator."""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.beacon import (
    FLAG_ACTIVE,
    FLAG_CIRCUIT,
    FLAG_DEAF,
    FLAG_SPLIT,
    FLAG_STUCK,
    MODE_DONE,
    MODE_DRIVE,
    MODE_HOLD,
    MODE_PAUSE,
    MODE_YIELD,
    blank_beacon,
    pack_head,
    record_of,
    word_of,
)
from swarm_common.model.breaches import MISSED
from swarm_common.model.palette import BY_HAND, CHARGING
from swarm_common.model.records import CONTROL_PERIOD, RobotSpec, stamp_from_tick
from swarm_nav.behaviour.behaviors import Behavior
from swarm_nav.behaviour.goal_progress import GoalProgress
from swarm_nav.behaviour.parts import Parts
from swarm_nav.core.goals import Feedback, GoalKind, Status
from swarm_nav.core.states import State
from swarm_nav.traffic.robot_state import RobotView

MODES = {
    State.IDLE: MODE_DONE,
    State.DRIVING: MODE_DRIVE,
    State.HOLDING: MODE_HOLD,
    State.YIELDING: MODE_YIELD,
    State.RECOVERING: MODE_DRIVE,
    State.BEHAVING: MODE_DRIVE,
}
HEARD = slice(word_of("heard"), word_of("sighted_id"))
SIGHTED = slice(word_of("sighted_id"), None)
CLAIMS = slice(word_of("held"), word_of("footprint"))
NOWHERE = (math.nan, math.nan)


def compose_beacon(parts: Parts, spec: RobotSpec) -> np.void:
    """Return the beacon of this tick, with the priority and the blocks as they were published."""
    s, d, is_active = parts.robot, parts, parts.is_active
    priority = s.priority
    is_yielding = d.right.is_yielding
    flags = FLAG_STUCK if d.right.is_stuck or not is_active else 0
    flags |= FLAG_CIRCUIT if d.holding.is_on_circuit else 0
    flags |= (FLAG_ACTIVE if is_active else 0) | (FLAG_DEAF if d.senses.is_deaf else 0)
    flags |= FLAG_SPLIT if d.senses.is_split else 0
    target = d.holding.target or NOWHERE
    if is_yielding:
        x, y = s.tube.points[-1]
        target = (float(x), float(y))
    mode = MODE_PAUSE if d.goal_manager.is_pausing else MODES[d.state_machine.state]
    head = (
        *stamp_from_tick(s.tick), s.robot_id, s.tick, s.radius,
        s.pose.x, s.pose.y, s.pose.yaw, s.twist.vx, s.twist.wz,
        priority >> 32, priority & 0xFFFFFFFF, s.blocked_ticks, s.blocked_by,
        s.donations.yields_for, flags, MODE_YIELD if is_yielding else mode,
        *target, *(d.lease.station or NOWHERE), d.lease.tick, d.gate.announced,
        *s.tube.published_sizes, len(spec.footprint),
    )  # fmt: skip
    words = blank_beacon(spec.footprint).copy()
    pack_head(words, head)
    words[CLAIMS] = s.tube.published
    words[HEARD] = s.neighbors.heard(s.tick)
    words[SIGHTED] = s.neighbors.sighted(s.tick)
    return record_of(words)


def compose_status(parts: Parts, *, battery: float = math.nan, reach: float = math.inf) -> Status:
    """Return the status for the operator.

    Args:
        battery: Charge by capacity; NaN without a battery.
        reach: [m] that it can drive before it goes to charge.
    """
    s, goals, state = parts.robot, parts.goal_manager, parts.state_machine.state
    target = None if goals.asked is None else goals.asked.target
    if target is None and goals.has_goal and not goals.is_on_trip:
        target = s.pose  # a behaviour that somebody asked for: the robot is not free
    distance = 0.0 if goals.task is None else goals.task.distance_remaining(s)
    name, detail, waits = state.value, "", s.awaited
    if not parts.is_active:
        name = "inactive"
    elif parts.senses.missing:  # without a goal it is not on its way, and waits for nobody
        name, detail = "waiting" if goals.has_goal else name, parts.senses.missing
    elif state is State.IDLE and goals.is_pausing:
        name = CHARGING if goals.is_on_trip else State.BEHAVING.value
    elif state is State.IDLE:
        detail = f"{MISSED}{goals.failure}" if goals.failure else ""
    elif state is State.DRIVING and waits:
        name, detail = "waiting", waits
    else:
        by_hand = goals.behavior is not None and goals.behavior.goal.kind is GoalKind.TELEOP
        name = BY_HAND if state is State.BEHAVING and by_hand else name
        detail = parts.arbiter.why
        if state is State.DRIVING and goals.is_on_trip:
            detail = detail or "goes to charge"
    counters = s.counters
    return Status(
        state=name,
        detail=detail,
        pose_map=s.pose,
        goal_map=target,
        station=parts.lease.name_in(parts.sites),
        queue_place=parts.lease.place,
        distance_remaining=distance,
        estimated_time_remaining=distance / s.config.controller.max_vel_x,
        holding_since_tick=parts.state_machine.holding_since if state is State.HOLDING else 0,
        hold_time=counters.hold_ticks * CONTROL_PERIOD,
        wait_time=counters.wait_ticks * CONTROL_PERIOD,
        number_of_recoveries=counters.recoveries,
        goals_reached=counters.goals_reached,
        goals_failed=counters.goals_failed,
        pushes=counters.pushes,
        retreats=counters.retreats,
        deadlocks_resolved=counters.deadlocks_resolved,
        replans=counters.replans,
        battery=battery,
        reach=reach,
    )


def compose_feedback(
    robot: RobotView, goal_id: int, task: GoalProgress | None, behavior: Behavior | None
) -> Feedback:
    """Return the progress of a task, or without one of a behaviour.

    Args:
        task: The current navigation goal; None without one.
        behavior: The current behaviour; None without one.
    """
    s = robot
    navigation, rest, traveled, angle = 0.0, 0.0, 0.0, 0.0
    if task is not None:
        navigation = (s.tick - task.start_tick) * CONTROL_PERIOD
        rest = task.distance_remaining(s)
    elif behavior is not None:
        traveled, angle = behavior.distance_traveled(s), behavior.angle_traveled
    return Feedback(
        goal_id=goal_id,
        pose_map=s.pose,
        navigation_time=navigation,
        estimated_time_remaining=rest / s.config.controller.max_vel_x,
        number_of_recoveries=task.recoveries if task is not None else 0,
        distance_remaining=rest,
        poses_remaining=task.poses_remaining if task is not None else 0,
        current_waypoint=task.index if task is not None else 0,
        distance_traveled=traveled,
        angle_traveled=angle,
        speed=s.twist.vx,
    )
