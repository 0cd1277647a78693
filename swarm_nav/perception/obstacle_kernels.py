"""Bare numba kernels of the obstacle layer."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from swarm_nav.planning.distance_kernels import sample


@njit(cache=True)
def unexplained(ranges, beam, pose, limits, distance, frame, robots, reach, out):
    """Write the hits that neither the map nor a known robot explains.

    Args:
        ranges: (n,) [m] of the scan.
        beam: (angle_min [rad], angle_increment [rad], range_min [m]).
        pose: (x, y, yaw) of the LiDAR in map.
        limits: (max_range, static_tolerance) [m].
        distance: (h, w) [m] to the nearest mapped wall.
        frame: (origin_x, origin_y, resolution) [m] of `distance`.
        robots: (k, 2) [m] in map, centres of discs that hold robots.
        reach: (k,) [m] radii of these discs.
        out: (m, 2) receives the hits in map; further ones are dropped.

    Returns:
        The number of hits written.
    """
    near = np.empty(robots.shape[0], np.int64)
    known_count = 0
    for j in range(robots.shape[0]):
        gap = math.hypot(robots[j, 0] - pose[0], robots[j, 1] - pose[1])
        if gap <= limits[0] + reach[j] + 0.01:
            near[known_count] = j
            known_count += 1
    count = 0
    for k in range(ranges.shape[0]):
        r = ranges[k]
        if not (beam[2] <= r <= limits[0]):
            continue
        angle = pose[2] + beam[0] + k * beam[1]
        x = pose[0] + r * math.cos(angle)
        y = pose[1] + r * math.sin(angle)
        if sample(distance, frame[0], frame[1], frame[2], x, y) < limits[1]:
            continue
        known = False
        for m in range(known_count):
            j = near[m]
            dx = x - robots[j, 0]
            dy = y - robots[j, 1]
            if dx * dx + dy * dy < reach[j] * reach[j]:
                known = True
                break
        if known or count >= out.shape[0]:
            continue
        out[count, 0] = x
        out[count, 1] = y
        count += 1
    return count


@njit(cache=True)
def still_there(points, ranges, beam, pose, max_range, robots, reach, keep):
    """Clear the flags of points that a ray passes through or that a known robot covers.

    Args:
        points: (m, 2) [m] in map.
        ranges: (n,) [m] of the scan.
        beam: (angle_min [rad], angle_increment [rad], range_min [m]).
        pose: (x, y, yaw) of the LiDAR in map.
        max_range: [m] up to which rays clear.
        robots: (k, 2) [m] in map, centres of discs that hold robots.
        reach: (k,) [m] radii of these discs.
        keep: (m,) bool, changed in place.
    """
    n = ranges.shape[0]
    for k in range(points.shape[0]):
        dx = points[k, 0] - pose[0]
        dy = points[k, 1] - pose[1]
        for j in range(robots.shape[0]):
            ax = points[k, 0] - robots[j, 0]
            ay = points[k, 1] - robots[j, 1]
            if ax * ax + ay * ay < reach[j] * reach[j]:
                keep[k] = False
        d = math.hypot(dx, dy)
        if d > max_range or d < beam[2]:
            continue
        angle = math.atan2(dy, dx) - pose[2] - beam[0]
        index = round((angle % (2.0 * math.pi)) / beam[1])
        if index >= n and (n + 0.5) * beam[1] < 2.0 * math.pi:
            continue  # outside the field of view; a full circle closes
        if ranges[index % n] > d + 0.1:
            keep[k] = False


@njit(cache=True)
def marked(old, hits, cell, most):
    """Return the centres (n, 2) of the cells that points lie in, each once, by x and then y.

    Args:
        old: Marks (m, 2).
        hits: New points (k, 2).
        cell: [m] width of a cell.
        most: Largest n; those behind are dropped.
    """
    keys = np.empty(old.shape[0] + hits.shape[0], np.int64)
    for k in range(keys.shape[0]):
        point = old[k] if k < old.shape[0] else hits[k - old.shape[0]]
        keys[k] = (round(point[0] / cell) << 32) + round(point[1] / cell) + (1 << 31)
    keys.sort()
    out = np.empty((keys.shape[0], 2))
    count = 0
    for k in range(keys.shape[0]):
        if count == most:
            break
        if k > 0 and keys[k] == keys[k - 1]:
            continue
        out[count, 0] = (keys[k] >> 32) * cell
        out[count, 1] = ((keys[k] & 0xFFFFFFFF) - (1 << 31)) * cell
        count += 1
    return out[:count].copy()
