"""Bare numba kernels that judge paths: their cost, and whether they clear another robot's way."""

from __future__ import annotations

import math

from numba import njit


@njit(cache=True)
def path_cost(points, frame, layers, extra):
    """Cost [m] of driving along a path, with the lattice's cost of each metre.

    Args:
        points: (n, 2) [m] in map.
        frame: (origin_x, origin_y, step) [m] of the lattice.
        layers: (base, lane, heading) of the lattice, see `search_kernels`.
        extra: (h, w) cost per metre that other robots add.
    """
    origin_x, origin_y, step = frame
    base, lane, heading = layers
    height, width = base.shape
    total = 0.0
    for k in range(1, points.shape[0]):
        dx = points[k, 0] - points[k - 1, 0]
        dy = points[k, 1] - points[k - 1, 1]
        length = math.hypot(dx, dy)
        if length < 1e-9:
            continue
        i = min(max(int((points[k, 1] - origin_y) / step), 0), height - 1)
        j = min(max(int((points[k, 0] - origin_x) / step), 0), width - 1)
        along = (dx * heading[i, j, 0] + dy * heading[i, j, 1]) / length
        total += length * (
            min(base[i, j], 3.0) + lane[i, j] * (1.0 - along) * 0.5 + min(extra[i, j], 1e3)
        )
    return total


@njit(cache=True)
def nearest_index(way, x, y):
    """Find the point of a path that is nearest to a place.

    Args:
        way: (m, 2) [m].
        x: [m] of the place.
        y: [m] of the place.

    Returns:
        (index, squared distance [m²]).
    """
    best = 1e20
    index = 0
    for k in range(way.shape[0]):
        dx = way[k, 0] - x
        dy = way[k, 1] - y
        d = dx * dx + dy * dy
        if d < best:
            best = d
            index = k
    return index, best


@njit(cache=True)
def clears(path, way, reach, tolerance, gain):
    """Whether driving on along `path` gets out of `way`, or at least ahead along it.

    The robot may not come nearer to the start of the way by more than `tolerance` points of it, and
    must either leave it by `reach` or get `gain` points ahead on it.

    Args:
        path: (n, 2) [m] of the robot that makes way, starting at it.
        way: (m, 2) [m] of the robot that wants to pass, starting at that one.
        reach: [m] from the way at which it counts as left.
        tolerance: Points of the way.
        gain: Points of the way.
    """
    first, _ = nearest_index(way, path[0, 0], path[0, 1])
    for k in range(1, path.shape[0]):
        index, gap = nearest_index(way, path[k, 0], path[k, 1])
        if gap >= reach * reach:
            return True
        if index < first - tolerance:
            return False
        if index >= first + gain:
            return True
    return False
