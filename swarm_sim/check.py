"""Checks at the start: does the map show this world, and is there room at the stations?"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from swarm_common.errors import ConfigError, MapError
from swarm_common.grid import FREE, OCCUPIED, Grid
from swarm_common.records import RobotSpec
from swarm_sim.actors import WalkerSpec
from swarm_sim.draw_map import SCAN_HEIGHT
from swarm_sim.raster import draw_on
from swarm_sim.scene import Scene
from swarm_sim.section import Section, section_between
from swarm_sim.spawn import wall_distance

Mask = NDArray[np.bool_]
TOLERANCE = 0.1  # [m] by which an obstacle may be displaced on the map
MAX_SHARE = 0.02  # of the occupied cells that may disagree
PLACES = 3  # named in the message
MAX_SHIFT = 3.0  # [m] looked at for the hint
WALK_STEP = 0.1  # [m] between the places of a walker's path that are looked at


def check_map(scene: Scene, grid: Grid, height: float = SCAN_HEIGHT) -> None:
    """Compare a map with the world's geometry.

    A cell disagrees if the world has an obstacle there and the map says free, with no occupied
    cell within `TOLERANCE`, or if the map has an obstacle with none of the world's near it.

    Args:
        scene: The world.
        grid: The map.
        height: [m] above ground of the plane that the map shows.

    Raises:
        MapError: If more than `MAX_SHARE` of the occupied cells disagree; the message says how
            many, where, and by which shift the map would fit.
    """
    shape = (grid.height, grid.width)
    lattice = (grid.resolution, grid.origin_x, grid.origin_y)
    truth = draw_on(shape, *lattice, _shown(scene, height)).cells == OCCUPIED
    drawn = grid.cells == OCCUPIED
    reach = max(1, round(TOLERANCE / grid.resolution))
    missing = truth & (grid.cells == FREE) & ~_grown(drawn, reach)
    invented = drawn & ~_grown(truth, reach)
    total = int(truth.sum() + drawn.sum())
    wrong = int(missing.sum() + invented.sum())
    outside = _outside(scene, grid, height)
    if outside == "" and (total == 0 or wrong <= MAX_SHARE * total):
        return
    share = 100.0 * wrong / max(1, total)
    raise MapError(
        f"the map does not show world '{scene.name}': {wrong} of {total} occupied cells "
        f"({share:.0f} %) disagree{outside}"
        + _places(missing, grid, "the world has an obstacle that the map lacks")
        + _places(invented, grid, "the map has an obstacle that the world lacks")
        + _hint(truth, drawn, grid)
        + f"; redraw it: python -m swarm_sim.draw_map {scene.name} -o maps/"
    )


def check_sites(scene: Scene, spec: RobotSpec) -> None:
    """Check that a robot fits at every station and corner of a circuit.

    Raises:
        ConfigError: If an obstacle is nearer than the robot's circumscribed radius.
    """
    section = section_between(scene.bodies, 0.005, spec.height)
    names = [f"station '{name}'" for name in scene.sites.stations]
    points = [(pose.x, pose.y) for pose in scene.sites.stations.values()]
    for name, circuit in scene.sites.circuits.items():
        names += [f"corner {index + 1} of circuit '{name}'" for index in range(len(circuit))]
        points += list(circuit)
    gaps = wall_distance(np.array(points, dtype=np.float64).reshape(-1, 2), section)
    for name, (x, y), gap in zip(names, points, gaps, strict=True):
        if gap < spec.circumscribed_radius:
            place = "inside an obstacle" if gap == 0.0 else f"{gap:.3f} m from an obstacle"
            raise ConfigError(
                f"{name} of world '{scene.name}' at ({x:g}, {y:g}) lies {place}; "
                f"a {spec.model} needs {spec.circumscribed_radius:.3f} m"
            )


def check_walkers(scene: Scene, specs: Sequence[WalkerSpec]) -> None:
    """Check that walkers do not walk through obstacles.

    Raises:
        ConfigError: Naming the walker and the place where it would.
    """
    section = section_between(scene.bodies, 0.005, max([s.height for s in specs], default=1.0))
    for spec in specs:
        closed = np.array([*spec.path, spec.path[0]])
        points = np.vstack(
            [
                np.linspace(a, b, max(2, int(np.hypot(*(b - a)) / WALK_STEP)))
                for a, b in pairwise(closed)
            ]
        )
        gaps = wall_distance(points, section)
        worst = int(np.argmin(gaps))
        if gaps[worst] < spec.radius:
            x, y = points[worst]
            raise ConfigError(
                f"{spec.name}: its path runs {gaps[worst]:.2f} m from an obstacle at "
                f"({x:.2f}, {y:.2f}); a body of radius {spec.radius:g} does not fit there"
            )


def _shown(scene: Scene, height: float) -> Section:
    """Return what a map of a world shows: what stays where it is."""
    return section_between(scene.fixed, height, height)


def _outside(scene: Scene, grid: Grid, height: float) -> str:
    """Return a remark on obstacles that lie off the map, empty if there are none."""
    x_min, y_min, x_max, y_max = _shown(scene, height).bounds()
    slack = TOLERANCE + grid.resolution
    right, top = grid.center_of(grid.height - 1, grid.width - 1)
    if (
        x_min >= grid.origin_x - slack
        and y_min >= grid.origin_y - slack
        and x_max <= right + slack
        and y_max <= top + slack
    ):
        return ""
    return (
        f"; the world's obstacles reach from ({x_min:.2f}, {y_min:.2f}) to "
        f"({x_max:.2f}, {y_max:.2f}), the map only from "
        f"({grid.origin_x:.2f}, {grid.origin_y:.2f}) to ({right:.2f}, {top:.2f})"
    )


def _places(mask: Mask, grid: Grid, what: str) -> str:
    """Return where most of a mask's cells are, by squares of 1 m."""
    if not mask.any():
        return ""
    rows, columns = np.nonzero(mask)
    x = grid.origin_x + (columns + 0.5) * grid.resolution
    y = grid.origin_y + (rows + 0.5) * grid.resolution
    squares, inverse, counts = np.unique(
        np.column_stack([np.floor(x), np.floor(y)]), axis=0, return_inverse=True, return_counts=True
    )
    worst = np.argsort(-counts, kind="stable")[:PLACES]
    spots = [
        f"({x[inverse.ravel() == i].mean():.2f}, {y[inverse.ravel() == i].mean():.2f})"
        for i in worst
    ]
    return f"; {what} around {', '.join(spots)}" + (" ..." if len(squares) > PLACES else "")


def _hint(truth: Mask, drawn: Mask, grid: Grid) -> str:
    """Return by which shift the map would fit best, if that is much better than none."""
    size = (2 * grid.height, 2 * grid.width)
    spectrum = np.fft.rfft2(truth, size) * np.conj(np.fft.rfft2(drawn, size))
    overlap = np.fft.irfft2(spectrum, size)
    reach = int(MAX_SHIFT / grid.resolution)
    best, shift = overlap[0, 0], (0, 0)
    for row in range(-min(reach, grid.height - 1), min(reach, grid.height - 1) + 1):
        columns = np.arange(-min(reach, grid.width - 1), min(reach, grid.width - 1) + 1)
        values = overlap[row, columns]
        index = int(np.argmax(values))
        if values[index] > best + 0.5:
            best, shift = values[index], (row, int(columns[index]))
    if shift == (0, 0) or best < 0.5 * drawn.sum():
        return ""
    x, y = shift[1] * grid.resolution, shift[0] * grid.resolution
    return f"; the map would fit if it were moved by ({x:+.2f}, {y:+.2f}) m"


def _grown(mask: Mask, reach: int) -> Mask:
    """Return a mask grown by `reach` cells in the eight directions."""
    grown = mask.copy()
    for axis in (0, 1):
        line = grown.copy()
        for step in range(1, reach + 1):
            front, back = [slice(None)] * 2, [slice(None)] * 2
            front[axis], back[axis] = slice(step, None), slice(None, -step)
            line[tuple(front)] |= grown[tuple(back)]
            line[tuple(back)] |= grown[tuple(front)]
        grown = line
    return grown
