"""Bare numba kernel of line of sight."""

from __future__ import annotations

import math

from swarm_common.model.records import FloatArray
from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Field, sample

STEP = 0.05  # [m] between the samples of a line
STRIDE = 3  # path points between two candidates


@njit(cache=True)
def farthest_in_sight(
    points: FloatArray, x: float, y: float, clearance: float, slack: float, walls: Field
) -> int:
    """Return the index of the last point to which the line from (x, y) is clear; 0 without one.

    Args:
        points: (n, 2) [m] in map.
        x: [m] in map.
        y: [m] in map.
        clearance: [m] that a clear line keeps from walls; less if one of its ends is nearer.
        slack: [m] by which the line may be nearer than that.
        walls: Distances to them.
    """
    field, frame = walls
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
