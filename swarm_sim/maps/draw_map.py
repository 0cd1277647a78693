"""The map of a world: what a LiDAR sees of it, and what robots can touch beside that."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from swarm_common.model.errors import MapError
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import FloatArray, Pose, RobotSpec
from swarm_describe.worlds.scene import GROUND_GAP, Scene
from swarm_sim.maps.raster import MARGIN, NOWHERE, draw_grid, draw_on
from swarm_sim.scene.section import Section, joined, section_between

SCAN_HEIGHT = 0.132  # [m] above ground of a TurtleBot3 waffle's scan plane
Reach = tuple[float, float]  # [m] heights between which robots can touch something
OPEN_ROOM = 5.0  # [m] of map around robots that start in the open, beyond all obstacles
FAR = 100.0  # [m] outside all obstacles; a station beyond may be in millimetres


def draw_world(
    scene: Scene,
    height: float = SCAN_HEIGHT,
    resolution: float = 0.05,
    starts: Sequence[Pose] = (),
    reach: Reach | None = None,
) -> Grid:
    """Return the map of a world.

    Args:
        height: [m] of the LiDAR above ground.
        starts: Starts of the robots; around those beyond the obstacles there is open ground.
        reach: Heights of the robots' bodies, for what the LiDAR does not see: it is on the map,
            too. None for a map of only what the LiDAR sees.
    """
    section = section_between(scene.fixed, height, height)
    if reach is not None:
        section = joined(section, section_between(scene.fixed, *reach))
    return draw_section(scene, section, resolution, _open_ground(section, starts))


def draw_section(
    scene: Scene, section: Section, resolution: float, covered: FloatArray = NOWHERE
) -> Grid:
    """Return the map of a section through a world; what robots cannot reach is unknown.

    Args:
        scene: World with its sites: what robots reach from these is known.
        covered: Points (k, 2) that the map covers, too.
    """
    try:
        return draw_grid(section, accessible_points(scene), resolution, MARGIN, covered)
    except MapError as cause:
        x_min, y_min, x_max, y_max = section.bounds()
        gaps = {
            name: max(x_min - x, x - x_max, y_min - y, y - y_max)
            for name, (x, y) in site_points(scene).items()
        }
        far = max(gaps, key=lambda name: gaps[name], default="")
        if not far or gaps[far] < FAR:
            raise
        x, y = site_points(scene)[far]
        raise MapError(
            f"{far} at ({x:g}, {y:g}) lies {gaps[far]:.0f} m outside all obstacles; places are in "
            f"metres ({cause})"
        ) from cause


def reach_of(specs: Iterable[RobotSpec]) -> Reach:
    """Return the heights between which robots can touch something."""
    return GROUND_GAP, max([spec.height for spec in specs], default=SCAN_HEIGHT)


def with_touchable(grid: Grid, scene: Scene, height: float, reach: Reach) -> Grid:
    """Return a map with what its LiDAR does not show but robots can touch.

    Args:
        grid: An upright map that shows the world at the LiDAR's height.
    """
    shape, lattice = grid.cells.shape, (grid.resolution, grid.origin_x, grid.origin_y)
    seen = draw_on(shape, *lattice, section_between(scene.fixed, height, height))
    touched = draw_on(shape, *lattice, section_between(scene.fixed, *reach))
    unseen = (touched.cells == OCCUPIED) & (seen.cells != OCCUPIED) & (grid.cells != OCCUPIED)
    if not unseen.any():
        return grid
    cells = grid.cells.copy()
    cells[unseen] = OCCUPIED
    return replace(grid, cells=cells)


def _open_ground(section: Section, starts: Sequence[Pose]) -> FloatArray:
    """Return the corners (n, 2) of the ground around robots that start beyond all obstacles."""
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
    return np.array([*site_points(scene).values()], dtype=np.float64).reshape(-1, 2)


def site_points(scene: Scene) -> dict[str, tuple[float, float]]:
    """Return by what they are called the stations and the corners of circuits."""
    points = {f"station '{name}'": (pose.x, pose.y) for name, pose in scene.sites.stations.items()}
    for name, circuit in scene.sites.circuits.items():
        points |= {f"corner {i} of circuit '{name}'": xy for i, xy in enumerate(circuit, 1)}
    return points
