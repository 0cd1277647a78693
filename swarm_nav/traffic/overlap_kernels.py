"""Bare numba kernel: which part of a held tube a radius that has grown takes from others."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit
from swarm_nav.control.tube_kernels import gap_squared
from swarm_nav.perception.neighbor_table_kernels import Columns

REACH = 2.5  # [m] of path beyond which nothing of a tube lies


@njit(cache=True)
def first_overlap(
    points: NDArray[np.float64],
    near: int,
    stop: int,
    radius: float,
    slack: float,
    columns: tuple[NDArray[Any], ...],
) -> int:
    """Return the index of the first held point ahead that is too near to a living robot's tube.

    Too near is nearer than both radii minus the slack, and nearer than the robot's present place:
    robots whose places overlap already may part.

    Args:
        points: Path (n, 2) [m] in map.
        near: Index of the robot on it.
        stop: Index of the last held point.
        radius: [m] of this robot.
        slack: [m] by which tubes may be nearer than both radii.
        columns: `Columns` of the neighbours as a plain tuple.

    Returns:
        That index, stop + 1 if no point is too near.
    """
    others = Columns(*columns)
    held, held_size = others.held, others.held_size
    best = stop + 1
    here = points[near]
    for j in range(others.ids.shape[0]):
        reach = radius + others.radius[j] - slack
        if others.gone[j]:
            continue
        first = held[j, 0]
        if math.hypot(first[0] - here[0], first[1] - here[1]) > 2.0 * REACH + reach:
            continue
        before = gap_squared(held[j], held_size[j], here[0], here[1])
        for k in range(near + 1, best):
            gap = gap_squared(held[j], held_size[j], points[k, 0], points[k, 1])
            if gap < reach * reach and gap < before - 1e-6:
                best = k
                break
    return best
