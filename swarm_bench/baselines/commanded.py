"""A robot that drives where a centre lets it, and reports where it is.

It overhears the others' reports, so that its LiDAR sees only what is no robot.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_bench.baselines.base import Baseline
from swarm_central.team import RobotReport, TeamOrder
from swarm_common.model.beacon import Reception
from swarm_common.model.central import places_seen
from swarm_common.model.records import Pose, Scan, Twist, wrap_angle
from swarm_nav.control.controller import rate_that_stops

REACHED = 0.03  # [m] from a point at which it is left behind
STRAIGHT = 0.2  # [rad] of a bend that is driven through
CARROT = 0.25  # [m] ahead to the place that is steered to
LEAST_ERROR = 0.12  # [rad] of the heading at which a standing robot turns first
MOST_ERROR = 0.5  # [rad] likewise of one that drives
SEEN_GAP = 0.05  # [m] that the robot's circle keeps from what its LiDAR sees ahead

Point = tuple[float, float]


class CommandedDriver(Baseline):
    """Follows the points of the newest order and stops at the last one, or before what it sees."""

    def prepare(self) -> None:
        """Begin without an order."""
        self._points: dict[int, Point] = {}
        self._passed = 1  # number of points left behind: the next one's index
        self._last = 0  # index of the point to stop at
        self._heard = 0
        self._has_scans = False

    def begin(self, target: Pose) -> None:
        """Nothing to do: the centre plans."""

    def on_scan(self, scan: Scan) -> None:
        """Receive a scan."""
        self._has_scans = True
        super().on_scan(scan)

    def on_reception(self, reception: Reception) -> None:
        """Receive what is overheard of the others; only who sees needs it."""
        if self._has_scans:
            super().on_reception(reception)

    def overhear(self, tick: int) -> None:
        """Take in what is overheard, likewise."""
        if self._has_scans:
            super().overhear(tick)

    def take_order(self, order: TeamOrder) -> None:
        """Receive an order; ignore it if a newer one came first."""
        if order.number <= self._heard:
            return
        self._heard = order.number
        self._points.update(enumerate(order.points_map, order.first))
        self._last = order.first + len(order.points_map) - 1

    def report(self) -> RobotReport:
        """Return what the centre is to know after this tick."""
        goal = self._goal or self._pending
        pose = goal.poses_map[0] if goal is not None else Pose(math.nan, math.nan, 0.0)
        return RobotReport(
            robot_id=self.robot_id,
            tick=self.tick_now,
            pose_map=self.pose,
            passed=self._passed,
            heard=self._heard,
            goal_id=0 if goal is None else goal.goal_id,
            goal_map=(pose.x, pose.y),
            has_arrived=self._has_arrived and self._goal is not None,
            seen_map=places_seen(self.obstacles.points, self.pose),
        )

    def rest(self) -> Twist:
        """Make way as far as the centre says."""
        return self._follow()

    def drive(self, target: Pose) -> Twist:
        """Return the twist along the points of the order."""
        return self._follow()

    def _follow(self) -> Twist:
        if self._last == 0:
            return Twist()
        while self._passed < self._last and self._has_passed():
            self._points.pop(self._passed - 1, None)
            self._passed += 1
        end, rest = self._stop_ahead()
        target = self._points[self._passed]
        gap = math.dist((self.pose.x, self.pose.y), target)
        if end == self._passed and gap < REACHED:
            return Twist()
        ahead = self._carrot(target)
        error = wrap_angle(
            math.atan2(ahead[1] - self.pose.y, ahead[0] - self.pose.x) - self.pose.yaw
        )
        if abs(error) > (LEAST_ERROR if self.is_standing else MOST_ERROR):
            return self._turner.turn_to(self.pose.yaw + error, self.pose, self.twist)
        limits = self.config.controller
        rest = min(rest, self._clear_ahead())
        speed = min(limits.max_vel_x, rate_that_stops(rest, self.twist.vx, limits.acc_lim_x))
        rate = 2.0 * max(speed, 0.05) * math.sin(error) / CARROT
        return Twist(speed, 0.0, max(-limits.max_vel_theta, min(limits.max_vel_theta, rate)))

    def _clear_ahead(self) -> float:
        """Return the way [m] straight ahead to what the LiDAR sees in it; inf if that is free."""
        if len(self.obstacles.points) == 0:
            return math.inf
        marks = self.obstacles.points - (self.pose.x, self.pose.y)
        cos, sin = math.cos(self.pose.yaw), math.sin(self.pose.yaw)
        ahead, beside = marks @ (cos, sin), np.abs(marks @ (-sin, cos))
        radius = self.radius + SEEN_GAP
        way = ahead - np.sqrt(np.maximum(radius**2 - beside**2, 0.0))
        return max(0.0, float(way[(beside < radius) & (ahead > 0.0)].min(initial=math.inf)))

    def _bend(self, index: int) -> float:
        """Return the change of direction [rad] at a point that is not the last."""
        before, here, after = (self._points[index + k] for k in (-1, 0, 1))
        first = math.atan2(here[1] - before[1], here[0] - before[0])
        second = math.atan2(after[1] - here[1], after[0] - here[0])
        return abs(wrap_angle(second - first))

    def _has_passed(self) -> bool:
        """Whether the next point, which is not the last, is left behind."""
        before, here = self._points[self._passed - 1], self._points[self._passed]
        dx, dy = here[0] - before[0], here[1] - before[1]
        length = math.hypot(dx, dy)
        if length < 1e-6:
            return True
        rest = ((here[0] - self.pose.x) * dx + (here[1] - self.pose.y) * dy) / length
        if self._bend(self._passed) <= STRAIGHT:
            return rest <= REACHED
        return rest <= REACHED and self.is_standing

    def _stop_ahead(self) -> tuple[int, float]:
        """Return the index of the next point to stop at, and the distance [m] to it."""
        before = self._points[self._passed - 1]
        here = self._points[self._passed]
        dx, dy = here[0] - before[0], here[1] - before[1]
        length = max(1e-9, math.hypot(dx, dy))
        rest = ((here[0] - self.pose.x) * dx + (here[1] - self.pose.y) * dy) / length
        index = self._passed
        while index < self._last and self._bend(index) <= STRAIGHT:
            rest += math.dist(self._points[index], self._points[index + 1])
            index += 1
        return index, max(0.0, rest)

    def _carrot(self, target: Point) -> Point:
        """Return the place ahead on the line through the next point, beyond it if need be."""
        before = self._points[self._passed - 1]
        dx, dy = target[0] - before[0], target[1] - before[1]
        length = math.hypot(dx, dy)
        if length < 1e-6:
            return target
        ux, uy = dx / length, dy / length
        along = (self.pose.x - before[0]) * ux + (self.pose.y - before[1]) * uy + CARROT
        return before[0] + along * ux, before[1] + along * uy
