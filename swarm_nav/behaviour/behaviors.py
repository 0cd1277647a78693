"""Behaviours beside navigation: spin, back up, drive on heading, wait; and recoveries from them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, Twist, wrap_angle
from swarm_nav.core.goals import ErrorCode, Goal, GoalKind
from swarm_nav.interfaces import Proposal
from swarm_nav.planning.planner import path_length, straight_path
from swarm_nav.traffic.arbiter import STAND
from swarm_nav.traffic.robot_state import RobotView

SPIN_DONE = 0.03  # [rad]
TELEOP_TICKS = 5  # without a new wish after which a steered robot stops
TELEOP_REACH = 2.0  # [m] of the straight way that is asked for ahead of a steered robot
TELEOP_TURN = 0.5  # [rad] that it turns on, until the wish changes
TELEOP_LEAST = 0.02  # [m/s], [rad/s] of a wish; less is none
DRIVE_DONE = 0.05  # [m]
TIMEOUTS = {
    GoalKind.SPIN: ErrorCode.SPIN_TIMEOUT,
    GoalKind.BACKUP: ErrorCode.BACKUP_TIMEOUT,
    GoalKind.TELEOP: ErrorCode.TELEOP_TIMEOUT,
}
DRIVE_COLLISIONS = {GoalKind.BACKUP: ErrorCode.BACKUP_COLLISION_AHEAD}


@dataclass(frozen=True, slots=True)
class BehaviorEnd:
    """Result of a behaviour; NONE is success."""

    code: ErrorCode = ErrorCode.NONE
    message: str = ""


class Behavior:
    """One run of SPIN, BACKUP, DRIVE_ON_HEADING, WAIT or TELEOP; `end` is None while it runs."""

    def __init__(self, goal: Goal, robot: RobotView) -> None:
        """Start at the present pose and tick.

        Args:
            goal: A goal of kind SPIN, BACKUP, DRIVE_ON_HEADING, WAIT or TELEOP.
        """
        self.goal = goal
        self._start_tick = robot.tick
        self._start: Pose = robot.pose
        self._last_yaw = robot.pose.yaw
        self.angle_traveled = 0.0
        self._is_pathed = False
        self._driven = 0.0  # [m] before the last interruption
        self._traveled = 0.0  # [m] at the last step
        self.end: BehaviorEnd | None = None
        self._wish, self._wish_tick = Twist(), robot.tick
        self._room = 0.0  # [m] of the present way
        self._way = 0  # of a steered robot: 1 ahead, -1 back, 0 neither

    def steer(self, wish: Twist, tick: int) -> None:
        """Receive the twist that an operator wants now; it counts for TELEOP."""
        self._wish, self._wish_tick = wish, tick

    def finish(self, end: BehaviorEnd) -> None:
        """End at the next step."""
        self.end = end

    def resume(self, robot: RobotView) -> None:
        """Continue with the rest of the behaviour after the robot made way for another one."""
        self._last_yaw = robot.pose.yaw
        self._driven = self._traveled
        self._start = robot.pose
        self._is_pathed = False

    def propose(self, robot: RobotView) -> Proposal:
        """Return the motion of this tick; `end` tells when the behaviour is over."""
        self.angle_traveled += wrap_angle(robot.pose.yaw - self._last_yaw)
        self._last_yaw = robot.pose.yaw
        self._traveled = self.distance_traveled(robot)
        elapsed = (robot.tick - self._start_tick) * CONTROL_PERIOD
        kind = self.goal.kind
        if kind is GoalKind.WAIT:
            if elapsed >= self.goal.duration:
                self.end = BehaviorEnd()
            return STAND
        if self.goal.duration > 0.0 and elapsed > self.goal.duration:
            code = TIMEOUTS.get(kind, ErrorCode.DRIVE_TIMEOUT)
            self.end = BehaviorEnd(code, f"not done after {self.goal.duration:.1f} s")
            return STAND
        if kind is GoalKind.SPIN:
            return self._spin(robot)
        if kind is GoalKind.TELEOP:
            return self._teleop(robot)
        return self._drive(robot)

    def distance_traveled(self, robot: RobotView) -> float:
        """Return the distance [m] from the start, without ways to make way."""
        return self._driven + self._start.distance(robot.pose)

    def _spin(self, robot: RobotView) -> Proposal:
        rest = self.goal.angle - self.angle_traveled
        if abs(rest) < SPIN_DONE:
            self.end = BehaviorEnd()
            return STAND
        return Proposal(stands=True, yaw=robot.pose.yaw + max(-1.5, min(1.5, rest)))

    def _teleop(self, robot: RobotView) -> Proposal:
        """Turn on the spot, or drive straight as far as there is room: never into anything."""
        twist = robot.twist
        wish = self._wish if robot.tick - self._wish_tick <= TELEOP_TICKS else Twist()
        is_turn = abs(wish.wz) > max(TELEOP_LEAST, abs(wish.vx))
        way = 0 if is_turn or abs(wish.vx) < TELEOP_LEAST else (1 if wish.vx > 0.0 else -1)
        is_new = way != self._way
        if is_new:
            self._way, self._is_pathed = way, False
        path = None
        if not self._is_pathed:
            if not robot.is_standing:
                if not is_turn or abs(twist.vx) > TELEOP_LEAST:
                    return Proposal(drops_path=is_new, stands=True)
            elif way:
                path = self._straight_ahead(robot, way)
        if is_turn:
            yaw = robot.pose.yaw + math.copysign(TELEOP_TURN, wish.wz)
            return Proposal(drops_path=is_new, stands=True, yaw=yaw, most_rate=abs(wish.wz))
        if not self._is_pathed:
            return Proposal(drops_path=is_new, stands=True)
        if self._start.distance(robot.pose) > self._room - DRIVE_DONE:
            self._is_pathed = False
            return Proposal(drops_path=True, stands=True)
        return Proposal(
            drops_path=is_new,
            holds_place=path is not None,
            path=path,
            is_reverse=way < 0,
            most_speed=abs(wish.vx),
        )

    def _straight_ahead(self, robot: RobotView, way: int) -> FloatArray | None:
        """Return the free part of the straight way (n, 2) ahead, or behind for way -1."""
        path = straight_path(robot.pose, way * TELEOP_REACH)
        floor = robot.body_radius + robot.config.costmap.footprint_padding
        clear = (robot.terrain.clearances(path, floor) >= floor).tolist()
        room = clear.index(False, 1) if False in clear[1:] else len(clear)
        if room <= 2:
            return None
        self._is_pathed, self._start = True, robot.pose
        self._room = float(path_length(path[:room]))
        return path[:room]

    def _drive(self, robot: RobotView) -> Proposal:
        is_reverse = self.goal.is_reverse or self.goal.kind is GoalKind.BACKUP
        path = None
        if not self._is_pathed:
            if not robot.is_standing:
                return STAND  # the held space ends ahead, not behind
            self._is_pathed = True
            rest = self.goal.distance - self._driven
            path = straight_path(robot.pose, -rest if is_reverse else rest)
            floor = robot.body_radius + robot.config.costmap.footprint_padding
            bad = np.flatnonzero(robot.terrain.clearances(path, floor)[1:] < floor)
            if len(bad):
                x, y = path[1 + bad[0]].tolist()
                zone = robot.terrain.is_in_keepout(x, y, floor)
                code = DRIVE_COLLISIONS.get(self.goal.kind, ErrorCode.DRIVE_COLLISION_AHEAD)
                self.end = BehaviorEnd(
                    code, f"a {'keepout zone' if zone else 'wall'} is in the way"
                )
                return STAND
        if self.distance_traveled(robot) >= self.goal.distance - DRIVE_DONE:
            self.end = BehaviorEnd()
            return Proposal(drops_path=True, stands=True)
        return Proposal(
            holds_place=path is not None,
            path=path,
            is_reverse=is_reverse,
            most_speed=self.goal.speed if self.goal.speed > 0.0 else math.inf,
        )


def recovery_goal(attempt: int, robot: RobotView) -> Goal | None:
    """Return the behaviour of the n-th recovery (0: clear only → None), in Nav2's order."""
    behavior = robot.config.behavior
    choice = attempt % 4
    if choice == 1:
        return Goal(
            kind=GoalKind.BACKUP,
            distance=behavior.backup_dist,
            speed=behavior.backup_speed,
            duration=4.0 * behavior.backup_dist / behavior.backup_speed,
        )
    if choice == 2:
        return Goal(kind=GoalKind.SPIN, angle=behavior.spin_dist, duration=20.0)
    if choice == 3:
        return Goal(kind=GoalKind.WAIT, duration=behavior.wait_duration)
    return None
