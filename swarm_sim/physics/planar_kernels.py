"""Numba kernels of the kinematic engine."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from swarm_common.model.records import FloatArray, IntArray, Mask
from swarm_common.process.numba_compat import njit
from swarm_sim.physics.walker_kernels import disc_gap
from swarm_sim.scene.polygon_kernels import distance, overlap, place


class Walls(NamedTuple):
    """Outlines and discs that robots can touch, other than each other."""

    polygons: FloatArray  # (m, k, 2) [m] convex outlines, padded with repeated corners
    bounds: FloatArray  # (m, 4) [m] x_min, y_min, x_max, y_max of each
    discs: FloatArray  # (d, 3) [m] x, y, radius of walkers


class Notes(NamedTuple):
    """First contacts and motions of a control period; steps of first contact are -1 for none."""

    robots: IntArray  # (n, n) step in which a robot met another, at the smaller index first
    polygons: IntArray  # (n, m) step in which it met a polygon
    discs: IntArray  # (n, d) step in which it met a disc
    driven: FloatArray  # (n, 3) ahead [m], turned [rad], to the left [m]


# The same for calls from Python in every tick: numba's dispatcher takes plain tuples faster.
PlainWalls = tuple[FloatArray, FloatArray, FloatArray]
PlainNotes = tuple[IntArray, IntArray, IntArray, FloatArray]


@njit(cache=True)
def ramp(value: float, target: float, limit: float) -> float:
    """Return the speed after one step towards the target with a bounded change.

    Args:
        value: Speed before.
        target: Speed aimed at.
        limit: Largest change.
    """
    return value + min(limit, max(-limit, target - value))


@njit(cache=True)
def is_beyond(bounds: FloatArray, x: float, y: float, reach: float) -> bool:
    """Return whether a point is farther than a reach from an axis-parallel box.

    Args:
        bounds: (4,) [m] x_min, y_min, x_max, y_max.
        x: [m] of the point.
        y: [m] of the point.
        reach: [m]
    """
    dx = max(bounds[0] - x, x - bounds[2], 0.0)
    dy = max(bounds[1] - y, y - bounds[3], 0.0)
    return dx > reach or dy > reach or math.hypot(dx, dy) > reach


@njit(cache=True)
def place_anew(
    robot: int, state: FloatArray, hulls: FloatArray, placed: FloatArray, is_placed: Mask
) -> None:
    """Place a robot's hull where the robot is, if it is not there.

    Args:
        robot: Its index.
        state: (n, 6), see `move`.
        hulls: (n, k, 2), see `move`.
        placed: (n, k, 2) [m] footprints in map; changed.
        is_placed: (n,) whose footprint is where the robot is; changed.
    """
    if not is_placed[robot]:
        place(hulls[robot], state[robot, 0], state[robot, 1], state[robot, 2], placed[robot])
        is_placed[robot] = True


@njit(cache=True)
def hits(
    robot: int,
    state: FloatArray,
    limits: FloatArray,
    hulls: FloatArray,
    placed: FloatArray,
    is_placed: Mask,
    walls: Walls,
    notes: Notes,
    step: int,
) -> bool:
    """Record which robots and walls a robot's hull meets; return whether any.

    Args:
        robot: Its index.
        state: (n, 6), see `move`.
        limits: (n, 4), see `move`.
        hulls: (n, k, 2), see `move`.
        placed: (n, k, 2), see `place_anew`.
        is_placed: (n,), see `place_anew`.
        walls: Walls that can be touched.
        notes: Receives first contacts.
        step: Its number within the control period.
    """
    polygons, bounds, discs = walls
    radius = limits[robot, 2]
    any_hit = False
    x, y = state[robot, 0], state[robot, 1]
    for j in range(state.shape[0]):
        reach = radius + limits[j, 2]
        dx, dy = state[j, 0] - x, state[j, 1] - y
        if j == robot or dx * dx + dy * dy > reach * reach:
            continue
        place_anew(robot, state, hulls, placed, is_placed)
        place_anew(j, state, hulls, placed, is_placed)
        if overlap(placed[robot], placed[j]):
            a, b = min(robot, j), max(robot, j)
            if notes.robots[a, b] < 0:
                notes.robots[a, b] = step
            any_hit = True
    for k in range(polygons.shape[0]):
        if is_beyond(bounds[k], x, y, radius):
            continue
        place_anew(robot, state, hulls, placed, is_placed)
        if overlap(placed[robot], polygons[k]):
            if notes.polygons[robot, k] < 0:
                notes.polygons[robot, k] = step
            any_hit = True
    for k in range(discs.shape[0]):
        cx, cy, size = discs[k, 0], discs[k, 1], discs[k, 2]
        if math.hypot(cx - x, cy - y) > radius + size:
            continue
        place_anew(robot, state, hulls, placed, is_placed)
        if disc_gap(placed[robot], cx, cy, size) <= 0.0:
            if notes.discs[robot, k] < 0:
                notes.discs[robot, k] = step
            any_hit = True
    return any_hit


@njit(cache=True)
def move(
    state: FloatArray,
    targets: FloatArray,
    limits: FloatArray,
    hulls: FloatArray,
    walls: PlainWalls,
    notes: PlainNotes,
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
        walls: Fields of `Walls`.
        notes: Fields of `Notes`; changed.
        period: [s] of the step.
        step: Its number within the control period.
    """
    solid, noted = Walls(*walls), Notes(*notes)
    count = state.shape[0]
    placed, is_placed = np.empty_like(hulls), np.zeros(count, np.bool_)
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
        is_placed[i] = False
        if hits(i, state, limits, hulls, placed, is_placed, solid, noted, step):
            state[i, 0], state[i, 1], state[i, 2] = x, y, yaw
            state[i, 3], state[i, 4], state[i, 5] = 0.0, 0.0, 0.0
            is_placed[i] = False
            any_touch = True
        else:
            noted.driven[i, 0] += v * period
            noted.driven[i, 1] += w * period
            noted.driven[i, 2] += slide * period
    return any_touch


@njit(cache=True)
def move_on(
    state: FloatArray,
    targets: FloatArray,
    limits: FloatArray,
    hulls: FloatArray,
    walls: PlainWalls,
    notes: PlainNotes,
    period: float,
    steps: int,
) -> bool:
    """Advance all robots by a number of physics steps; return whether any touched.

    Args:
        state: (n, 6), see `move`; changed.
        targets: (n, 3), see `move`.
        limits: (n, 4), see `move`.
        hulls: (n, k, 2) footprints in base_footprint.
        walls: Fields of `Walls`.
        notes: Fields of `Notes`; changed.
        period: [s] of a step.
        steps: Number of steps, which are numbered from 0.
    """
    any_touch = False
    for step in range(steps):
        if move(state, targets, limits, hulls, walls, notes, period, step):
            any_touch = True
    return any_touch


@njit(cache=True)
def clearances(
    state: FloatArray,
    limits: FloatArray,
    hulls: FloatArray,
    walls: PlainWalls,
    near: float,
    near_miss: float,
    out: FloatArray,
    close: FloatArray,
) -> int:
    """Write the distance of each hull to the nearest other hull and obstacle; list close pairs.

    Args:
        state: (n, 6): of which the pose x, y, yaw is used.
        limits: (n, 4): of which the circumscribed radius is used.
        hulls: (n, k, 2) footprints in base_footprint.
        walls: Fields of `Walls`.
        near: [m] beyond which distances are not measured.
        near_miss: [m] below which they are listed.
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
            reach = limits[i, 2] + limits[j, 2] + near
            dx, dy = state[j, 0] - x, state[j, 1] - y
            if dx * dx + dy * dy > reach * reach:
                continue
            gap = distance(placed[i], placed[j])
            if gap <= near:
                out[i, 0], out[j, 0] = min(out[i, 0], gap), min(out[j, 0], gap)
                listed = _list(close, listed, (j, 0, i), gap, near_miss)
        for k in range(polygons.shape[0]):
            if is_beyond(bounds[k], x, y, limits[i, 2] + near):
                continue
            gap = distance(placed[i], polygons[k])
            if gap <= near:
                out[i, 1] = min(out[i, 1], gap)
                listed = _list(close, listed, (i, 1, k), gap, near_miss)
        for k in range(discs.shape[0]):
            reach = limits[i, 2] + discs[k, 2] + near
            if math.hypot(discs[k, 0] - x, discs[k, 1] - y) > reach:
                continue
            gap = disc_gap(placed[i], discs[k, 0], discs[k, 1], discs[k, 2])
            if gap <= near:
                out[i, 1] = min(out[i, 1], gap)
                listed = _list(close, listed, (i, 2, k), gap, near_miss)
    return listed


@njit(cache=True)
def _list(
    close: FloatArray, listed: int, pair: tuple[int, int, int], gap: float, limit: float
) -> int:
    """Add a row to a list if a pair is closer than a limit; return the list's new length.

    Args:
        close: (m, 4) list; changed.
        listed: Rows in use.
        pair: Robot, kind and index of the other, see `clearances`.
        gap: [m] between them.
        limit: [m] below which they are listed.
    """
    if gap >= limit or listed >= close.shape[0]:
        return listed
    close[listed, 0], close[listed, 1], close[listed, 2] = pair
    close[listed, 3] = gap
    return listed + 1
