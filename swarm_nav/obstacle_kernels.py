"""Bare numba kernels of the obstacle layer."""

from __future__ import annotations

import math

from numba import njit

from swarm_nav.distance_kernels import sample


@njit(cache=True)
def unexplained(ranges, beam, pose, limits, distance, frame, robots, reach, out):
    """Write the hits that neither the map nor a known robot explains; return their number.

    beam = (angle_min, angle_increment, range_min); pose = (x, y, yaw) of the LiDAR in map;
    limits = (max_range, static_tolerance); robots (k, 2) with reach (k,) are discs.
    """
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
        for j in range(robots.shape[0]):
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
    """Clear the flags of points that a ray passes through or that a known robot covers."""
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
