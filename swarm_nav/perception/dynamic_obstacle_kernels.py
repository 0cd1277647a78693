"""Bare numba kernels: which marks have moved, and how old they are.

Args of more than one kernel:
    marks: (n, 2) [m] in map.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit
from swarm_nav.perception.obstacle_kernels import Beam, ray_at
from swarm_nav.planning.distance_kernels import Floats, Place

Ticks = NDArray[np.int64]
NONE, CAME, WALKS = 0, 1, 2  # motion of a mark: never moved, has come, was seen walking


class Marks(NamedTuple):
    """History of n marks."""

    births: Ticks  # (n,) in which each appeared
    motion: NDArray[np.int64]  # (n,) NONE, CAME or WALKS
    hit_ticks: Ticks  # (n,) in which each was last hit


# For calls from Python with every scan: numba's dispatcher takes plain tuples faster.
PlainMarks = tuple[Ticks, NDArray[np.int64], Ticks]


class Ages(NamedTuple):
    """Time, and the limits of ages."""

    tick: int  # now
    limits: tuple[int, int, int]  # [ticks] by motion, after which a mark is no longer restless


class Sizes(NamedTuple):
    """Lengths that make marks one body."""

    cell: float  # [m] of a mark
    body: float  # [m] within which marks belong to one body


@njit(cache=True)
def passed_through(
    points: Floats,
    ranges: NDArray[np.float32],
    beam: Beam,
    pose: Place,
    max_range: float,
    margin: float,
    out: NDArray[np.bool_],
) -> None:
    """Flag points beyond which the ray at their bearing and both its neighbours went.

    Args:
        points: (k, 2) [m] in map.
        ranges: (n,) [m] of the scan.
        max_range: [m] from the LiDAR beyond which no point is flagged.
        margin: [m] beyond a point that the rays must have gone.
        out: (k,) receives the flags.
    """
    n = ranges.shape[0]
    for k in range(points.shape[0]):
        dx = points[k, 0] - pose.x
        dy = points[k, 1] - pose.y
        d = math.hypot(dx, dy)
        out[k] = False
        if d > max_range or d < beam.range_min:
            continue
        index = ray_at(beam, n, math.atan2(dy, dx) - pose.yaw)
        if index < 0:
            continue
        out[k] = True
        for side in range(-1, 2):
            if not ranges[(index + side) % n] > d + margin:
                out[k] = False


@njit(cache=True)
def inherit(
    marks: Floats,
    points: Floats,
    old: PlainMarks,
    hits: Floats,
    arrivals: Floats,
    sizes: tuple[float, float],
    ages: tuple[int, tuple[int, int, int]],
    walk_ticks: int,
    out: PlainMarks,
) -> None:
    """Write the history of marks, taken over from older marks near by.

    A mark takes over birth and motion of the older one in its cell. With an arrival within a cell
    it has come, and walks if a body beside it began to come `walk_ticks` ago. A young mark within
    `body` of a mover is a part of it; one within 1.6 cells of a thing is a part of that.

    Args:
        points: The older marks (m, 2) [m] in map.
        old: Their history, fields of `Marks`.
        hits: (k, 2) [m] in map, of this scan.
        arrivals: (j, 2) [m] in map: those of the hits where nothing was shortly before.
        sizes: Fields of `Sizes`.
        ages: Fields of `Ages`.
        walk_ticks: Between the first and a later arrival of a walking body.
        out: Receives the history, fields of `Marks`.
    """
    births, motion, hit_ticks = Marks(*out)
    old_births, old_motion, old_hits = Marks(*old)
    cell, body = Sizes(*sizes)
    tick, limits = Ages(*ages)
    for i in range(marks.shape[0]):
        x, y = marks[i, 0], marks[i, 1]
        births[i] = tick
        motion[i] = NONE
        hit_ticks[i] = tick
        is_beside_thing = False
        beside, youngest, eldest = 0, -1, tick  # movers near by: motion, births
        is_new = True
        for j in range(points.shape[0]):
            gap = max(abs(points[j, 0] - x), abs(points[j, 1] - y))
            if gap > body:
                continue
            if gap < 0.5 * cell:
                births[i] = old_births[j]
                hit_ticks[i] = old_hits[j]
                motion[i] = old_motion[j]
                is_new = False
            if tick - old_births[j] >= limits[old_motion[j]]:
                is_beside_thing = is_beside_thing or gap < 1.6 * cell
            elif old_motion[j]:
                beside = max(beside, old_motion[j])
                youngest = max(youngest, old_births[j])
                eldest = min(eldest, old_births[j])
        has_come = False
        for k in range(arrivals.shape[0]):
            if max(abs(arrivals[k, 0] - x), abs(arrivals[k, 1] - y)) <= cell:
                has_come = True
                motion[i] = max(motion[i], WALKS if tick - eldest >= walk_ticks else CAME)
                break
        for k in range(hits.shape[0]):
            if max(abs(hits[k, 0] - x), abs(hits[k, 1] - y)) <= 0.6 * cell:
                hit_ticks[i] = tick
                break
        if beside and tick - births[i] < limits[NONE]:
            motion[i] = max(motion[i], beside)
            if is_new and not has_come and beside == CAME:
                births[i] = youngest  # a part of a body that came then, seen only now
        if is_beside_thing and motion[i] == NONE:
            births[i] = min(births[i], tick - limits[NONE])


@njit(cache=True)
def restless_gap(
    marks: Floats,
    births: Ticks,
    motion: NDArray[np.int64],
    ages: tuple[int, tuple[int, int, int]],
    x: float,
    y: float,
) -> float:
    """Return the distance [m] of a place from the nearest restless mark; inf without one.

    A mark of motion m is restless, which means that it may be a walking person, until it is
    limits[m] ticks old.

    Args:
        births: (n,) ticks in which the marks appeared.
        motion: (n,) NONE, CAME or WALKS.
        ages: Fields of `Ages`; plain, since this is called in every tick and numba's dispatcher
            takes plain tuples faster.
        x: [m] of the place, in map.
        y: [m] of the place, in map.
    """
    tick, limits = Ages(*ages)
    best = 1e20
    for k in range(marks.shape[0]):
        if tick - births[k] >= limits[motion[k]]:
            continue
        dx = marks[k, 0] - x
        dy = marks[k, 1] - y
        best = min(best, dx * dx + dy * dy)
    return math.sqrt(best) if best < 1e20 else math.inf
