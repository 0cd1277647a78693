"""A robot that obeys twists, as far as space that it has reserved lets it.

Requests, held space, beacon and stop filter are those of its navigator; only the path and the twist
come from outside.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Pose, RobotSpec, Twist
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, GoalKind
from swarm_nav.interfaces import Proposal
from swarm_nav.planning.planner import SPACING
from swarm_nav.planning.terrain import NODE_MARGIN
from swarm_nav.reservation.stop_filter_kernels import gap_to_line
from swarm_nav.traffic.robot_state import RobotView

REACH = 12  # path points that are asked for ahead
FEWEST = 8  # of them that are left before more are asked for
NEAR = (1, 3, 5)  # of the way on which a path that serves it must lie
SERVES = 0.02  # [m] of these from a path that serves
LEAST = 1e-3  # [m/s] of a wish to drive
SHORT = 4  # points of a way up to a wall, beyond which it is left as it is
BENDS = tuple(0.05 * k * sign for k in range(1, 9) for sign in (1, -1))  # [rad] between two points
STANDING = 0.02  # [m/s]
TURN = 0.4  # [rad] between two points of a way


class SteeredNavigator:
    """Drives `wish` as the stop filter admits, on a path that it asks for where that leads.

    A wish about to end at a wall is bent to the nearest arc that passes it, or gets furthest.

    It is the pilot of a navigator (`swarm_nav.traffic.arbiter.TwistPilot`).

    Attributes:
        wish: Twist in base_footprint; a standstill at the start.
        navigator: Receives observations, and decides each tick.
    """

    def __init__(
        self,
        config: NavConfig,
        spec: RobotSpec,
        grid: Grid,
        sites: Sites,
        robot_id: int,
        initial_pose_map: Pose,
    ) -> None:
        """Stand; the arguments are those of `Navigator`."""
        traffic = dataclasses.replace(config.traffic, rules="keep_apart stop_before_obstacle")
        controller = dataclasses.replace(config.controller, corner_angle=math.pi)  # stops at none
        config = dataclasses.replace(config, traffic=traffic, controller=controller)
        self.wish = Twist()
        self._most_turn = spec.max_vel_theta
        self._bend = 0.0  # [rad] between two points of the way, beside that of the wish
        self.navigator = Navigator(
            config, spec, grid, sites, robot_id, initial_pose_map, pilot=self
        )
        self.navigator.set_goal(Goal(kind=GoalKind.TELEOP))  # it ranks as robots that drive

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return where the wish leads, unless the present path does; the last of its rules."""
        way, tube, keep = self._way(robot), robot.tube, robot.brake_points
        stand = Proposal(keep_ahead=keep, drops_path=True, stands=True)
        if len(way) < 2:
            return stand
        last = len(tube.points) - 1
        served = [way[index] for index in NEAR if index < len(way)]
        if last - tube.near >= min(FEWEST, len(way) - 1) and all(
            gap_to_line(tube.points, tube.near, last, x, y) < SERVES for x, y in served
        ):
            return None
        if robot.is_standing:
            return Proposal(holds_place=True, path=way)
        stop = np.array(robot.stop_point_after(keep))
        along = (stop - way[0]) @ (way[1] - way[0]) / SPACING
        if along < -SPACING:  # it still drives the other way
            return stand
        rest = way[max(1, math.ceil(along / SPACING)) :]
        path = np.vstack((stop, rest)) if len(rest) else None
        return Proposal(keep_ahead=keep, drops_path=True, path=path)

    def steer(self, robot: RobotView, stands: bool) -> Twist:
        """Return the wish; where the robot must stand, its turn."""
        if not stands:
            return self._bent()
        return Twist(wz=self.wish.wz if robot.speed < STANDING else 0.0)

    def _bent(self) -> Twist:
        wish, speed = self.wish, self._speed()
        if not self._bend or speed < LEAST:
            return wish
        turn = self._turn(speed) + self._bend
        share = min(1.0, self._most_turn * SPACING / (abs(turn) * speed)) if turn else 1.0
        return Twist(wish.vx * share, wish.vy * share, turn * share * speed / SPACING)

    def _speed(self) -> float:
        return math.hypot(self.wish.vx, self.wish.vy)

    def _turn(self, speed: float) -> float:
        return max(-TURN, min(TURN, self.wish.wz * SPACING / speed))

    def _way(self, robot: RobotView) -> FloatArray:
        """Return the points (n, 2) [m] in map to which the wish leads, up to a wall."""
        self._bend = 0.0
        speed = self._speed()
        if speed < LEAST:
            return np.zeros((0, 2))
        turn = self._turn(speed)
        way = self._arc(robot, turn)
        if len(way) > SHORT:
            return way
        for bend in BENDS:
            arc = self._arc(robot, turn + bend)
            if len(arc) > len(way):
                self._bend, way = bend, arc
            if len(way) > FEWEST:
                break
        return way

    def _arc(self, robot: RobotView, turn: float) -> FloatArray:
        wish, pose = self.wish, robot.pose
        courses = pose.yaw + math.atan2(wish.vy, wish.vx) + turn * (np.arange(REACH) + 0.5)
        steps = SPACING * np.column_stack((np.cos(courses), np.sin(courses)))
        way = np.vstack(((pose.x, pose.y), steps)).cumsum(axis=0)
        floor = robot.body_radius + NODE_MARGIN  # as planned paths: `TOLERANCE` beside it is free
        bad = np.flatnonzero(robot.terrain.clearances(way, floor)[1:] < floor)
        return way[: bad[0] + 1] if len(bad) else way
