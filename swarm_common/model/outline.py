"""Outlines of bodies seen from above, and what else follows from their shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from swarm_common.model.shapes import Box, Cylinder, FloatArray, Hull, Part, Shape, Sphere

STRAIGHT = 1e-7  # [m²] cross product of two sides below which they form one straight side
RIM = 32  # corners that stand for a circle
FEW = 8  # corners of an outline, if so many will do
MOST_GROWTH = 0.02  # of the circumscribed radius by which an outline may exceed a body
DENSITY = 300.0  # [kg/m³] of a link whose mass is not given: a light box full of electronics
LEAST_MASS = 0.01  # [kg]
Polygon = tuple[tuple[float, float], ...]


def corners(shape: Shape) -> FloatArray:
    """Return points (n, 3) in a shape's frame whose hull, seen from above, holds the shape.

    Args:
        shape: Planes and meshes have no corners.
    """
    if isinstance(shape, Box):
        unit = [[i, j, k] for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (-0.5, 0.5)]
        return np.asarray(np.array(unit) * np.array(shape.size), np.float64)
    if isinstance(shape, Cylinder):
        rim = _circle(shape.radius)
        ends = [np.column_stack([rim, np.full(RIM, z)]) for z in (-0.5, 0.5)]
        return np.asarray(np.vstack(ends) * [1.0, 1.0, shape.length], np.float64)
    if isinstance(shape, Sphere):
        rim = _circle(shape.radius)
        flat = np.column_stack([rim, np.zeros(RIM)])
        return np.vstack([flat, [[0.0, 0.0, shape.radius], [0.0, 0.0, -shape.radius]]])
    if isinstance(shape, Hull):
        return np.array(shape.vertices)
    return np.zeros((0, 3))


def _circle(radius: float) -> FloatArray:
    angles = 2.0 * np.pi * np.arange(RIM) / RIM
    outer = radius / math.cos(math.pi / RIM)
    return outer * np.column_stack([np.cos(angles), np.sin(angles)])


def placed_corners(parts: Sequence[Part]) -> FloatArray:
    """Return the corners (n, 3) of parts in their body's frame, see `corners`."""
    blocks = [np.zeros((0, 3))]
    for part in parts:
        turn = np.eye(3) if isinstance(part.shape, Sphere) else part.body_from_part[:3, :3]
        blocks.append(corners(part.shape) @ turn.T + part.body_from_part[:3, 3])
    return np.vstack(blocks)


def bounds(parts: Sequence[Part]) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest x, y, z [m] of parts, in the body's frame.

    Args:
        parts: Parts of one body; at least one of them has corners.
    """
    points = placed_corners(parts)
    return points.min(axis=0), points.max(axis=0)


def volume(shape: Shape) -> float:
    """Return a shape's volume [m³]; of a hull, half that of the box around it.

    Args:
        shape: Planes and meshes count as nothing.
    """
    if isinstance(shape, Box):
        return math.prod(shape.size)
    if isinstance(shape, Cylinder):
        return math.pi * shape.radius**2 * shape.length
    if isinstance(shape, Sphere):
        return 4.0 / 3.0 * math.pi * shape.radius**3
    spread = np.ptp(corners(shape), axis=0) if isinstance(shape, Hull) else np.zeros(3)
    return float(np.prod(spread)) / 2.0


def outline_around(points: FloatArray, most: int) -> Polygon:
    """Return a convex polygon around points, counter-clockwise, rounded to 0.1 mm.

    Sides of the convex hull are left out one after the other, always the one whose neighbours meet
    nearest behind it. A rounder body, which that would exceed by more than `MOST_GROWTH`, is
    enclosed by lines that touch it: with 16 of them the circumscribed radius never grows by more.

    Args:
        points: (n, 2) [m].
        most: Number of corners that the polygon may have, at least 4.

    Raises:
        ValueError: If the points span no area.
    """
    hull = _hull(points)
    limit = MOST_GROWTH * float(np.hypot(*hull.T).max())
    polygon = hull
    while len(polygon) > min(FEW, most):
        reaches = [_meeting(polygon, side) for side in range(len(polygon))]
        side = int(np.argmin([cost for cost, _ in reaches]))
        polygon = np.insert(polygon, side, reaches[side][1], axis=0)
        gone = [(side + 1) % len(polygon), (side + 2) % len(polygon)]
        polygon = np.delete(polygon, gone, axis=0)
    if FEW < len(hull) and max(_overshoots(hull, polygon)[0]) > limit:
        polygon = hull if len(hull) <= most else _enclosed(hull, most, limit)
    return _strictly_convex([(round(float(x), 4), round(float(y), 4)) for x, y in polygon])


def _enclosed(hull: FloatArray, most: int, limit: float) -> FloatArray:
    """Return a polygon of lines that touch a hull.

    It begins as the box around the hull; then the corner that lies farthest outside is cut off,
    until all are near enough. Where that makes the circumscribed circle grow too much, lines in
    evenly spread directions do better: their corners lie within R / cos(pi / most).
    """
    angles = [0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi]
    radius = float(np.hypot(*hull.T).max())
    while True:
        polygon = _tangents(hull, angles)
        outside, ways = _overshoots(hull, polygon)
        worst = int(outside.argmax())
        if outside[worst] <= limit or len(angles) >= most:
            break
        angles.append(math.atan2(ways[worst, 1], ways[worst, 0]) % (2.0 * math.pi))
        angles.sort()
    if outside[worst] <= limit or np.hypot(*polygon.T).max() <= radius + limit:
        return polygon
    return _tangents(hull, [2.0 * math.pi * k / most for k in range(most)])


def _tangents(hull: FloatArray, angles: Sequence[float]) -> FloatArray:
    """Return the polygon (n, 2) of the lines that touch a hull with normals at angles [rad]."""
    normals = np.column_stack((np.cos(angles), np.sin(angles)))
    supports = (hull[:, None] * normals).sum(axis=2).max(axis=0)
    after, rest = np.roll(normals, -1, axis=0), np.roll(supports, -1)
    across = normals[:, 0] * after[:, 1] - normals[:, 1] * after[:, 0]
    x = (supports * after[:, 1] - rest * normals[:, 1]) / across
    y = (rest * normals[:, 0] - supports * after[:, 0]) / across
    return np.column_stack((x, y))


def _overshoots(hull: FloatArray, polygon: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far [m] corners around a hull (n,) lie from it, and the ways there (n, 2)."""
    sides = np.roll(hull, -1, axis=0) - hull
    gaps = polygon[:, None] - hull
    along = (gaps * sides).sum(axis=2) / (sides**2).sum(axis=1)
    ways = gaps - np.clip(along, 0.0, 1.0)[:, :, None] * sides
    distances = np.hypot(ways[:, :, 0], ways[:, :, 1])
    nearest = distances.argmin(axis=1)
    rows = np.arange(len(polygon))
    return distances[rows, nearest], ways[rows, nearest]


def _strictly_convex(points: list[tuple[float, float]]) -> Polygon:
    """Return a polygon without the corners that rounding has put on a side, or behind it.

    Raises:
        ValueError: If no area is left.
    """
    index = 0
    checked = 0
    while checked < len(points):
        if len(points) < 3:
            raise ValueError("the points span no area")
        index %= len(points)
        (ax, ay), (x, y), (bx, by) = (points[(index + step) % len(points)] for step in (-1, 0, 1))
        if (x - ax) * (by - y) - (y - ay) * (bx - x) > 0.0:
            index, checked = index + 1, checked + 1
        else:
            del points[index]
            index, checked = index - 1, 0
    return tuple(points)


def _hull(points: FloatArray) -> FloatArray:
    from scipy.spatial import ConvexHull, QhullError  # slow to import

    try:
        hull = points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        raise ValueError("the points span no area") from None
    kept: list[FloatArray] = list(hull)
    index = 0
    while (
        index < len(kept) and len(kept) > 2
    ):  # one at a time: two may mark the ends of a tiny side
        a = kept[index] - kept[index - 1]
        b = kept[(index + 1) % len(kept)] - kept[index]
        if a[0] * b[1] - a[1] * b[0] > STRAIGHT:
            index += 1
        else:
            del kept[index]
    return np.array(kept, np.float64)


def _meeting(hull: FloatArray, side: int) -> tuple[float, FloatArray]:
    """Return the area added if a side is left out, and where its neighbours then meet."""
    count = len(hull)
    a, b = hull[side], hull[(side + 1) % count]
    ahead, behind = a - hull[side - 1], b - hull[(side + 2) % count]
    across = ahead[0] * behind[1] - ahead[1] * behind[0]
    if across >= -1e-12:  # they part: the side cannot be left out
        return math.inf, a
    gap = b - a
    way = (gap[0] * behind[1] - gap[1] * behind[0]) / across
    if way < 0.0:
        return math.inf, a
    point = a + way * ahead
    area = abs(gap[0] * (point - a)[1] - gap[1] * (point - a)[0]) / 2.0
    return float(area), point


def estimated_inertia(
    parts: Sequence[Part], mass: float | None
) -> tuple[float, FloatArray, FloatArray]:
    """Return mass, centre and inertia of a link from the box around its shapes.

    Args:
        mass: [kg]; None if it is not given.

    Returns:
        Mass [kg], centre (3,) [m], inertia (3, 3) [kg m²] about it, in the link's axes.
    """
    low, high = bounds(parts)
    x, y, z = high - low
    if mass is None:
        mass = max(LEAST_MASS, DENSITY * sum(volume(part.shape) for part in parts))
    tensor = np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) * mass / 12.0
    return mass, (low + high) / 2.0, np.maximum(tensor, np.eye(3) * 1e-8)
