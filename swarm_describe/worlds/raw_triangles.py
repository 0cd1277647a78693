"""The triangles of bodies as their files have them: the truth that all else is compared with.

Nothing here goes through `section` or `mesh_section`, so that a mistake there cannot hide itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_common.model.shapes import Box, Cylinder, Hull, Mesh, Part, Shape, Sphere
from swarm_describe.worlds.scene import Body

RIM = 96  # corners that stand for a circle
TILE = 1.0  # [m] of the squares that `tiles_between` divides a mesh into
BOX_FACES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip
NONE: FloatArray = np.zeros((0, 3, 3))


def triangles_of(bodies: Iterable[Body]) -> FloatArray:
    """Return the triangles (n, 3, 3) of bodies in the world; planes have none."""
    corners = [triangles_of_part(part, body) for body in bodies for part in body.parts]
    return np.concatenate([NONE, *corners])


def triangles_of_part(part: Part, body: Body) -> FloatArray:
    """Return the triangles (n, 3, 3) of a part in the world."""
    world_from_part = body.world_from_body @ part.body_from_part
    turned = _triangles(part.shape) @ world_from_part[:3, :3].T
    triangles: FloatArray = turned + world_from_part[:3, 3]
    return triangles


def tiles_between(triangles: FloatArray, low: float, high: float) -> FloatArray:
    """Return x_min, y_min, x_max, y_max (k, 4) of triangles in a slab, those in a `TILE` joined."""
    heights = triangles[:, :, 2]
    near = triangles[(heights.max(axis=1) >= low) & (heights.min(axis=1) <= high)]
    if not len(near):
        return np.zeros((0, 4))
    least, most = near[:, :, :2].min(axis=1), near[:, :, :2].max(axis=1)
    squares = np.floor((least + most) / (2.0 * TILE)).astype(np.int64)
    _, index = np.unique(squares, axis=0, return_inverse=True)
    index = index.ravel()
    tiles = np.empty((int(index.max()) + 1, 4))
    tiles[:, :2], tiles[:, 2:] = np.inf, -np.inf
    np.minimum.at(tiles[:, :2], index, least)
    np.maximum.at(tiles[:, 2:], index, most)
    return tiles


def cuts(triangles: FloatArray, level: float) -> FloatArray:
    """Return the segments (n, 2, 2) in which a horizontal plane cuts triangles (m, 3, 3)."""
    above = triangles[:, :, 2] > level
    crossing = triangles[above.any(axis=1) & ~above.all(axis=1)]
    # The corner that is alone on its side of the plane is in both edges that are cut.
    side = crossing[:, :, 2] > level
    alone = np.where(side.sum(axis=1) == 1, side.argmax(axis=1), (~side).argmax(axis=1))
    rows = np.arange(len(crossing))
    tip = crossing[rows, alone]
    ends = []
    for step in (1, 2):
        other = crossing[rows, (alone + step) % 3]
        share = (level - tip[:, 2]) / (other[:, 2] - tip[:, 2])
        ends.append(tip[:, :2] + share[:, None] * (other[:, :2] - tip[:, :2]))
    segments: FloatArray = np.stack(ends, axis=1)
    return segments


def triangles_between(triangles: FloatArray, low: float, high: float) -> FloatArray:
    """Return the outline (k, 2, 2), from above, of the parts of triangles between two heights.

    It consists of the clipped edges and of the cuts at both heights.
    """
    heights = triangles[:, :, 2]
    near = triangles[(heights.max(axis=1) >= low) & (heights.min(axis=1) <= high)]
    starts, ends = near.reshape(-1, 3), np.roll(near, -1, axis=1).reshape(-1, 3)
    rise = ends[:, 2] - starts[:, 2]
    safe = np.where(rise == 0.0, 1.0, rise)
    a, b = ((level - starts[:, 2]) / safe for level in (low, high))
    is_flat_in = (rise == 0.0) & (starts[:, 2] >= low) & (starts[:, 2] <= high)
    first = np.where(rise == 0.0, 0.0, np.clip(np.minimum(a, b), 0.0, 1.0))
    last = np.where(rise == 0.0, 1.0, np.clip(np.maximum(a, b), 0.0, 1.0))
    is_in = is_flat_in | ((rise != 0.0) & (last > first))
    along = (ends - starts)[is_in, :2]
    pieces = np.stack(
        [starts[is_in, :2] + share[is_in, None] * along for share in (first, last)], axis=1
    )
    inside: FloatArray = np.concatenate([pieces, cuts(near, low), cuts(near, high)])
    return inside


def points_along(segments: FloatArray, step: float) -> FloatArray:
    """Return points (k, 2) at most `step` apart on segments (n, 2, 2), their ends among them."""
    if not len(segments):
        return np.zeros((0, 2))
    along = segments[:, 1] - segments[:, 0]
    counts = np.ceil(np.hypot(*along.T) / step).astype(np.int64) + 1
    first = np.cumsum(counts) - counts
    share = (np.arange(counts.sum()) - np.repeat(first, counts)) / np.repeat(
        np.maximum(counts - 1, 1), counts
    )
    points: FloatArray = np.repeat(segments[:, 0], counts, axis=0) + share[:, None] * np.repeat(
        along, counts, axis=0
    )
    return points


def _triangles(shape: Shape) -> FloatArray:
    """Return the triangles (n, 3, 3) of a shape in its own frame; corners of round ones on it."""
    corners: FloatArray
    if isinstance(shape, Mesh):
        corners = shape.vertices[shape.faces]
        return corners
    if isinstance(shape, Hull):
        corners = np.array(shape.vertices)[np.array(shape.faces)]
        return corners
    if isinstance(shape, Box):
        signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
        corners = (signs * np.array(shape.size) / 2.0)[BOX_FACES]
        return corners
    if isinstance(shape, Cylinder):
        half = shape.length / 2.0
        return _turned([(0.0, -half), (shape.radius, -half), (shape.radius, half), (0.0, half)])
    if isinstance(shape, Sphere):
        angles = np.linspace(-math.pi / 2.0, math.pi / 2.0, RIM // 2 + 1)
        return _turned([(shape.radius * math.cos(a), shape.radius * math.sin(a)) for a in angles])
    return NONE


def _turned(profile: list[tuple[float, float]]) -> FloatArray:
    """Return the triangles of the solid that a profile of (radius, z) sweeps around the z axis."""
    angles = 2.0 * math.pi * np.arange(RIM + 1) / RIM
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = np.array([np.column_stack([r * circle, np.full(RIM + 1, z)]) for r, z in profile])
    a, b = rings[:-1, :-1].reshape(-1, 3), rings[:-1, 1:].reshape(-1, 3)
    c, d = rings[1:, :-1].reshape(-1, 3), rings[1:, 1:].reshape(-1, 3)
    both = np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
    area = np.linalg.norm(np.cross(both[:, 1] - both[:, 0], both[:, 2] - both[:, 0]), axis=1)
    kept: FloatArray = both[area > 0.0]
    return kept
