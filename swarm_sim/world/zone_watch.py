"""Ground truth about zones: who was in a keepout zone, and who was faster than allowed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_common.model.records import CONTROL_PERIOD, FloatArray, RobotSpec
from swarm_common.model.zones import Zones, keepout_area

SHARE, EXTRA = 0.05, 0.005  # of the limit, and [m/s], by which a speed may be above it


@dataclass(frozen=True, slots=True)
class ZoneVerdict:
    """Events in the zones of a world; times are sums over robots."""

    keepout_entries: int  # times that a footprint came into a keepout zone, or began in one
    keepout_time: float  # [s] in which a footprint was in one
    speed_violations: int  # times that a robot became faster than a speed zone allows
    speed_violation_time: float  # [s] in which one was
    first: str  # who, where and when; empty if nobody was


class ZoneWatch:
    """Counts, tick by tick, what robots must not do in zones."""

    def __init__(self, zones: Zones) -> None:
        """Begin at tick 0."""
        self._zones = zones
        self._area = keepout_area(zones)
        self._inside: set[int] = set()  # robots that are in a keepout zone
        self._speeding: set[int] = set()
        self._entries = self._violations = 0
        self._ticks_inside = self._ticks_speeding = 0
        self._first = ""

    def observe(
        self,
        time: float,
        names: Sequence[str],
        specs: Sequence[RobotSpec],
        poses: FloatArray,
        speeds: FloatArray,
    ) -> None:
        """Record the state at the end of a control period."""
        inside = {i for i in self._near(specs, poses) if self._overlaps(specs[i], poses[i])}
        for robot in sorted(inside - self._inside):
            self._entries += 1
            self._tell(f"{names[robot]} came into a keepout zone", poses[robot], time)
        speeding = set()
        if self._zones.has_speed:
            for robot, (speed, (x, y, _)) in enumerate(zip(speeds, poses, strict=True)):
                limit = self._zones.limit_at(x, y, specs[robot].max_vel_x)
                if speed > limit * (1.0 + SHARE) + EXTRA:
                    speeding.add(robot)
                    if robot not in self._speeding:
                        self._violations += 1
                        what = f"{names[robot]} drove {speed:.3f} m/s where {limit:.3f} are allowed"
                        self._tell(what, poses[robot], time)
        self._inside, self._speeding = inside, speeding
        self._ticks_inside += len(inside)
        self._ticks_speeding += len(speeding)

    def _near(self, specs: Sequence[RobotSpec], poses: FloatArray) -> list[int]:
        """Return the robots whose circle comes into a keepout zone."""
        import shapely

        if not self._zones.has_keepout:
            return []
        radii = np.array([spec.circumscribed_radius for spec in specs])
        points = shapely.points(poses[:, 0], poses[:, 1])
        return np.flatnonzero(shapely.dwithin(self._area, points, radii)).tolist()

    def _overlaps(self, spec: RobotSpec, pose: FloatArray) -> bool:
        import shapely

        x, y, yaw = pose.tolist()
        cos, sin = math.cos(yaw), math.sin(yaw)
        corners = [(x + cos * a - sin * b, y + sin * a + cos * b) for a, b in spec.footprint]
        return bool(shapely.Polygon(corners).intersection(self._area).area > 0.0)

    def _tell(self, what: str, pose: FloatArray, time: float) -> None:
        self._first = self._first or f"{what}, at ({pose[0]:.2f}, {pose[1]:.2f}), t = {time:.1f} s"

    @property
    def verdict(self) -> ZoneVerdict:
        """The counts so far."""
        return ZoneVerdict(
            keepout_entries=self._entries,
            keepout_time=round(self._ticks_inside * CONTROL_PERIOD, 6),
            speed_violations=self._violations,
            speed_violation_time=round(self._ticks_speeding * CONTROL_PERIOD, 6),
            first=self._first,
        )
