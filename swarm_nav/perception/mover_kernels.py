"""Bare numba kernels: which marks have moved, and how old they are."""

from __future__ import annotations

import math

from numba import njit


@njit(cache=True)
def passed_through(points, ranges, beam, pose, limits, out):
    """Flag points that all rays of a scan around their bearing went beyond.

    Args:
        points: (k, 2) [m] in map.
        ranges: (n,) [m] of the scan.
        beam: (angle_min [rad], angle_increment [rad], range_min [m]).
        pose: (x, y, yaw) of the LiDAR in map.
        limits: (max_range, margin) [m]: how far points may be, and how far beyond a ray must go.
        out: (k,) bool, written.
    """
    n = ranges.shape[0]
    for k in range(points.shape[0]):
        dx = points[k, 0] - pose[0]
        dy = points[k, 1] - pose[1]
        d = math.hypot(dx, dy)
        out[k] = False
        if d > limits[0] or d < beam[2]:
            continue
        angle = math.atan2(dy, dx) - pose[2] - beam[0]
        index = round((angle % (2.0 * math.pi)) / beam[1])
        if index >= n and (n + 0.5) * beam[1] < 2.0 * math.pi:
            continue  # outside the field of view; a full circle closes
        out[k] = True
        for side in range(-1, 2):
            if not ranges[(index + side) % n] > d + limits[1]:
                out[k] = False


@njit(cache=True)
def inherit(marks, old, seen, sizes, times, out):
    """Write birth, motion and time of the last hit of marks, from older marks near by.

    Args:
        marks: (n, 2) [m] in map.
        old: (points (m, 2), births (m,), motion (m,), hit_ticks (m,)) of the older marks; motion
            is 0 (none), 1 (has come), or 2 (walks).
        seen: (hits (k, 2), arrivals (j, 2)) [m] in map, of this scan.
        sizes: (cell, body) [m]: of a mark, and of a body.
        times: (tick, limits, walk_ticks): after limits[m] ticks a mark of motion m is no longer
            restless.
        out: (births (n,), motion (n,), hit_ticks (n,)), written.
    """
    points, old_births, old_motion, old_hits = old
    hits, arrivals = seen
    births, motion, hit_ticks = out
    cell, body = sizes
    tick, limits, walk_ticks = times
    for i in range(marks.shape[0]):
        x, y = marks[i, 0], marks[i, 1]
        births[i] = tick
        motion[i] = 0
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
                motion[i] = max(motion[i], 2 if tick - eldest >= walk_ticks else 1)
                break
        for k in range(hits.shape[0]):
            if max(abs(hits[k, 0] - x), abs(hits[k, 1] - y)) <= 0.6 * cell:
                hit_ticks[i] = tick
                break
        if beside and tick - births[i] < limits[0]:
            motion[i] = max(motion[i], beside)
            if is_new and not has_come and beside == 1:
                births[i] = youngest  # a part of a body that came then, seen only now
        if is_beside_thing and motion[i] == 0:
            births[i] = min(births[i], tick - limits[0])


@njit(cache=True)
def restless_gap(marks, births, motion, times, x, y):
    """Distance [m] of a place from the nearest mark that may be a walking person; inf without one.

    Args:
        marks: (n, 2) [m] in map.
        births: (n,) ticks in which the marks appeared.
        motion: (n,) see `inherit`.
        times: (tick, limits), see `inherit`.
        x: [m] of the place, in map.
        y: [m] of the place, in map.
    """
    tick, limits = times
    best = 1e20
    for k in range(marks.shape[0]):
        if tick - births[k] >= limits[motion[k]]:
            continue
        dx = marks[k, 0] - x
        dy = marks[k, 1] - y
        best = min(best, dx * dx + dy * dy)
    return math.sqrt(best) if best < 1e20 else math.inf
