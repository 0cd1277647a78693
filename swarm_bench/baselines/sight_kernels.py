"""Bare numba kernel of line of sight."""

from __future__ import annotations

import math

from numba import njit

from swarm_nav.planning.distance_kernels import sample

STEP = 0.05  # [m] between the samples of a line
STRIDE = 3  # path points between two candidates


@njit(cache=True)
def farthest_in_sight(points, x, y, clearance, slack, field, frame):
    """Index of the last of the points (n, 2) to which the line from (x, y) is clear; 0 if none.

    Clear: it keeps `clearance` [m] from walls, or as much as its ends do, less `slack` [m].
    """
    here = min(clearance, sample(field, frame, x, y))
    for k in range(points.shape[0] - 1, 0, -STRIDE):
        dx = points[k, 0] - x
        dy = points[k, 1] - y
        there = sample(field, frame, points[k, 0], points[k, 1])
        floor = min(here, there) - slack
        steps = max(1, math.ceil(math.hypot(dx, dy) / STEP))
        clear = True
        for s in range(1, steps):
            share = s / steps
            px = x + share * dx
            py = y + share * dy
            if sample(field, frame, px, py) < floor:
                clear = False
                break
        if clear:
            return k
    return 0
