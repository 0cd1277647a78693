"""The floor that robots stand on: a slab of a world, where there is one, put at height 0.

A world has one level floor. Where robots start and have their stations decides which it is.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_common.model.sites import Sites, Spawn, SpawnAreas, SpawnCircle
from swarm_describe.worlds.raw_triangles import triangles_of
from swarm_describe.worlds.scene import GROUND_GAP, Body, Scene

HIGHEST = 0.3  # [m] above ground that a floor may be
LEVEL = math.cos(math.radians(2.0))  # of the angle between a floor's normal and the vertical
LOWEST = GROUND_GAP - 1e-6  # [m] whatever rounding makes of an obstacle of that height
SAME = 0.005  # [m] by which parts of one floor may differ
MOST = 0.5  # share of the world, and of the places in it, that a floor must lie under
LATTICE = 24  # points along either side of the world that are looked at
AROUND = 2.0  # [m] around the origin where robots start in worlds without places


def on_floor(scene: Scene) -> Scene:
    """Return a world lowered by the height of the slab that its robots stand on, with a note.

    The slab has to be level, at most `HIGHEST` above ground, and lie under most of the places
    and most of the world; otherwise it is an obstacle, as anything else.

    Returns:
        The world itself if its robots stand on the ground.
    """
    surfaces = _level(scene.fixed)
    if not len(surfaces):
        return scene
    heights = _heights(_places(scene.sites), surfaces)
    height = float(np.median(heights))
    if (np.abs(heights - height) <= SAME).mean() <= MOST:
        return scene
    corners = triangles_of(scene.fixed)[:, :, :2].reshape(-1, 2)
    lattice = _lattice(corners.min(axis=0), corners.max(axis=0))
    spread = np.abs(_heights(lattice, surfaces) - height) <= SAME
    if height < LOWEST or spread.mean() < MOST:
        return scene
    name = _owner(scene, height)
    note = (
        f"{scene.file.name}: robots stand on '{name}', {height:.3f} m high: the world is lowered "
        "by that; beyond its edge the ground counts as level, too"
    )
    return replace(
        scene,
        bodies=tuple(_lowered(body, height) for body in scene.bodies),
        decor=tuple(_lowered(body, height) for body in scene.decor),
        notes=(*scene.notes, note),
    )


def _level(bodies: tuple[Body, ...]) -> FloatArray:
    """Return the level triangles (n, 3, 3) above ground that are low enough to be a floor."""
    triangles = triangles_of(bodies)
    low = triangles[
        (triangles[:, :, 2].min(axis=1) > LOWEST) & (triangles[:, :, 2].max(axis=1) <= HIGHEST)
    ]
    normals = np.cross(low[:, 1] - low[:, 0], low[:, 2] - low[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    level: FloatArray = low[np.abs(normals[:, 2]) > np.maximum(LEVEL * lengths, 1e-12)]
    return level


def _heights(points: FloatArray, surfaces: FloatArray) -> FloatArray:
    """Return the height [m] of the highest surface at each point (n, 2); 0 where there is none."""
    heights = np.zeros(len(points))
    for triangle in surfaces:
        a, b, c = triangle
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        across = points - a[:2]
        u = (across[:, 0] * (c[1] - a[1]) - across[:, 1] * (c[0] - a[0])) / area
        v = ((b[0] - a[0]) * across[:, 1] - (b[1] - a[1]) * across[:, 0]) / area
        is_over = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9)
        heights[is_over] = np.maximum(heights[is_over], triangle[:, 2].max())
    return heights


def _places(sites: Sites) -> FloatArray:
    """Return points (n, 2) where robots start or go; around the origin if none are named."""
    points = [(pose.x, pose.y) for pose in (*sites.stations.values(), *sites.places)]
    for spawn in (sites.spawn, *sites.spawns.values()):
        if spawn is not None:
            points += _points_of(spawn)
    if points:
        return np.array(points, np.float64)
    return _lattice(np.array([-AROUND, -AROUND]), np.array([AROUND, AROUND]))


def _points_of(spawn: Spawn) -> list[tuple[float, float]]:
    if isinstance(spawn, SpawnCircle):
        angles = math.tau * np.arange(8) / 8
        return [
            (spawn.x + spawn.radius * math.cos(a), spawn.y + spawn.radius * math.sin(a))
            for a in angles.tolist()
        ]
    areas = spawn.areas if isinstance(spawn, SpawnAreas) else (spawn,)
    return [
        (x, y)
        for area in areas
        for x in np.linspace(area.x_min, area.x_max, 4).tolist()
        for y in np.linspace(area.y_min, area.y_max, 4).tolist()
    ]


def _lattice(low: NDArray[np.float64], high: NDArray[np.float64]) -> FloatArray:
    share = (np.arange(LATTICE) + 0.5) / LATTICE
    x, y = (low[i] + share * (high[i] - low[i]) for i in (0, 1))
    return np.column_stack([np.tile(x, LATTICE), np.repeat(y, LATTICE)])


def _owner(scene: Scene, height: float) -> str:
    """Return the name of the body that has most of the floor."""
    areas = {}
    for body in scene.fixed:
        level = _level((body,))
        level = level[np.abs(level[:, :, 2].max(axis=1) - height) <= SAME]
        edges = level[:, 1:] - level[:, :1]
        areas[body.name] = float(np.abs(np.cross(edges[:, 0], edges[:, 1])[:, 2]).sum())
    return max(areas, key=lambda name: areas[name])


def _lowered(body: Body, height: float) -> Body:
    place = body.world_from_body.copy()
    place[2, 3] -= height
    return replace(body, world_from_body=place)
