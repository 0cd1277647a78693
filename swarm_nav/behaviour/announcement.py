"""What a robot tells: its beacon to the robots, its status and feedback to the operator."""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.beacon import (
    FLAG_ACTIVE,
    FLAG_DEAF,
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
from swarm_common.model.records import CONTROL_PERIOD, Pose, RobotSpec, stamp_from_tick
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.behaviors import Behavior
from swarm_nav.behaviour.task import Task
from swarm_nav.core.goals import Feedback, Status
from swarm_nav.core.priority import CLASS_DONE, CLASS_DRIVING, CLASS_HOLDING, base_priority
from swarm_nav.core.states import State
from swarm_nav.traffic.gate import Gate
from swarm_nav.traffic.holding import SAME_STATION, HoldingPattern, Lease
from swarm_nav.traffic.right_of_way import RightOfWay
from swarm_nav.traffic.situation import Situation

MODES = {
    State.IDLE: MODE_DONE,
    State.DRIVING: MODE_DRIVE,
    State.HOLDING: MODE_HOLD,
    State.YIELDING: MODE_YIELD,
    State.RECOVERING: MODE_DRIVE,
    State.BEHAVING: MODE_PAUSE,
}
HEARD = slice(word_of("heard"), None)
CLAIMS = slice(word_of("held"), word_of("footprint"))
NOWHERE = (math.nan, math.nan)
WAITING_TICKS = 10  # ticks of being blocked after which `status` says waiting


def compose_beacon(
    situation: Situation,
    spec: RobotSpec,
    state: State,
    right: RightOfWay,
    lease: Lease,
    gate: Gate,
    holding: HoldingPattern,
    last_goal_tick: int,
    has_goal: bool,
    is_active: bool,
) -> np.void:
    """Return the beacon of this tick; also stores the published priority in the situation."""
    s = situation
    rank = CLASS_DONE
    if has_goal:
        rank = CLASS_HOLDING if state in (State.HOLDING, State.BEHAVING) else CLASS_DRIVING
    s.own_priority = max(base_priority(rank, last_goal_tick, s.robot_id), lease.inherited)
    priority = max(s.own_priority, right.inherited)
    if priority != s.priority:
        s.tube.forget_requests()  # robots that acknowledged them compared another priority
    s.priority = priority
    flags = (FLAG_STUCK if s.is_stuck or not is_active else 0) | (FLAG_ACTIVE if is_active else 0)
    flags |= FLAG_DEAF if s.is_deaf else 0
    target = holding.target or NOWHERE
    if right.is_yielding:
        x, y = s.tube.points[-1]
        target = (float(x), float(y))
    sizes = map(len, s.tube.publish(s.pose, s.tick))
    head = (
        *stamp_from_tick(s.tick), s.robot_id, s.tick, s.radius,
        s.pose.x, s.pose.y, s.pose.yaw, s.twist.vx, s.twist.wz,
        priority >> 32, priority & 0xFFFFFFFF, s.blocked_ticks, s.blocked_by, s.yields_for,
        flags | holding.flags, MODE_YIELD if right.is_yielding else MODES[state],
        *target, *(lease.station or NOWHERE), lease.tick, gate.announced,
        *sizes, len(spec.footprint),
    )  # fmt: skip
    words = blank_beacon(spec.footprint).copy()
    pack_head(words, head)
    words[CLAIMS] = s.tube.published
    words[HEARD] = s.hood.heard(s.tick)
    return record_of(words)


def compose_status(
    situation: Situation,
    is_active: bool,
    state: State,
    target: Pose | None,
    lease: Lease,
    gate: Gate,
    sites: Sites,
    holding: HoldingPattern,
    holding_since: int,
    distance: float,
) -> Status:
    """Return the status for the operator."""
    s = situation
    name, detail = state.value, ""
    station = _station_name(lease, sites)
    if not is_active:
        name = "inactive"
    elif s.missing:
        name, detail = "waiting", s.missing
    elif state is State.HOLDING:
        where = "on the circuit" if holding.is_on_circuit else "parked"
        detail = f"{where}, {_queue(lease, gate, station or 'its goal')}"
    elif state is State.YIELDING:
        detail = f"makes way for Srobot{s.yields_for}" if s.yields_for else "steps back"
        if s.blocked_ticks > WAITING_TICKS:
            detail += f", waits {_blocker(s)}"
        elif s.is_stuck:
            detail += ", finds no place"
    elif state is State.DRIVING and s.blocked_ticks > WAITING_TICKS:
        name, detail = "waiting", _blocker(s)
    elif state is State.DRIVING and s.obstacle_ticks > WAITING_TICKS:
        name, detail = "waiting", "before an obstacle"
    counters = s.counters
    return Status(
        state=name,
        detail=detail,
        pose_map=s.pose,
        goal_map=target,
        station=station,
        queue_place=lease.place,
        distance_remaining=distance,
        estimated_time_remaining=distance / s.config.controller.max_vel_x,
        holding_since_tick=holding_since if state is State.HOLDING else 0,
        hold_time=counters.hold_ticks * CONTROL_PERIOD,
        wait_time=counters.wait_ticks * CONTROL_PERIOD,
        number_of_recoveries=counters.recoveries,
        goals_reached=counters.goals_reached,
        goals_failed=counters.goals_failed,
        pushes=counters.pushes,
        retreats=counters.retreats,
        deadlocks_resolved=counters.deadlocks_resolved,
        replans=counters.replans,
    )


def compose_feedback(
    situation: Situation, goal_id: int, task: Task | None, behavior: Behavior | None
) -> Feedback:
    """Return the progress of a task, or without one of a behaviour."""
    s = situation
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


def _blocker(situation: Situation) -> str:
    """Say for whom a robot stands on its way, and why."""
    return f"for Srobot{situation.blocked_by}, which {situation.blocked_why}"


def _queue(lease: Lease, gate: Gate, station: str) -> str:
    """Say for whom a robot waits that is parked."""
    if gate.is_closed:
        return f"waits for Srobot{gate.first}: the narrow region ahead is full"
    if lease.first:
        return f"waits for Srobot{lease.first}, {lease.place} before it at {station}"
    return f"waits until {station} is free"


def _station_name(lease: Lease, sites: Sites) -> str:
    if lease.station is None:
        return ""
    for name, pose in sites.stations.items():
        if math.hypot(pose.x - lease.station[0], pose.y - lease.station[1]) < SAME_STATION:
            return name
    return ""
