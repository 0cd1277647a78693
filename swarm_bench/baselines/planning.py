"""Global paths of the baselines: our A* on the map, without lanes or any other traffic rule."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
from numpy.typing import NDArray

from swarm_bench.baselines import baseline_kernels as kernels
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Pose
from swarm_common.process.libm import exp
from swarm_nav.core.config import CostmapConfig, NavConfig, PlannerConfig
from swarm_nav.planning import distance_kernels, search_kernels
from swarm_nav.planning.distance_kernels import Field
from swarm_nav.planning.planner import SPACING, Planner
from swarm_nav.planning.terrain import Terrain

INFLATION_WEIGHT = 4.0  # cost per metre right beside a wall: Nav2's NavFn, 0.8 * 252 / 50
ROBOT_GAP = 0.03  # [m] between the circles of two robots that a path leaves
ROBOT_SURROUNDINGS = 0.3  # [m] around a robot that are to be avoided where there is room
ROBOT_COST = 3.0  # of them, per metre
SIGHT_SLACK = 0.02  # [m] by which a line of sight may be nearer to walls than asked for
LOST_PATH = 0.5  # [m] from the path at which it is of no use any more


def plain_planner(grid: Grid, config: NavConfig, radius: float) -> Planner:
    """Return a planner on a terrain that all robots of a process share.

    Args:
        config: The parameters of planner and costmap count.
        radius: [m] of the robot's circle, which keeps off walls.
    """
    origin = (grid.origin_x, grid.origin_y, grid.height, grid.width)
    keepout = b"" if grid.keepout is None else grid.keepout.tobytes()
    layers = grid.cells.tobytes(), keepout
    terrain = _terrain(layers, grid.resolution, origin, config.planner, config.costmap, radius)
    return Planner(terrain, config.planner)


@functools.lru_cache(maxsize=4)
def _terrain(
    layers: tuple[bytes, bytes],
    resolution: float,
    origin: tuple[float, float, int, int],
    planner: PlannerConfig,
    costmap: CostmapConfig,
    radius: float,
) -> Terrain:
    cells, keepout = (np.frombuffer(layer, np.int8) for layer in layers)
    shape = origin[2], origin[3]
    zones = keepout.reshape(shape) if len(keepout) else None
    grid = Grid(cells.reshape(shape), resolution, origin[0], origin[1], keepout=zones)
    terrain = Terrain(grid, planner, costmap, radius)
    lattice = terrain.lattice
    gap = np.maximum(lattice.clearance - radius, 0.0)
    inflation = INFLATION_WEIGHT * exp(-costmap.cost_scaling_factor * gap)
    inflation[lattice.clearance > costmap.inflation_radius] = 0.0
    closed = lattice.base >= search_kernels.WALL
    base = np.where(closed, search_kernels.WALL, 1.0 + inflation).astype(np.float32)
    terrain.lattice = dataclasses.replace(lattice, base=base, lane=np.zeros_like(lattice.lane))
    return terrain


def robot_costs(
    planner: Planner, places: FloatArray, radii: FloatArray, radius: float
) -> NDArray[np.float32]:
    """Return the lattice costs of other robots, for a robot that plans.

    Args:
        places: Centres (k, 2) [m] in map.
        radii: (k,) [m] of the others.
        radius: [m] of the robot that plans.

    Returns:
        Extra costs (rows, columns) per metre, on the planner's lattice.
    """
    extra = planner.no_extra()
    frame = planner.lattice.frame
    for place, other in zip(places, radii, strict=True):
        point = place.reshape(1, 2)
        reach = radius + float(other) + ROBOT_GAP
        distance_kernels.stamp_discs(extra, frame, point, 1, reach + ROBOT_SURROUNDINGS, ROBOT_COST)
        distance_kernels.stamp_discs(extra, frame, point, 1, reach, search_kernels.WALL)
    return extra


class PathTrack:
    """A path (n, 2) and how far along it the robot is."""

    def __init__(self, points: FloatArray) -> None:
        """Stand at the first point.

        Args:
            points: (n, 2) [m] in map, `SPACING` apart; n is 1 at least.
        """
        self.points = points
        self._near = 0

    def update(self, pose: Pose) -> None:
        """Note where the robot is; it may have been pushed back or cut a corner."""
        first = max(0, self._near - round(1.0 / SPACING))
        window = self.points[first : self._near + round(1.5 / SPACING)]
        gaps = np.hypot(window[:, 0] - pose.x, window[:, 1] - pose.y)
        self._near = first + int(gaps.argmin())

    def is_lost(self, pose: Pose) -> bool:
        """Whether the robot is off the path, as of the last `update`."""
        x, y = self.points[self._near]
        return math.hypot(x - pose.x, y - pose.y) > LOST_PATH

    def ahead(self, distance: float) -> FloatArray:
        """Return the points from the robot on; at least one.

        Args:
            distance: [m] along the path.

        Returns:
            (k, 2) [m] in map, a view; fewer where the path ends.
        """
        return self.points[self._near : self._near + 1 + round(distance / SPACING)]

    @property
    def rest(self) -> float:
        """Length [m] from the robot to the end."""
        return (len(self.points) - 1 - self._near) * SPACING


def waypoint(
    track: PathTrack, planner: Planner, pose: Pose, distance: float, clearance: float
) -> tuple[float, float]:
    """Return the farthest point of the path to which a straight line is clear of walls.

    Args:
        distance: [m] ahead along the path, at most.
        clearance: [m] that the line of sight keeps from walls, or as much as its ends do.

    Returns:
        (x, y) [m] in map.
    """
    points = np.ascontiguousarray(track.ahead(distance))
    terrain = planner.terrain
    index = kernels.farthest_in_sight(
        points, pose.x, pose.y, clearance, SIGHT_SLACK, Field(terrain.distance, terrain.frame)
    )
    return float(points[index, 0]), float(points[index, 1])
