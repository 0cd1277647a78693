"""Bare numba kernels that judge paths: what they cost, and whether they clear another's way."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Floats, Frame


class Layers(NamedTuple):
    """Costs of a lattice (h, w), see `terrain.Lattice`."""

    base: NDArray[np.float32]  # cost factor of a metre
    lane: NDArray[np.float32]  # extra factor against `heading`
    heading: NDArray[np.float32]  # (h, w, 2) unit vectors


@njit(cache=True)
def path_cost(points: Floats, frame: Frame, layers: Layers, extra: NDArray[np.float32]) -> float:
    """Return the cost [m] of driving along points (n, 2), as the lattice's edges count it.

    Each piece costs length * (base + lane * (1 - u.h) / 2 + extra), with its unit direction u
    and the preferred direction h of the cell that it ends in.

    Args:
        points: (n, 2) [m] in map.
        extra: (h, w) what other robots add per metre.
    """
    base, lane, heading = layers.base, layers.lane, layers.heading
    height, width = base.shape
    total = 0.0
    for k in range(1, points.shape[0]):
        dx = points[k, 0] - points[k - 1, 0]
        dy = points[k, 1] - points[k - 1, 1]
        length = math.hypot(dx, dy)
        if length < 1e-9:
            continue
        i = min(max(int((points[k, 1] - frame.origin_y) / frame.step), 0), height - 1)
        j = min(max(int((points[k, 0] - frame.origin_x) / frame.step), 0), width - 1)
        along = (dx * heading[i, j, 0] + dy * heading[i, j, 1]) / length
        total += length * (
            min(base[i, j], 3.0) + lane[i, j] * (1.0 - along) * 0.5 + min(extra[i, j], 1e3)
        )
    return total


@njit(cache=True)
def nearest_index(way: Floats, x: float, y: float) -> tuple[int, float]:
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
def clears(path: Floats, way: Floats, reach: float, tolerance: int, gain: int) -> bool:
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
