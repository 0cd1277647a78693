"""Shortest ways on a map to the goals of some robots, as a policy and its reward know them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy import ndimage

from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray
from swarm_nav.planning.distance_kernels import Frame
from swarm_nav.planning.search import SearchSpace
from swarm_nav.planning.search_kernels import WALL
from swarm_workbench import observation_kernels

AHEAD = 0.7  # [m] of the way up to the point that a robot is shown
CELL = 0.1  # [m] about, of the cells that are searched
KEPT = 0.3  # [m] beyond a robot's circle within which a metre counts more
NEAR_WALLS = 2.0  # times, beside a wall, that a metre counts more


class ShortestWays:
    """Ways of some robots, which all are of one size.

    A way is the shortest one that has room for the robot's circle, where a metre near walls counts
    up to three times.

    Attributes:
        left: (n,) [m] to the goals, as they count.
        ahead: (n, 2) [m] in map, where the robots are to be `AHEAD` later.
    """

    def __init__(self, grid: Grid, radius: float, count: int) -> None:
        """Find out where a robot has room.

        Args:
            radius: [m] of the robots.
        """
        share = max(1, round(CELL / grid.resolution))
        step = share * grid.resolution
        room = ndimage.distance_transform_edt(grid.cells == 0) * grid.resolution
        rows, columns = (-(-size // share) for size in room.shape)
        padded = np.zeros((rows * share, columns * share))
        padded[: room.shape[0], : room.shape[1]] = room
        room = padded.reshape(rows, share, columns, share).max(axis=(1, 3))
        base = 1.0 + NEAR_WALLS * np.clip(1.0 - (room - radius) / KEPT, 0.0, 1.0)
        self._base = np.where(room < radius, WALL, base).astype(np.float32)
        if not (self._base < WALL).any():
            raise ConfigError(f"the map has no place where a robot of radius {radius:.2f} m stands")
        self._search: SearchSpace | None = None
        self._frame = Frame(grid.origin_x, grid.origin_y, step)
        gaps, nearest = ndimage.distance_transform_edt(self._base >= WALL, return_indices=True)
        self._nearest, self._gaps = tuple(nearest), (gaps * step).astype(np.float32)
        self._steps = round(AHEAD / step)
        self._goals = np.zeros((count, 2))
        self._lengths = np.zeros((count, *self._base.shape), np.float32)
        self.left, self.ahead = np.zeros(count), np.zeros((count, 2))

    def set_goal(self, robot: int, goal: FloatArray) -> None:
        """Find the ways of a robot from everywhere to a goal (2,) [m] in map."""
        row, column = self._cell(goal)
        if self._search is None:
            no_lanes = np.zeros_like(self._base), np.zeros((*self._base.shape, 2), np.float32)
            self._search = SearchSpace(self._base, *no_lanes, self._frame.step)
        costs = self._search.cost_to_go(row * self._base.shape[1] + column)
        costs[~np.isfinite(costs)] = 2.0 * costs[np.isfinite(costs)].max() + 1.0
        self._lengths[robot] = costs[self._nearest] + 2.0 * self._gaps  # out of walls, too
        self._goals[robot] = goal

    def follow(self, poses: FloatArray) -> None:
        """Update `left` and `ahead` of the first robots, which are at poses (m, 3) in map."""
        count = len(poses)
        goals, ahead = self._goals[:count], self.ahead[:count]
        observation_kernels.along_ways(
            self._lengths[:count], self._frame, poses, self._steps, self.left, ahead
        )
        is_near = np.hypot(*(goals - poses[:, :2]).T) < AHEAD
        ahead[is_near] = goals[is_near]

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy needs: it makes the search anew, which cannot be copied."""
        return {**vars(self), "_search": None}

    def _cell(self, point: FloatArray) -> tuple[int, int]:
        """Return row and column of the cell with room that is nearest to a point (2,) in map."""
        height, width = self._base.shape
        column = math.floor((point[0] - self._frame.origin_x) / self._frame.step)
        row = math.floor((point[1] - self._frame.origin_y) / self._frame.step)
        place = min(max(row, 0), height - 1), min(max(column, 0), width - 1)
        rows, columns = self._nearest
        return int(rows[place]), int(columns[place])
