"""Lengths and directions of the shortest ways to goals, on a coarse copy of the map."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import dijkstra

from swarm_common.model.grid import FREE, Grid
from swarm_common.model.records import FloatArray, Pose

MOVES = ((0, 1), (1, 0), (1, 1), (1, -1))  # rows down and columns right, each edge once
STEP = 0.2  # [m] between cells of the copy
MOST_CELLS = 40_000
SHARE = 0.8  # of a robot's radius that a cell has to be free of obstacles
REACH = 2  # cells within which the direction of a way is read


class WayTable:
    """Distance fields of goals; each is computed when it is first asked for."""

    def __init__(self, grid: Grid, radius: float, finest: float = STEP) -> None:
        """Copy the map.

        Args:
            grid: The map, upright.
            radius: [m] of the smallest robot.
            finest: [m] between cells of the copy, at least.
        """
        blocked = grid.cells != FREE
        if grid.keepout is not None:
            blocked |= grid.keepout >= 100
        clear = ndimage.distance_transform_edt(~blocked) * grid.resolution
        area = blocked.size * grid.resolution**2
        step = max(finest, math.sqrt(area / MOST_CELLS), grid.resolution)
        block = max(1, round(step / grid.resolution))
        rows, columns = -(-grid.height // block), -(-grid.width // block)
        padded = np.zeros((rows * block, columns * block))
        padded[: grid.height, : grid.width] = clear
        coarse = padded.reshape(rows, block, columns, block).max((1, 3))
        self._free: NDArray[np.bool_] = coarse >= SHARE * radius
        self._step = block * grid.resolution
        self._origin = (grid.origin_x, grid.origin_y)
        # the nearest free cell of each
        self._snap = ndimage.distance_transform_edt(
            ~self._free, return_distances=False, return_indices=True
        )
        self._graph = way_graph(self._free, self._step)
        self._field = functools.lru_cache(maxsize=512)(self._make_field)

    def left(self, goal: Pose, x: float, y: float) -> float:
        """Return the length [m] of the shortest way from a place to a goal.

        Near the goal, and where the map has no way, it is the straight distance.

        Args:
            goal: In map.
            x: [m] in map.
            y: [m] in map.
        """
        straight = math.hypot(goal.x - x, goal.y - y)
        way = float(self._field(self._cell(goal.x, goal.y))[self._cell(x, y)])
        return max(straight, way) if straight > 2.0 * self._step and way < math.inf else straight

    def direction(self, goal: Pose, x: float, y: float) -> FloatArray:
        """Return (2,) the unit vector along the shortest way to a goal.

        Args:
            x: [m] in map.
            y: [m] in map.
        """
        row, column = self._cell(x, y)
        field = self._field(self._cell(goal.x, goal.y))
        top, left = max(0, row - REACH), max(0, column - REACH)
        window = field[top : row + REACH + 1, left : column + REACH + 1]
        best = np.unravel_index(int(window.argmin()), window.shape)
        target = np.array([goal.x, goal.y])
        if np.isfinite(window[best]) and window[best] > 0.0:
            cells = np.array([left + best[1], top + best[0]])
            target = np.asarray(self._origin) + (cells + 0.5) * self._step
        apart = target - (x, y)
        return np.asarray(apart / max(float(np.hypot(*apart)), 1e-9))

    def _cell(self, x: float, y: float) -> tuple[int, int]:
        height, width = self._free.shape
        row = min(max(int((y - self._origin[1]) / self._step), 0), height - 1)
        column = min(max(int((x - self._origin[0]) / self._step), 0), width - 1)
        return int(self._snap[0, row, column]), int(self._snap[1, row, column])

    def _make_field(self, cell: tuple[int, int]) -> FloatArray:
        width = self._free.shape[1]
        lengths = dijkstra(self._graph, directed=False, indices=cell[0] * width + cell[1])
        return np.asarray(lengths.reshape(self._free.shape))


def way_graph(free: NDArray[np.bool_], step: float) -> csr_matrix:
    """Return the lengths [m] of edges between free cells; nodes are flat indices.

    Args:
        free: (rows, columns) whether a robot's centre may be in a cell.
        step: [m] between neighbours in a row.
    """
    height, width = free.shape
    numbers = np.arange(free.size).reshape(free.shape)
    starts, ends, lengths = [], [], []
    for down, right in MOVES:
        here = np.s_[: height - down, max(0, -right) : width - max(0, right)]
        there = np.s_[down:, max(0, right) : width + min(0, right)]
        is_edge = free[here] & free[there]
        starts.append(numbers[here][is_edge])
        ends.append(numbers[there][is_edge])
        lengths.append(np.full(int(is_edge.sum()), step * math.hypot(down, right)))
    values, rows, columns = (np.concatenate(parts) for parts in (lengths, starts, ends))
    return coo_matrix((values, (rows, columns)), shape=(free.size, free.size)).tocsr()
