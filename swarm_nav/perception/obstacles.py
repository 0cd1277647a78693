"""Obstacle layer: hits of the LiDAR that neither the map nor a beacon explains."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import blank_beacon, record_of
from swarm_common.model.records import FloatArray, LidarSpec, Pose, Scan
from swarm_nav.core.config import CostmapConfig
from swarm_nav.perception import obstacle_kernels
from swarm_nav.perception.dynamic_obstacles import DynamicObstacles
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.planning.distance_kernels import Place
from swarm_nav.planning.terrain import Terrain

CELL = 0.05  # [m] marks are rounded to, so that their number is bounded
MAX_MARKS = 2000
HOUSING = 0.05  # [m] radius of a LiDAR's housing, which is what others see of it
NO_BODY = ((math.nan, math.nan),)  # equals no footprint


class ObstacleLayer:
    """Marks and clears points in map."""

    def __init__(
        self,
        config: CostmapConfig,
        lidar: LidarSpec,
        footprint: tuple[tuple[float, float], ...] = (),
    ) -> None:
        """Start without marks.

        Args:
            lidar: Place and properties of the LiDAR.
            footprint: [m] in base_footprint; robots with the same one are seen by their LiDARs.
        """
        self._config = config
        words = record_of(blank_beacon(footprint or NO_BODY))["footprint"].view(np.uint32).ravel()
        # whichever way a robot like this one is turned, its LiDAR is seen within that radius
        self._body = words, math.hypot(lidar.x, lidar.y) + HOUSING
        self._base_from_lidar = Pose(lidar.x, lidar.y, lidar.yaw)
        self._hits = np.empty((lidar.rays, 2))
        self.points: FloatArray = np.zeros((0, 2))
        self._dynamic_obstacles = DynamicObstacles(CELL)

    def configure(self, config: CostmapConfig) -> None:
        """Apply new parameters, effective from the next scan.

        Args:
            config: `costmap.` parameters.
        """
        self._config = config

    def clear(self) -> None:
        """Forget all marks."""
        self.points = np.zeros((0, 2))
        self._dynamic_obstacles.clear()

    def clear_square(self, x: float, y: float, half: float, is_except: bool) -> None:
        """Forget the marks in a square, or all but those.

        Args:
            x: [m] of its centre, in map.
            y: [m] of its centre, in map.
            half: [m] half of its edge.
            is_except: Whether to forget all marks but those in the square.
        """
        distance = np.abs(self.points - (x, y)).max(axis=1, initial=0.0)
        keep: NDArray[np.bool_] = (distance <= half) == is_except
        self.points = self.points[keep]
        self._dynamic_obstacles.keep(keep)

    def restless_gap(self, x: float, y: float, tick: int) -> float:
        """Return the distance [m] of a place from the nearest mark that may be a person.

        Args:
            x: [m] of the place, in map.
            y: [m] of the place, in map.

        Returns:
            The distance; inf if there is no such mark.
        """
        return self._dynamic_obstacles.gap(self.points, x, y, tick)

    def walked(self, tick: int) -> FloatArray:
        """Return the places (n, 2) [m] in map where people have walked lately."""
        return self._dynamic_obstacles.walked(tick)

    def update(
        self,
        scan: Scan,
        pose_map: Pose,
        terrain: Terrain,
        neighbors: NeighborTable,
        margin: float = 0.0,
    ) -> None:
        """Mark unexplained hits and clear marks that a ray passes through or a robot stands on.

        Args:
            neighbors: Explains hits of robots, and learns which silent ones are not there any more.
            margin: [m] by which the robot's radius exceeds its body's.
        """
        config = self._config
        lidar = pose_map.compose(self._base_from_lidar)
        pose = Place(lidar.x, lidar.y, lidar.yaw)
        beam = obstacle_kernels.Beam(scan.angle_min, scan.angle_increment, scan.range_min)
        ranges = np.array(scan.ranges, np.float32)  # a message's buffer may be read-only
        neighbors.clear_empty_places(ranges, beam, pose, config.raytrace_max_range, self._body)
        robots, reach, is_fresh = neighbors.masks(
            lidar.x, lidar.y, config.raytrace_max_range, margin
        )
        count = obstacle_kernels.unexplained(
            ranges,
            beam,
            pose,
            obstacle_kernels.HitLimits(config.obstacle_max_range, config.static_tolerance),
            terrain.walls,
            robots,
            reach,
            self._hits,
        )
        hits = self._hits[:count]
        arrivals = self._dynamic_obstacles.arrivals(
            hits, ranges, beam, pose, config.raytrace_max_range
        )
        if count == len(self.points) == 0:
            return
        keep = np.ones(len(self.points), np.bool_)
        if len(keep):
            obstacle_kernels.still_there(
                self.points,
                ranges,
                beam,
                pose,
                config.raytrace_max_range,
                robots[is_fresh],
                reach[is_fresh],
                keep,
            )
        keep &= self._dynamic_obstacles.present(scan.tick)
        if not keep.all():
            self.points = self.points[keep]
            self._dynamic_obstacles.keep(keep)
        if count == 0:
            return
        old = self.points
        self.points = obstacle_kernels.marked(old, hits, CELL, MAX_MARKS)
        self._dynamic_obstacles.update(self.points, old, hits, arrivals, scan.tick)
