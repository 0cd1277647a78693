"""A global planner that a user brings, behind the face of the built-in one."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, Mask, RobotSpec
from swarm_common.process.plugins import Guard, PluginError
from swarm_nav.core.config import PlannerConfig
from swarm_nav.core.goals import ErrorCode, PlanError
from swarm_nav.core.plugins import PLANNER
from swarm_nav.interfaces import CostGrid
from swarm_nav.planning import search_kernels
from swarm_nav.planning.planner import Planner, path_length
from swarm_nav.planning.terrain import Terrain

MOST_LENGTH = 10_000.0  # [m] of a path
MOST_GAP = 0.5  # [m] of a path's ends from start and goal
TOLERANCE = 0.02  # [m] by which a path may be nearer to a wall than the robot's circle


def planner_maker(name: str, spec: RobotSpec) -> Callable[[Terrain, PlannerConfig], Planner]:
    """Return the factory of a robot's planner: the built-in one, or one around a plug-in.

    Args:
        name: `planner.plugin`.

    Raises:
        ConfigError: If the plug-in is missing.
    """
    if not PLANNER.is_own(name):
        return Planner
    own = PLANNER.guard(name, spec)
    return lambda terrain, config: PluginPlanner(terrain, config, own)


class PluginPlanner(Planner):
    """Finds paths to goals by a plug-in; everything else as the built-in planner."""

    def __init__(self, terrain: Terrain, planner: PlannerConfig, own: Guard) -> None:
        """Plan with the walls of a terrain and the given parameters.

        Args:
            terrain: Terrain of the map, for this size of robot.
            planner: `planner.` parameters.
        """
        super().__init__(terrain, planner)
        self._own = own
        base = self.lattice.base.astype(np.float64)
        self._costs = np.where(base < search_kernels.WALL, base, np.inf)

    def plan(
        self,
        start: tuple[float, float],
        goal: tuple[float, float],
        extra: NDArray[np.float32],
        yaw: float = math.nan,
    ) -> FloatArray:
        """Return a path from start to goal.

        Args:
            start: (x, y) [m] in map.
            goal: (x, y) [m] in map.
            extra: (h, w) cost per metre that other robots add; `search_kernels.WALL` closes a node.
            yaw: [rad] direction that the last metre prefers; plug-ins do not get it.

        Returns:
            (n, 2) [m] in map.

        Raises:
            PlanError: With Nav2's code, if start or goal is unusable, no path exists, or the
                plug-in fails.
        """
        if (way_out := self._way_out(start, extra)) is not None:
            rest = self.plan((float(way_out[-1, 0]), float(way_out[-1, 1])), goal, extra, yaw)
            return np.vstack((way_out, rest[1:]))
        self._start_node(start)
        _, goal = self.goal_node(goal)
        frame = self.lattice
        costs = self._costs + np.where(extra < search_kernels.WALL, extra, np.inf)
        grid = CostGrid(costs, frame.step, frame.origin_x, frame.origin_y)
        try:
            found = self._own.call("plan", grid, start, goal, passes=(PlanError,))
            points = self._checked(found, start, goal)
            path = self.finish(points, start, goal, extra, True) if len(points) else points
            self._check_walls(path)
        except PluginError as error:
            raise PlanError(PLANNER.codes[error.fault], str(error), is_final=True) from error
        if len(path) == 0:
            raise PlanError(
                ErrorCode.NO_VALID_PATH,
                f"no path from ({start[0]:.2f}, {start[1]:.2f}) to ({goal[0]:.2f}, {goal[1]:.2f}):"
                f" {self._own.what} found none",
            )
        return path

    def _checked(
        self, found: object, start: tuple[float, float], goal: tuple[float, float]
    ) -> FloatArray:
        """Return the plug-in's path, if it is one on the map from start to goal."""
        try:
            points = np.ascontiguousarray(found, np.float64)
        except (TypeError, ValueError):
            points = np.full(1, np.nan)
        if points.size == 0:
            return np.zeros((0, 2))
        if points.ndim != 2 or points.shape[1] != 2:
            shape = getattr(found, "shape", type(found).__name__)
            raise self._own.unusable(f"plan returned {shape}; expected points (n, 2)")
        contains = self.terrain.grid.contains
        for x, y in points.tolist():
            if not (math.isfinite(x + y) and contains(x, y)):
                raise self._own.unusable(f"plan returned ({x:.2f}, {y:.2f}), which is off the map")
        for name, point, end in (("begins", points[0], start), ("ends", points[-1], goal)):
            if (gap := math.hypot(*(point - end))) > MOST_GAP:
                raise self._own.unusable(f"plan returned a path that {name} {gap:.2f} m off")
        if (length := path_length(points)) > MOST_LENGTH:
            raise self._own.unusable(f"plan returned a path of {length:.0f} m")
        return points

    def _check_walls(self, path: FloatArray) -> None:
        """Refuse a path that is nearer to a wall than where it begins, and than the robot fits."""
        if len(path) == 0:
            return
        radius, slots = self.terrain.radius, self.lattice.slots
        clear = self.terrain.clearances(path, radius)
        is_bad: Mask = clear < min(radius, clear[0]) - TOLERANCE
        if slots is not None:
            is_bad &= ~slots.is_slot(path)
        if is_bad.any():
            x, y = path[is_bad.argmax()]
            raise self._own.unusable(f"plan returned a path into a wall at ({x:.2f}, {y:.2f})")
