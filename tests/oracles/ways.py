"""Shortest ways of a lone robot over a map, without lanes and without a planner of ours."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import Pose, wrap_angle

STEP = 0.1  # [m] between nodes
REACH = 3  # nodes of the longest move: 32 directions, ways at most 1.4 % too long
SMOOTHED = 11  # moves over which a direction is averaged before turns are summed up


class WayTable:
    """Shortest ways at a clearance from everything."""

    def __init__(self, grid: Grid, clearance: float) -> None:
        """Take a map (0.05 m or finer) and the clearance [m] of the robot's centre."""
        every = round(STEP / grid.resolution)
        distance = ndimage.distance_transform_edt(grid.cells < OCCUPIED / 2) * grid.resolution
        middle = every // 2
        self._free = distance[middle::every, middle::every] >= clearance
        offset = (middle + 0.5) * grid.resolution
        self._origin = (grid.origin_x + offset, grid.origin_y + offset)
        self._moves = self._edges()

    def length_and_turns(self, start: Pose, goal: Pose) -> tuple[float, float]:
        """Return the length [m] of the shortest way and all that a robot turns on it [rad]."""
        source, target = self._node(start), self._node(goal)
        length, previous = dijkstra(self._moves, indices=source, return_predecessors=True)
        way = [target]
        while way[-1] != source:
            way.append(previous[way[-1]])
        rows, columns = np.divmod(np.array(way[::-1]), self._free.shape[1])
        headings = np.unwrap(np.arctan2(np.diff(rows), np.diff(columns)))
        smooth = ndimage.uniform_filter1d(headings, SMOOTHED)
        ends = wrap_angle(smooth[0] - start.yaw), wrap_angle(goal.yaw - smooth[-1])
        turns = float(np.abs(np.diff(smooth)).sum()) + sum(map(abs, ends))
        return float(length[target]), turns

    def _node(self, pose: Pose) -> int:
        column = round((pose.x - self._origin[0]) / STEP)
        row = round((pose.y - self._origin[1]) / STEP)
        assert self._free[row, column], f"{pose} is too near to a wall"
        return row * self._free.shape[1] + column

    def _edges(self) -> coo_matrix:
        sources, targets, lengths = [], [], []
        nodes: NDArray[np.int64] = np.arange(self._free.size).reshape(self._free.shape)
        padded = np.pad(np.where(self._free, nodes, -1), REACH, constant_values=-1)
        height, width = self._free.shape
        for up in range(-REACH, REACH + 1):
            for right in range(-REACH, REACH + 1):
                if math.gcd(up, right) != 1:
                    continue
                rows = slice(REACH + up, REACH + up + height)
                others = padded[rows, REACH + right : REACH + right + width]
                possible = self._free & (others >= 0)
                sources.append(nodes[possible])
                targets.append(others[possible])
                lengths.append(np.full(possible.sum(), math.hypot(up, right) * STEP))
        rows_and_columns = (np.concatenate(sources), np.concatenate(targets))
        shape = (self._free.size, self._free.size)
        return coo_matrix((np.concatenate(lengths), rows_and_columns), shape).tocsr()
