"""Speed limits: of speed zones, and of Nav2's topic `speed_limit`; the lowest counts.

Whatever drives the robot, its twist is scaled: it keeps its course, and brakes before the zone so
that its centre enters it no faster than the limit. Zones count as wider by the safety margin,
within which a robot knows where it is and follows its path.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.grid import Grid
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Twist
from swarm_common.model.zones import Geometry, Zones, geometry_of
from swarm_nav.control.controller import rate_that_stops
from swarm_nav.core.config import ControllerConfig
from swarm_nav.planning.cells import window_max
from swarm_nav.planning.planner import SPACING
from swarm_nav.traffic.robot_state import RobotView


class SpeedLimits:
    """Speed limits of a robot, here and on the way that it needs to brake."""

    def __init__(self, zones: Zones) -> None:
        self._zones = zones
        self._limit, self._is_percentage = 0.0, False  # of the topic; 0 for none

    def set(self, limit: float, *, is_percentage: bool) -> None:
        """Set a limit that counts everywhere.

        Args:
            limit: [m/s], or [%] of the largest speed of the controller; 0 for none.
            is_percentage: Whether it is in percent.
        """
        self._limit, self._is_percentage = limit, is_percentage

    def limited(self, twist: Twist, robot: RobotView) -> Twist:
        """Return a twist scaled to what is allowed here and ahead."""
        if not (self._limit or self._zones.has_speed):
            return twist
        speed = math.hypot(twist.vx, twist.vy)
        if speed == 0.0:
            return twist
        allowed = self._allowed(speed, twist, robot)
        if speed <= allowed:
            return twist
        share = allowed / speed
        return Twist(twist.vx * share, twist.vy * share, twist.wz * share)

    def _allowed(self, speed: float, twist: Twist, robot: RobotView) -> float:
        """Return the speed [m/s] for the next period from which every limit ahead can be kept."""
        s = robot
        config = s.config.controller
        everywhere = self._everywhere(config)
        if not self._zones.has_speed:
            return everywhere
        grid, margin = s.terrain.grid, s.radius - s.body_radius
        limits = _limits(self._zones, geometry_of(grid), config.max_vel_x, margin)
        acceleration = s.acceleration
        now = max(s.speed, speed)
        reach = now * CONTROL_PERIOD + now * now / (2.0 * acceleration) + SPACING
        distances = SPACING * np.arange(math.ceil(reach / SPACING) + 1, dtype=np.float64)
        tube = s.tube.points[s.tube.near : s.tube.near + len(distances)]
        allowed = everywhere
        for points in (_arc(twist, speed, s, distances), tube):
            for k, limit in enumerate(_at(points, limits, grid).tolist()):
                if limit >= now:
                    continue
                before = max(0.0, (k - 1) * SPACING)  # the zone may begin anywhere between two
                rest = before + limit * limit / (2.0 * acceleration)
                allowed = min(allowed, max(limit, rate_that_stops(rest, s.speed, acceleration)))
        return allowed

    def _everywhere(self, config: ControllerConfig) -> float:
        """Return the limit [m/s] of the topic; inf for none."""
        if not self._limit:
            return math.inf
        return self._limit * (0.01 * config.max_vel_x if self._is_percentage else 1.0)


@functools.lru_cache(maxsize=16)  # a margin that grows makes another
def _limits(
    zones: Zones, geometry: Geometry, max_speed: float, margin: float
) -> NDArray[np.float32]:
    """Return the limit (h, w) [m/s] of each cell, inf for none; zones are wider by a margin."""
    limits = zones.limits(geometry, max_speed)
    reach = math.ceil(margin / geometry[2])
    return (-window_max(-limits, reach)).astype(np.float32)


def _arc(twist: Twist, speed: float, robot: RobotView, distances: FloatArray) -> FloatArray:
    """Return the points (n, 2) in map at distances along the arc of a twist."""
    pose = robot.pose
    course = pose.yaw + math.atan2(twist.vy, twist.vx)
    turn = twist.wz / speed * distances
    middle = course + 0.5 * turn
    chord = distances * np.sinc(0.5 * turn / math.pi)
    return np.column_stack((pose.x + chord * np.cos(middle), pose.y + chord * np.sin(middle)))


def _at(points: FloatArray, limits: NDArray[np.float32], grid: Grid) -> NDArray[np.float32]:
    """Return the limits (n,) at points (n, 2) in map; inf beside the map."""
    cells = np.floor((points - (grid.origin_x, grid.origin_y)) / grid.resolution).astype(np.int64)
    columns, rows = cells.T
    inside = (rows >= 0) & (rows < limits.shape[0]) & (columns >= 0) & (columns < limits.shape[1])
    found = np.full(len(points), np.inf, np.float32)
    found[inside] = limits[rows[inside], columns[inside]]
    return found
