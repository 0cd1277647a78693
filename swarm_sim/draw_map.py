"""The map that a LiDAR would make of a world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_common.grid import Grid
from swarm_common.records import Pose
from swarm_sim.raster import MARGIN, draw_grid
from swarm_sim.scene import Scene
from swarm_sim.section import FloatArray, Section, section_between

SCAN_HEIGHT = 0.132  # [m] above ground of a TurtleBot3 waffle's scan plane
OPEN_ROOM = 5.0  # [m] of map around who starts in the open, beyond all obstacles


def draw_world(
    scene: Scene,
    height: float = SCAN_HEIGHT,
    resolution: float = 0.05,
    starts: Sequence[Pose] = (),
) -> Grid:
    """Return the map that a LiDAR at this height would make of a world.

    Args:
        scene: World with its sites.
        height: [m] of the LiDAR above ground.
        resolution: [m] per cell.
        starts: Where robots start; around those beyond the obstacles there is open ground.
    """
    section = section_between(scene.fixed, height, height)
    seeds = accessible_points(scene)
    return draw_grid(section, seeds, resolution, MARGIN, _open_ground(section, starts))


def _open_ground(section: Section, starts: Sequence[Pose]) -> FloatArray:
    """Return the corners (n, 2) of the ground around those who start beyond the obstacles."""
    x_min, y_min, x_max, y_max = section.bounds()
    corners = [
        (pose.x + side * OPEN_ROOM, pose.y + side * OPEN_ROOM)
        for pose in starts
        if not (x_min <= pose.x <= x_max and y_min <= pose.y <= y_max)
        for side in (-1.0, 1.0)
    ]
    return np.array(corners, dtype=np.float64).reshape(-1, 2)


def accessible_points(scene: Scene) -> FloatArray:
    """Return the points (n, 2) that robots must be able to reach: stations and circuits."""
    points = [(pose.x, pose.y) for pose in scene.sites.stations.values()]
    for circuit in scene.sites.circuits.values():
        points.extend(circuit)
    return np.array(points, dtype=np.float64).reshape(-1, 2)
