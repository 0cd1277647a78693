"""Distance that a robot may drive along a straight line, by where the others may be."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@njit(cache=True)
def free_length(
    start: tuple[float, float],
    end: tuple[float, float],
    most: float,
    step: float,
    robot: int,
    segments: Floats,
    owners: NDArray[np.int64],
    radii: Floats,
) -> float:
    """Return the length [m] from `start` towards `end` that keeps off all other robots.

    A point that is nearer than wanted is free where it is no nearer than the point before.

    Args:
        start: (x, y) [m] where the robot would stop now.
        end: (x, y) [m]
        most: [m] that are wanted.
        step: [m] between points that are checked.
        robot: Index of the robot.
        segments: (m, 4) x, y, x, y [m] of what each robot may drive on.
        owners: (m,) index of its robot.
        radii: (n,) [m] of half the distance that each robot keeps.
    """
    length = math.hypot(end[0] - start[0], end[1] - start[1])
    if length < 1e-9:
        return 0.0
    most = min(most, length)
    ux, uy = (end[0] - start[0]) / length, (end[1] - start[1]) / length
    steps = max(1, math.ceil(most / step - 1e-9))
    near = np.empty(len(owners), np.bool_)
    gaps = np.empty(len(owners))
    for k in range(len(owners)):
        gaps[k] = _gap(start[0], start[1], segments[k])
        near[k] = owners[k] != robot and gaps[k] < most + radii[robot] + radii[owners[k]]
    for number in range(1, steps + 1):
        way = most * number / steps
        x, y = start[0] + ux * way, start[1] + uy * way
        for k in range(len(owners)):
            if not near[k]:
                continue
            gap = _gap(x, y, segments[k])
            if gap < radii[robot] + radii[owners[k]] and gap < gaps[k]:
                return most * (number - 1) / steps
            gaps[k] = gap
    return most


@njit(cache=True)
def _gap(x: float, y: float, segment: Floats) -> float:
    """Return the distance of a point to a segment (4,)."""
    dx, dy = segment[2] - segment[0], segment[3] - segment[1]
    square = dx * dx + dy * dy
    share = 0.0
    if square > 1e-12:
        share = ((x - segment[0]) * dx + (y - segment[1]) * dy) / square
        share = min(1.0, max(0.0, share))
    return math.hypot(x - segment[0] - share * dx, y - segment[1] - share * dy)
