"""Numba kernels of the kinematic engine."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from swarm_sim.physics.walker_kernels import disc_gap
from swarm_sim.scene.polygon_kernels import distance, overlap, place

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@numba.njit(cache=True)
def ramp(value: float, target: float, limit: float) -> float:
    """Return the speed after one step towards the target with a bounded change."""
    return value + min(limit, max(-limit, target - value))


@numba.njit(cache=True)
def box_gap(bounds: FloatArray, x: float, y: float) -> float:
    """Return the distance of a point from an axis-parallel box (4,); 0 inside."""
    dx = max(bounds[0] - x, x - bounds[2], 0.0)
    dy = max(bounds[1] - y, y - bounds[3], 0.0)
    return math.hypot(dx, dy)


@numba.njit(cache=True)
def hits(
    robot: int,
    state: FloatArray,
    limits: FloatArray,
    placed: FloatArray,
    walls: tuple[FloatArray, FloatArray, FloatArray],
    touches: tuple[IntArray, IntArray, IntArray, FloatArray],
    step: int,
) -> bool:
    """Note which robots and walls a robot's placed hull meets; return whether any."""
    polygons, bounds, discs = walls
    radius = limits[robot, 2]
    any_hit = False
    x, y = state[robot, 0], state[robot, 1]
    for j in range(state.shape[0]):
        reach = radius + limits[j, 2]
        dx, dy = state[j, 0] - x, state[j, 1] - y
        if j == robot or dx * dx + dy * dy > reach * reach:
            continue
        if overlap(placed[robot], placed[j]):
            a, b = min(robot, j), max(robot, j)
            if touches[0][a, b] < 0:
                touches[0][a, b] = step
            any_hit = True
    for k in range(polygons.shape[0]):
        if box_gap(bounds[k], x, y) <= radius and overlap(placed[robot], polygons[k]):
            if touches[1][robot, k] < 0:
                touches[1][robot, k] = step
            any_hit = True
    for k in range(discs.shape[0]):
        cx, cy, size = discs[k, 0], discs[k, 1], discs[k, 2]
        if math.hypot(cx - x, cy - y) > radius + size:
            continue
        if disc_gap(placed[robot], cx, cy, size) <= 0.0:
            if touches[2][robot, k] < 0:
                touches[2][robot, k] = step
            any_hit = True
    return any_hit


@numba.njit(cache=True)
def move(
    state: FloatArray,
    targets: FloatArray,
    limits: FloatArray,
    hulls: FloatArray,
    walls: tuple[FloatArray, FloatArray, FloatArray],
    touches: tuple[IntArray, IntArray, IntArray, FloatArray],
    period: float,
    step: int,
) -> bool:
    """Advance all robots by one physics step, in order of index; return whether any touched.

    Args:
        state: (n, 6): x, y, yaw, v, w, v to the left; changed.
        targets: (n, 3): commanded v, w, v to the left.
        limits: (n, 4): acceleration, angular acceleration, circumscribed radius, acceleration to
            the left.
        hulls: (n, k, 2) footprints in base_footprint.
        walls: Packed polygons (m, k, 2), their bounds (m, 4), and discs (d, 3).
        touches: First step of contact with robots (n, n), polygons (n, m), discs (n, d), -1 for
            none; driven path (n, 3): v, w, v to the left. Changed.
        period: [s] of the step.
        step: Its number within the control period.
    """
    count = state.shape[0]
    placed = np.empty_like(hulls)
    for i in range(count):
        place(hulls[i], state[i, 0], state[i, 1], state[i, 2], placed[i])
    any_touch = False
    for i in range(count):
        v = ramp(state[i, 3], targets[i, 0], limits[i, 0] * period)
        w = ramp(state[i, 4], targets[i, 1], limits[i, 1] * period)
        slide = ramp(state[i, 5], targets[i, 2], limits[i, 3] * period)
        x, y, yaw = state[i, 0], state[i, 1], state[i, 2]
        middle = yaw + 0.5 * w * period
        state[i, 0] = x + v * math.cos(middle) * period
        state[i, 1] = y + v * math.sin(middle) * period
        state[i, 2] = -((-(yaw + w * period) + math.pi) % (2.0 * math.pi) - math.pi)
        if slide != 0.0:
            state[i, 0] -= slide * math.sin(middle) * period
            state[i, 1] += slide * math.cos(middle) * period
        state[i, 3], state[i, 4], state[i, 5] = v, w, slide
        if v == 0.0 and w == 0.0 and slide == 0.0:
            continue
        place(hulls[i], state[i, 0], state[i, 1], state[i, 2], placed[i])
        if hits(i, state, limits, placed, walls, touches, step):
            state[i, 0], state[i, 1], state[i, 2] = x, y, yaw
            state[i, 3], state[i, 4], state[i, 5] = 0.0, 0.0, 0.0
            place(hulls[i], x, y, yaw, placed[i])
            any_touch = True
        else:
            touches[3][i, 0] += v * period
            touches[3][i, 1] += w * period
            touches[3][i, 2] += slide * period
    return any_touch


@numba.njit(cache=True)
def move_on(
    state: FloatArray,
    targets: FloatArray,
    limits: FloatArray,
    hulls: FloatArray,
    walls: tuple[FloatArray, FloatArray, FloatArray],
    touches: tuple[IntArray, IntArray, IntArray, FloatArray],
    period: float,
    steps: int,
) -> bool:
    """Advance all robots by a number of physics steps from 0 on; see `move`."""
    any_touch = False
    for step in range(steps):
        if move(state, targets, limits, hulls, walls, touches, period, step):
            any_touch = True
    return any_touch


@numba.njit(cache=True)
def clearances(
    state: FloatArray,
    limits: FloatArray,
    hulls: FloatArray,
    walls: tuple[FloatArray, FloatArray, FloatArray],
    near: tuple[float, float],
    out: FloatArray,
    close: FloatArray,
) -> int:
    """Write the distance of each hull to the nearest other hull and obstacle; list close pairs.

    Args:
        state: (n, 6): of which the pose x, y, yaw is used.
        limits: (n, 4): of which the circumscribed radius is used.
        hulls: (n, k, 2) footprints in base_footprint.
        walls: Packed polygons (m, k, 2), their bounds (m, 4), and discs (d, 3).
        near: [m] distances beyond the first are not measured, those below the second listed.
        out: (n, 2) inf where nothing is near.
        close: Rows i, kind (0 hull, 1 polygon, 2 disc), index, distance; written.

    Returns:
        The number of rows listed, at most the length of `close`.
    """
    count, listed = state.shape[0], 0
    polygons, bounds, discs = walls
    placed = np.empty_like(hulls)
    for i in range(count):
        place(hulls[i], state[i, 0], state[i, 1], state[i, 2], placed[i])
        out[i, 0], out[i, 1] = math.inf, math.inf
    for i in range(count):
        x, y = state[i, 0], state[i, 1]
        for j in range(i):
            reach = limits[i, 2] + limits[j, 2] + near[0]
            dx, dy = state[j, 0] - x, state[j, 1] - y
            if dx * dx + dy * dy > reach * reach:
                continue
            gap = distance(placed[i], placed[j])
            if gap <= near[0]:
                out[i, 0], out[j, 0] = min(out[i, 0], gap), min(out[j, 0], gap)
                listed = _list(close, listed, (j, 0, i), gap, near[1])
        for k in range(polygons.shape[0]):
            if box_gap(bounds[k], x, y) > limits[i, 2] + near[0]:
                continue
            gap = distance(placed[i], polygons[k])
            if gap <= near[0]:
                out[i, 1] = min(out[i, 1], gap)
                listed = _list(close, listed, (i, 1, k), gap, near[1])
        for k in range(discs.shape[0]):
            reach = limits[i, 2] + discs[k, 2] + near[0]
            if math.hypot(discs[k, 0] - x, discs[k, 1] - y) > reach:
                continue
            gap = disc_gap(placed[i], discs[k, 0], discs[k, 1], discs[k, 2])
            if gap <= near[0]:
                out[i, 1] = min(out[i, 1], gap)
                listed = _list(close, listed, (i, 2, k), gap, near[1])
    return listed


@numba.njit(cache=True)
def _list(
    close: FloatArray, listed: int, pair: tuple[int, int, int], gap: float, limit: float
) -> int:
    """Add a row to a list if a pair is closer than a limit; return the list's new length."""
    if gap >= limit or listed >= close.shape[0]:
        return listed
    close[listed, 0], close[listed, 1], close[listed, 2] = pair
    close[listed, 3] = gap
    return listed + 1
