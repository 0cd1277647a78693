"""Numba kernels on convex polygons: overlap and distance.

A polygon is (k, 2), counter-clockwise; corners may repeat, so that polygons of different size
fit one array.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_common.process.numba_compat import njit


@njit(cache=True)
def place(hull: FloatArray, x: float, y: float, yaw: float, out: FloatArray) -> None:
    """Write a hull, given in its own frame, into `out` at a pose.

    Args:
        hull: (k, 2) [m].
        x: [m]
        y: [m]
        yaw: [rad]
        out: (k, 2) receives the hull.
    """
    cos, sin = math.cos(yaw), math.sin(yaw)
    for k in range(hull.shape[0]):
        out[k, 0] = x + cos * hull[k, 0] - sin * hull[k, 1]
        out[k, 1] = y + sin * hull[k, 0] + cos * hull[k, 1]


@njit(cache=True)
def separated(a: FloatArray, b: FloatArray) -> bool:
    """Return whether an edge of `a` has all of `b` on its outer side.

    Args:
        a: (k, 2), counter-clockwise.
        b: (m, 2).
    """
    count = a.shape[0]
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        dx, dy = a[j, 0] - a[i, 0], a[j, 1] - a[i, 1]
        if dx * dx + dy * dy < 1e-18:
            continue
        apart = True
        for k in range(b.shape[0]):
            if (b[k, 0] - a[i, 0]) * dy - (b[k, 1] - a[i, 1]) * dx <= 0.0:
                apart = False
                break
        if apart:
            return True
    return False


@njit(cache=True)
def overlap(a: FloatArray, b: FloatArray) -> bool:
    """Return whether two convex polygons meet.

    Args:
        a: (k, 2), counter-clockwise.
        b: (m, 2), counter-clockwise.
    """
    return not separated(a, b) and not separated(b, a)


@njit(cache=True)
def corner_distance(a: FloatArray, b: FloatArray) -> float:
    """Return the smallest distance of a corner of `a` from an edge of `b`.

    Args:
        a: (k, 2).
        b: (m, 2).
    """
    best = math.inf
    count = b.shape[0]
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        dx, dy = b[j, 0] - b[i, 0], b[j, 1] - b[i, 1]
        length = dx * dx + dy * dy
        for k in range(a.shape[0]):
            px, py = a[k, 0] - b[i, 0], a[k, 1] - b[i, 1]
            along = 0.0
            if length > 0.0:
                along = min(1.0, max(0.0, (px * dx + py * dy) / length))
            ex, ey = px - along * dx, py - along * dy
            best = min(best, ex * ex + ey * ey)
    return math.sqrt(best)


@njit(cache=True)
def distance(a: FloatArray, b: FloatArray) -> float:
    """Return the distance between two convex polygons; 0 if they meet.

    Args:
        a: (k, 2), counter-clockwise.
        b: (m, 2), counter-clockwise.
    """
    if overlap(a, b):
        return 0.0
    return min(corner_distance(a, b), corner_distance(b, a))


@njit(cache=True)
def nearest_outline(
    points: FloatArray, outlines: FloatArray, bounds: FloatArray, out: FloatArray
) -> None:
    """Write the distance of each point to the nearest convex polygon; 0 inside one.

    Args:
        points: (n, 2).
        outlines: (m, k, 2), padded with repeated corners.
        bounds: (m, 4) of each: x_min, y_min, x_max, y_max.
        out: (n,); inf without polygons.
    """
    corner = np.empty((1, 2))
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        corner[0, 0], corner[0, 1] = x, y
        best = math.inf
        for k in range(outlines.shape[0]):
            dx = max(bounds[k, 0] - x, x - bounds[k, 2], 0.0)
            dy = max(bounds[k, 1] - y, y - bounds[k, 3], 0.0)
            if math.hypot(dx, dy) > best:
                continue
            if overlap(corner, outlines[k]):
                best = 0.0
                break
            best = min(best, corner_distance(corner, outlines[k]))
        out[i] = best
