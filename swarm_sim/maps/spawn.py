"""Starts of robots: on a lattice away from walls, stations and circuits, or on a circle."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import WorldError
from swarm_common.model.records import FloatArray, Pose, RobotSpec, wrap_angle
from swarm_common.model.sites import Sites, Spawn, SpawnArea, SpawnAreas, SpawnCircle
from swarm_common.model.zones import keepout_area
from swarm_describe.worlds.scene import GROUND_GAP, Scene
from swarm_sim.maps.draw_map import accessible_points, draw_section
from swarm_sim.maps.raster import connected
from swarm_sim.physics.planar import bounds_of, pack_polygons
from swarm_sim.scene.polygon_kernels import corner_distance, nearest_outline
from swarm_sim.scene.section import Section, section_between

WALL_GAP = 0.15  # [m] between the robot's circle and an obstacle
STATION_CLEARANCE = 1.2  # [m] from centre to station
CIRCUIT_CLEARANCE = 0.9  # [m] from centre to circuit
MIN_PITCH = 0.7  # [m] between neighbours
PITCH_STEPS = 40
NAMED = 3  # bodies in the way that a message lists
REACH_RESOLUTION = 0.1  # [m] of the grid on which reachability is checked
Start = str | Spawn  # name of a spawn of `sites.yaml`, or one of the user's own


def deal_places(
    scene: Scene, specs: Sequence[RobotSpec], starts: Sequence[Start], widest: RobotSpec
) -> list[Pose]:
    """Return where each robot of a fleet starts; groups may have starts of their own.

    Args:
        widest: The largest robot of all, for which places in the default start are made.
    """
    poses: list[Pose | None] = [None] * len(specs)
    for start in dict.fromkeys(starts):
        members = [index for index, other in enumerate(starts) if other == start]
        largest = max((specs[i] for i in members), key=lambda spec: spec.circumscribed_radius)
        spec = widest if isinstance(start, str) else largest
        for index, pose in zip(members, spawn_poses(scene, spec, len(members), start), strict=True):
            poses[index] = pose
    placed = [pose for pose in poses if pose is not None]
    check_apart(placed, specs, scene.name)
    return placed


def check_apart(poses: Sequence[Pose], specs: Sequence[RobotSpec], world: str) -> None:
    """Raise WorldError for the first two robots that would overlap at their start."""
    points = np.array([(pose.x, pose.y) for pose in poses])
    radii = np.array([spec.circumscribed_radius for spec in specs])
    for index in range(1, len(poses)):
        gaps = np.hypot(*(points[:index] - points[index]).T) - radii[:index] - radii[index]
        if gaps.min() < 0.0:
            other, (x, y) = int(np.argmin(gaps)), points[index].tolist()
            raise WorldError(
                f"robots {other + 1} and {index + 1} would overlap at their start in world"
                f" '{world}', at ({x:.2f}, {y:.2f}): give their start areas more room"
            )


def spawn_poses(scene: Scene, spec: RobotSpec, count: int, spawn: Start = "") -> list[Pose]:
    """Return places for `count` robots in the map frame, the same ones for the same input.

    Args:
        spec: The largest robot that may stand on any of the places.
        spawn: Name of one of the spawns of `sites.yaml`, empty for the default one; or a spawn.
    """
    section = section_between(scene.bodies, GROUND_GAP, spec.height)
    start = scene.sites.spawn_named(spawn) if isinstance(spawn, str) else spawn
    if start is None:
        return _around_origin(section, scene, spec, count)
    if isinstance(start, SpawnCircle):
        return _on_circle(start, section, scene, spec, count)
    areas = start.areas if isinstance(start, SpawnAreas) else (start,)
    shares = [
        _in_area(area, section, scene, spec, len(range(index, count, len(areas))), len(areas))
        for index, area in enumerate(areas)
    ]
    return [shares[number % len(areas)][number // len(areas)] for number in range(count)]


def _in_area(
    area: SpawnArea, section: Section, scene: Scene, spec: RobotSpec, count: int, areas: int
) -> list[Pose]:
    """Return places in an area, row by row from its lower left corner.

    The pitch is that of `sites.yaml`, or the largest smaller one at which all robots fit.
    """
    min_pitch = _min_pitch(spec)
    most = 0
    for pitch in np.linspace(max(area.pitch, min_pitch), min_pitch, PITCH_STEPS):
        points = _places(area, float(pitch), section, scene, spec)
        if len(points) >= count:
            return [Pose(float(x), float(y), area.yaw) for x, y in points[:count]]
        most = max(most, len(points))
    raise WorldError(
        f"the spawn area of world '{scene.name}', ({area.x_min:g}, {area.y_min:g}) to "
        f"({area.x_max:g}, {area.y_max:g}), has room for {most} robot{'s' * (most != 1)} "
        f"of model {spec.model}; {count} are asked for"
        + (f", as robots are dealt to {areas} areas in turn" if areas > 1 else "")
        + f"{_in_the_way(area, section, scene.sites, spec)}"
    )


def _in_the_way(area: SpawnArea, section: Section, sites: Sites, spec: RobotSpec) -> str:
    """Return a remark on what takes most of an area; empty if nothing does."""
    points = _points(area, _min_pitch(spec))
    need = spec.circumscribed_radius + WALL_GAP
    taken: Counter[str] = Counter()
    for name in dict.fromkeys(section.names):
        own = Section(
            tuple(p for p, n in zip(section.polygons, section.names, strict=False) if n == name),
            section.discs[[n == name for n in section.names[len(section.polygons) :]]],
            (),
        )
        taken[f"'{name}'"] = int((wall_distance(points, own) <= need).sum())
    kept = f"starts keep {STATION_CLEARANCE:g} m, or circuits, {CIRCUIT_CLEARANCE:g} m"
    zones = keepout_distance(points, sites) <= need
    taken["keepout zones"] = int(zones.sum())
    taken[f"stations, from which {kept}"] = int((~_site_clearance(points, sites)).sum())
    worst = [
        f"{name} ({count} of {len(points)} places)"
        for name, count in taken.most_common(NAMED)
        if count
    ]
    return f"; in the way: {', '.join(worst)}" if worst else ""


def _around_origin(section: Section, scene: Scene, spec: RobotSpec, count: int) -> list[Pose]:
    """Return the places nearest the origin, for worlds without a spawn."""
    area = _default_area(section, count)
    points = _places(area, max(area.pitch, _min_pitch(spec)), section, scene, spec)
    if len(points) < count:
        return _in_area(area, section, scene, spec, count, 1)
    nearest = np.argsort(np.hypot(points[:, 0], points[:, 1]).round(6), kind="stable")[:count]
    return [Pose(float(x), float(y), area.yaw) for x, y in points[np.sort(nearest)]]


def _on_circle(
    circle: SpawnCircle, section: Section, scene: Scene, spec: RobotSpec, count: int
) -> list[Pose]:
    """Return places on a circle, counter-clockwise from the positive x axis."""
    most = int(math.tau * circle.radius / _min_pitch(spec))
    if count > most:
        raise WorldError(
            f"the spawn circle of world '{scene.name}' has room for {most} robots of "
            f"model {spec.model}; {count} are asked for"
        )
    angles = math.tau * np.arange(count) / count
    points = np.array([circle.x, circle.y]) + circle.radius * np.column_stack(
        [np.cos(angles), np.sin(angles)]
    )
    need = spec.circumscribed_radius + WALL_GAP
    for what, gaps in (
        ("an obstacle", wall_distance(points, section)),
        ("a keepout zone", keepout_distance(points, scene.sites)),
    ):
        if (gaps <= need).any():
            x, y = points[int(np.argmax(gaps <= need))]
            raise WorldError(
                f"the spawn circle of world '{scene.name}' meets {what} at ({x:.2f}, {y:.2f})"
            )
    return [
        Pose(float(x), float(y), wrap_angle(float(angle) + math.pi))
        for (x, y), angle in zip(points, angles, strict=True)
    ]


def _min_pitch(spec: RobotSpec) -> float:
    return max(MIN_PITCH, 2.0 * spec.circumscribed_radius + 0.1)


def _default_area(section: Section, count: int) -> SpawnArea:
    """Return an area for worlds without one: around the origin, inside the obstacles' bounds."""
    side = 1.5 * np.ceil(np.sqrt(count)) + 3.0
    x_min, y_min, x_max, y_max = section.bounds()
    square = SpawnArea(-side, -side, side, side, 1.5)
    if x_max - x_min < 1.0 or y_max - y_min < 1.0 or not (x_min < 0.0 < x_max):
        return square
    y_min, y_max = max(-side, y_min), min(side, y_max)
    if y_max < y_min:  # all obstacles lie beyond it
        return square
    return SpawnArea(max(-side, x_min), y_min, min(side, x_max), y_max, 1.5)


def _places(
    area: SpawnArea, pitch: float, section: Section, scene: Scene, spec: RobotSpec
) -> FloatArray:
    """Return the usable points (n, 2) of the lattice, row by row."""
    points = _points(area, pitch)
    keep = wall_distance(points, section) > spec.circumscribed_radius + WALL_GAP
    keep &= _site_clearance(points, scene.sites)
    keep &= keepout_distance(points, scene.sites) > spec.circumscribed_radius + WALL_GAP
    keep &= _reachable(points, section, scene)
    return points[keep]


def _points(area: SpawnArea, pitch: float) -> FloatArray:
    """Return the points (n, 2) [m] of the lattice, row by row."""
    x = np.arange(area.x_min, area.x_max + 1e-6, pitch)
    y = np.arange(area.y_min, area.y_max + 1e-6, pitch)
    return np.column_stack([np.tile(x, len(y)), np.repeat(y, len(x))])


def wall_distance(points: FloatArray, section: Section) -> FloatArray:
    """Return each point's distance (n,) to the nearest obstacle; 0 inside one, inf without any."""
    nearest = np.full(len(points), np.inf)
    outlines = pack_polygons(section.outlines())
    nearest_outline(np.ascontiguousarray(points), outlines, bounds_of(outlines), nearest)
    return nearest


def keepout_distance(points: FloatArray, sites: Sites) -> FloatArray:
    """Return each point's distance (n,) to a keepout zone; 0 inside one, inf without any."""
    if not sites.zones.has_keepout:
        return np.full(len(points), np.inf)
    import shapely  # slow to import

    area = keepout_area(sites.zones)
    gaps: FloatArray = shapely.distance(area, shapely.points(points[:, 0], points[:, 1]))
    return np.where(np.isnan(gaps), np.inf, gaps)  # of an empty mask


def _site_clearance(points: FloatArray, sites: Sites) -> NDArray[np.bool_]:
    keep = np.ones(len(points), np.bool_)
    for pose in sites.stations.values():
        keep &= np.hypot(points[:, 0] - pose.x, points[:, 1] - pose.y) >= STATION_CLEARANCE
    for circuit in sites.circuits.values():
        closed = np.array([*circuit, circuit[0]])
        for a, b in pairwise(closed):
            edge = np.array([a, b])
            gaps = [corner_distance(point[None, :], edge) for point in points]
            keep &= np.array(gaps, dtype=np.float64).reshape(-1) >= CIRCUIT_CLEARANCE
    return keep


def _reachable(points: FloatArray, section: Section, scene: Scene) -> NDArray[np.bool_]:
    """Return which points are connected with the stations, or, without any, with most points."""
    if not len(points):
        return np.ones(0, np.bool_)
    grid = draw_section(scene, section, REACH_RESOLUTION)
    cells = np.array([grid.cell_of(x, y) for x, y in points], np.int64)
    on_grid = np.logical_and(cells >= 0, cells < grid.cells.shape).all(axis=1)
    seeds = np.array([grid.cell_of(x, y) for x, y in accessible_points(scene)], np.int64)
    choices = [seeds] if len(seeds) else [cells[i : i + 1] for i in np.flatnonzero(on_grid)]
    best = np.zeros(len(points), np.bool_)
    if not len(seeds):
        best[:] = ~on_grid  # open field
    for choice in choices:
        if len(choices) > 1 and best[(cells == choice[0]).all(axis=1)].any():
            continue  # this place belongs to the best set already
        reached = connected(grid.cells, choice)
        found = np.zeros(len(points), np.bool_)
        found[on_grid] = reached[cells[on_grid, 0], cells[on_grid, 1]]
        if found.sum() > best.sum():
            best = found
    return best
