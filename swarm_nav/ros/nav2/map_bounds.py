"""Largest sensible distances from the map of a place, a path or an odometry reading."""

from __future__ import annotations

import math
from dataclasses import dataclass

from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_nav.core.goals import ErrorCode

AROUND = 1000.0  # [m] around the map within which a place is refused by the planner, not the door
MOST_TIMES = 100.0  # diagonals of the map that a path may be long


class OffMapError(RejectedError):
    """A place is absurdly far from the map.

    Attributes:
        code: Code of Nav2's planner for it, that of a goal or that of a start.
    """

    code = ErrorCode.GOAL_OUTSIDE_MAP


@dataclass(frozen=True, slots=True)
class MapBounds:
    """A box around the map, and its size."""

    low: tuple[float, float]  # (x, y) [m] of the map's lower left corner
    high: tuple[float, float]  # (x, y) [m] of its upper right corner

    @classmethod
    def of(cls, grid: Grid) -> MapBounds:
        """Return the bounds of an upright map.

        Args:
            grid: The map; its axes are those of the map frame.
        """
        high = (
            grid.origin_x + grid.width * grid.resolution,
            grid.origin_y + grid.height * grid.resolution,
        )
        return cls((grid.origin_x, grid.origin_y), high)

    @property
    def diagonal(self) -> float:
        """Length [m] of the map's diagonal: no straight way on it is longer."""
        return math.dist(self.low, self.high)

    @property
    def most_odometry(self) -> float:
        """Distance [m] from its origin that odometry can have on this map, however it drifts."""
        return 2.0 * self.diagonal + AROUND

    @property
    def longest_path(self) -> float:
        """Length [m] that no path on this map needs."""
        return MOST_TIMES * self.diagonal

    def has(self, pose: Pose) -> bool:
        """Whether a pose lies on the map."""
        return self._is_within(pose, 0.0)

    def check(self, pose: Pose) -> Pose:
        """Return a pose unless it is absurdly far from the map.

        Raises:
            OffMapError: If it is more than `AROUND` off the map.
        """
        if not self._is_within(pose, AROUND):
            raise OffMapError(
                f"({pose.x:g}, {pose.y:g}) is more than {AROUND:g} m off the map, which goes from"
                f" ({self.low[0]:.1f}, {self.low[1]:.1f}) to ({self.high[0]:.1f},"
                f" {self.high[1]:.1f})"
            )
        return pose

    def _is_within(self, pose: Pose, margin: float) -> bool:
        return all(
            low - margin <= value <= high + margin
            for value, low, high in zip((pose.x, pose.y), self.low, self.high, strict=True)
        )
