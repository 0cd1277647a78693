"""The map that a LiDAR would make of a world."""

from __future__ import annotations

import numpy as np

from swarm_common.grid import Grid
from swarm_sim.raster import draw_grid
from swarm_sim.scene import Scene
from swarm_sim.section import FloatArray, section_between

SCAN_HEIGHT = 0.132  # [m] above ground of a TurtleBot3 waffle's scan plane


def draw_world(scene: Scene, height: float = SCAN_HEIGHT, resolution: float = 0.05) -> Grid:
    """Return the map that a LiDAR at this height would make of a world."""
    section = section_between(scene.fixed, height, height)
    return draw_grid(section, accessible_points(scene), resolution)


def accessible_points(scene: Scene) -> FloatArray:
    """Return the points (n, 2) that robots must be able to reach: stations and circuits."""
    points = [(pose.x, pose.y) for pose in scene.sites.stations.values()]
    for circuit in scene.sites.circuits.values():
        points.extend(circuit)
    return np.array(points, dtype=np.float64).reshape(-1, 2)
