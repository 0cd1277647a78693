"""Global planner: A* on the lattice, smoothed to a path that a differential drive can follow."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_common.records import FloatArray, Pose
from swarm_nav import distance_kernels, search_kernels
from swarm_nav.config import CostmapConfig, PlannerConfig
from swarm_nav.goals import ErrorCode, PlanError
from swarm_nav.terrain import NODE_MARGIN, Lattice, Terrain

SPACING = 0.05  # [m] between the points of a path
SMOOTH_PASSES = 3
SMOOTH_REACH = 4  # points on either side


class Planner:
    """Plans on one terrain; `extra` is the lattice of costs that other robots add."""

    def __init__(self, terrain: Terrain, planner: PlannerConfig, costmap: CostmapConfig) -> None:
        """Keep the terrain and allocate the work arrays."""
        self.terrain = terrain
        self._config = planner
        self._costmap = costmap
        self._nodes = np.empty(terrain.lattice.base.size, np.int64)
        self.expansions = 0  # of the last search

    @property
    def lattice(self) -> Lattice:
        """The lattice that is searched."""
        return self.terrain.lattice

    def no_extra(self) -> NDArray[np.float32]:
        """Return an `extra` lattice that adds nothing."""
        return np.zeros(self.lattice.base.shape, np.float32)

    def plan(
        self, start: tuple[float, float], goal: tuple[float, float], extra: NDArray[np.float32]
    ) -> FloatArray:
        """Return a path (n, 2) [m] in map from start to goal, points `SPACING` apart.

        Optimal on the lattice (A* with an exact static heuristic). A goal inside the clearance of
        a wall is moved by at most the planner's tolerance.

        Raises:
            PlanError: With Nav2's code, if start or goal is unusable or no path exists.
        """
        start_node = self._start_node(start)
        goal_node, goal = self._goal_node(goal)
        lattice = self.lattice
        count, self.expansions = search_kernels.astar(
            lattice.base,
            lattice.lane,
            lattice.heading,
            extra,
            lattice.step,
            start_node,
            goal_node,
            self.terrain.cost_to_go(goal_node),
            self._nodes,
        )
        if count == 0:
            raise PlanError(
                ErrorCode.NO_VALID_PATH,
                f"no path from ({start[0]:.2f}, {start[1]:.2f}) to ({goal[0]:.2f}, {goal[1]:.2f}):"
                " every way is closed by walls or obstacles",
            )
        points = lattice.points_of(self._nodes[:count])
        return self.finish(points, start, goal, extra, True)

    def plan_through(self, points: Sequence[tuple[float, float]]) -> FloatArray:
        """Return the path (n, 2) from the first point through the others, robots aside.

        Raises:
            PlanError: With Nav2's code, if there is none.
        """
        pieces = [self.plan(a, b, self.no_extra()) for a, b in itertools.pairwise(points)]
        if not pieces:
            return np.zeros((0, 2))
        return np.vstack((pieces[0], *(piece[1:] for piece in pieces[1:])))

    def nearest(
        self,
        start: tuple[float, float],
        extra: NDArray[np.float32],
        places: NDArray[np.uint8],
        reach: float,
        smooth: bool = True,
    ) -> FloatArray | None:
        """Return the path to the cheapest node with places > 0 within cost `reach`, if any."""
        node = self.lattice.node_of(*start, extra)
        if node is None:
            return None
        lattice = self.lattice
        count = search_kernels.nearest_place(
            lattice.base, extra, places, lattice.step, node, reach, self._nodes
        )
        if count == 0:
            return None
        points = lattice.points_of(self._nodes[:count])
        goal = (float(points[-1, 0]), float(points[-1, 1]))
        return self.finish(points, start, goal, extra, smooth)

    def finish(
        self,
        points: FloatArray,
        start: tuple[float, float],
        goal: tuple[float, float],
        extra: NDArray[np.float32],
        smooth: bool,
    ) -> FloatArray:
        """Replace the end nodes by the exact ends, resample and smooth."""
        inner = points[1:-1] if len(points) > 2 else points[:0]
        # nodes beside the exact ends would make hooks
        near = np.minimum(np.hypot(*(inner - start).T), np.hypot(*(inner - goal).T))
        inner = inner[near > self.lattice.step]
        path = _resampled(np.vstack((start, inner, goal)))
        if smooth and len(path) > 2:
            smoothed = np.empty_like(path)
            distance_kernels.smooth_path(
                path,
                SMOOTH_PASSES,
                SMOOTH_REACH,
                self.terrain.distance,
                self.terrain.frame,
                self._costmap.wall_clearance,
                extra,
                self.lattice.frame,
                smoothed,
            )
            distance_kernels.lift_off_walls(
                smoothed, self.terrain.distance, self.terrain.frame, self._costmap.wall_clearance, 6
            )
            path = _resampled(smoothed)
        return path

    def _start_node(self, start: tuple[float, float]) -> int:
        if not self.terrain.grid.contains(*start):
            raise PlanError(
                ErrorCode.START_OUTSIDE_MAP,
                f"the start ({start[0]:.2f}, {start[1]:.2f}) lies outside the map",
            )
        node = self.lattice.node_of(*start)
        if node is None:
            raise PlanError(
                ErrorCode.START_OCCUPIED,
                f"the start ({start[0]:.2f}, {start[1]:.2f}) is"
                f" {self.terrain.clearance(*start):.2f} m from a wall; the robot does not fit",
            )
        return node

    def _goal_node(self, goal: tuple[float, float]) -> tuple[int, tuple[float, float]]:
        """Return the goal's node and the point to drive to."""
        if not self.terrain.grid.contains(*goal):
            raise PlanError(
                ErrorCode.GOAL_OUTSIDE_MAP,
                f"the goal ({goal[0]:.2f}, {goal[1]:.2f}) lies outside the map",
            )
        clear = self.terrain.clearance(*goal)
        node = self.lattice.node_of(*goal)
        if node is not None and clear >= self.terrain.radius + NODE_MARGIN:
            return node, goal
        lattice = self.lattice
        rows, columns = np.nonzero(lattice.base < search_kernels.WALL)
        nodes = rows * lattice.base.shape[1] + columns
        distances = np.hypot(*(lattice.points_of(nodes) - goal).T)
        if len(nodes) == 0 or distances.min() > self._config.tolerance:
            raise PlanError(
                ErrorCode.GOAL_OCCUPIED,
                f"the goal ({goal[0]:.2f}, {goal[1]:.2f}) is {clear:.2f} m from a wall and no"
                f" place within {self._config.tolerance} m has room for the robot",
            )
        best = int(nodes[int(distances.argmin())])
        return best, lattice.point_of(best)


def path_length(path: FloatArray) -> float:
    """Return the length [m] of a polyline (n, 2)."""
    if len(path) < 2:
        return 0.0
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def straight_path(start: Pose, distance: float) -> FloatArray:
    """Return points from a pose straight ahead (distance < 0: behind), `SPACING` apart."""
    end = (
        start.x + distance * math.cos(start.yaw),
        start.y + distance * math.sin(start.yaw),
    )
    return _resampled(np.array(((start.x, start.y), end)))


def _resampled(points: FloatArray) -> FloatArray:
    capacity = int(path_length(points) / SPACING) + len(points) + 4
    out = np.empty((capacity, 2))
    count = distance_kernels.resample(np.ascontiguousarray(points), SPACING, out)
    return out[:count].copy()
