"""Bare numba kernels: which marks have moved, and how old they are."""

from __future__ import annotations

import math

from numba import njit


@njit(cache=True)
def passed_through(points, ranges, beam, pose, limits, out):
    """Flag points that all rays of a scan around their bearing went beyond.

    beam = (angle_min, angle_increment, range_min); pose = (x, y, yaw) of the LiDAR in map;
    limits = (max_range, margin).
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
    """Write birth, motion and time of the last hit of marks.

    old = (points (m, 2), births, has_moved, hit_ticks); seen = (hits, arrivals);
    sizes = (cell, body); times = (tick, still_ticks, mover_ticks);
    out = (births, has_moved, hit_ticks).
    """
    points, old_births, old_moved, old_hits = old
    hits, arrivals = seen
    births, has_moved, hit_ticks = out
    cell, body = sizes
    tick, still_ticks, mover_ticks = times
    for i in range(marks.shape[0]):
        x, y = marks[i, 0], marks[i, 1]
        births[i] = tick
        has_moved[i] = False
        hit_ticks[i] = tick
        is_beside_thing = is_beside_mover = False
        for k in range(arrivals.shape[0]):
            if max(abs(arrivals[k, 0] - x), abs(arrivals[k, 1] - y)) <= cell:
                has_moved[i] = True
                break
        for j in range(points.shape[0]):
            gap = max(abs(points[j, 0] - x), abs(points[j, 1] - y))
            if gap > body:
                continue
            age = tick - old_births[j]
            if gap < 0.5 * cell:
                births[i] = old_births[j]
                hit_ticks[i] = old_hits[j]
                has_moved[i] = has_moved[i] or old_moved[j]
            if old_moved[j]:
                is_beside_mover = is_beside_mover or age < mover_ticks
            elif age >= still_ticks and gap < 1.6 * cell:
                is_beside_thing = True
        for k in range(hits.shape[0]):
            if max(abs(hits[k, 0] - x), abs(hits[k, 1] - y)) <= 0.6 * cell:
                hit_ticks[i] = tick
                break
        if is_beside_mover and tick - births[i] < still_ticks:
            has_moved[i] = True
        if is_beside_thing and not has_moved[i]:
            births[i] = min(births[i], tick - still_ticks)


@njit(cache=True)
def restless_gap(marks, births, has_moved, times, x, y):
    """Distance of (x, y) from the nearest mark that may walk on; times as above."""
    tick, still_ticks, mover_ticks = times
    best = 1e20
    for k in range(marks.shape[0]):
        if tick - births[k] >= (mover_ticks if has_moved[k] else still_ticks):
            continue
        dx = marks[k, 0] - x
        dy = marks[k, 1] - y
        best = min(best, dx * dx + dy * dy)
    return math.sqrt(best) if best < 1e20 else math.inf
