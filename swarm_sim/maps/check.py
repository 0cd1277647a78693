"""Checks at the start: does the map show this world, and is there room at the stations?"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from itertools import pairwise

import numpy as np

from swarm_common.files.map_io import map_path
from swarm_common.model.errors import ConfigError, MapError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, RobotSpec
from swarm_describe.worlds.actors import VehicleSpec, WalkerSpec
from swarm_describe.worlds.scene import GROUND_GAP, Scene
from swarm_sim.maps.draw_map import SCAN_HEIGHT, Reach, accessible_points, site_points
from swarm_sim.maps.map_difference import compare
from swarm_sim.maps.spawn import keepout_distance, wall_distance
from swarm_sim.scene.section import Section, section_between

WALK_STEP = 0.1  # [m] between the places of a walker's path that are looked at


def check_map(
    scene: Scene, grid: Grid, height: float = SCAN_HEIGHT, reach: Reach | None = None
) -> None:
    """Compare a map with the world's geometry; see `map_difference.compare`.

    Args:
        height: [m] above ground of the plane that the map shows.
        reach: Heights between which robots can touch something; None for a map of only what the
            LiDAR sees.

    Raises:
        MapError: If more than `MAX_SHARE` of the occupied cells disagree; the message says how
            many, where, and by which shift the map would fit.
    """
    difference = compare(scene, grid, height, reach)
    if not difference.agrees():
        # what a user calls a world: its name if it is ours, else its file
        world = scene.name if map_path(scene.name).is_file() else scene.file
        raise MapError(
            f"the map does not show world '{scene.name}': {difference.describe()}"
            f"; redraw it: swarm-map draw {world} -o maps/"
        )


def check_sites(scene: Scene, spec: RobotSpec, used: Collection[str] | None = None) -> list[str]:
    """Check that a robot fits at every station and corner of a circuit, beside keepout zones too.

    Args:
        used: Names of the stations that robots are sent to; None for all.

    Returns:
        Notes on stations without room that nobody is sent to.

    Raises:
        ConfigError: If something, or a keepout zone, is nearer than the circumscribed radius.
    """
    unused = set() if used is None else scene.sites.stations.keys() - used
    labels = {f"station '{name}'" for name in unused}
    notes = []
    section = section_between(scene.bodies, GROUND_GAP, spec.height)
    points = site_points(scene)
    places = accessible_points(scene)
    gaps = wall_distance(places, section)
    zones = keepout_distance(places, scene.sites)
    for (name, (x, y)), wall, zone in zip(points.items(), gaps, zones, strict=True):
        gap, what = min((wall, "an obstacle"), (zone, "a keepout zone"))
        if gap < spec.circumscribed_radius:
            place = f"inside {what}" if gap == 0.0 else f"{gap:.3f} m from {what}"
            problem = (
                f"{name} of world '{scene.name}' at ({x:g}, {y:g}) lies {place}; "
                f"a {spec.model} needs {spec.circumscribed_radius:.3f} m"
            )
            if name not in labels:
                missing = math.ceil(100.0 * (spec.circumscribed_radius - gap)) / 100.0
                raise ConfigError(
                    f"{problem}: move it {missing:.2f} m away from it, or take a smaller robot"
                )
            notes.append(f"{problem}; no mission of this run sends a robot there")
    return notes


def check_walkers(scene: Scene, specs: Sequence[WalkerSpec]) -> None:
    """Check that walkers do not walk through obstacles.

    Args:
        scene: Its bodies count where they are at the start.

    Raises:
        ConfigError: Naming the walker and the place where it would.
    """
    section = section_between(scene.bodies, GROUND_GAP, max([s.height for s in specs], default=1.0))
    for spec in specs:
        _check_gap(spec.name, _along(spec.path), spec.radius, section)


def check_vehicles(scene: Scene, specs: Sequence[VehicleSpec]) -> None:
    """Check that vehicles have room along their path, and to turn at its points.

    Raises:
        ConfigError: Naming the vehicle and the place where it would hit something.
    """
    section = section_between(scene.bodies, GROUND_GAP, max([s.height for s in specs], default=1.0))
    for spec in specs:
        path = spec.path
        if len(path) > 2:
            _check_gap(spec.name, np.array(path), spec.radius, section)
        else:  # to and fro without a turn
            a, b = np.array(path)
            ahead = (b - a) / np.hypot(*(b - a)) * max(0.0, spec.length - spec.width) / 2.0
            path = (tuple((a - ahead).tolist()), tuple((b + ahead).tolist()))
        _check_gap(spec.name, _along(path), spec.width / 2.0, section)


def _along(path: Sequence[tuple[float, float]]) -> FloatArray:
    pieces = [
        np.linspace(a, b, max(2, int(np.hypot(*(b - a)) / WALK_STEP)))
        for a, b in pairwise(np.array([*path, path[0]]))
    ]
    return np.vstack(pieces)


def _check_gap(name: str, points: FloatArray, radius: float, section: Section) -> None:
    gaps = wall_distance(points, section)
    worst = int(np.argmin(gaps))
    if gaps[worst] < radius:
        x, y = points[worst]
        raise ConfigError(
            f"{name}: its path runs {gaps[worst]:.2f} m from an obstacle at "
            f"({x:.2f}, {y:.2f}); a body of radius {radius:g} does not fit there"
        )
