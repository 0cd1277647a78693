"""Bare numba kernels of the obstacle layer.

Args of more than one kernel:
    reach: Radii (k,) [m] of these.
    robots: Centres (k, 2) [m] in map of discs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Field, Floats, Place, sample


class Beam(NamedTuple):
    """Directions of a LiDAR's rays."""

    angle_min: float  # [rad] of the first, in the LiDAR's frame
    angle_increment: float  # [rad]
    range_min: float  # [m]


class HitLimits(NamedTuple):
    """Limits of the hits that may be obstacles."""

    max_range: float  # [m]
    static_tolerance: float  # [m] from a mapped wall within which a hit is one of the wall


@njit(cache=True)
def unexplained(
    ranges: NDArray[np.float32],
    beam: Beam,
    pose: Place,
    limits: HitLimits,
    walls: Field,
    robots: Floats,
    reach: Floats,
    out: Floats,
) -> int:
    """Write the hits that neither the map nor a known robot explains; return their number.

    Args:
        ranges: (n,) [m].
        out: Receives points (m, 2) [m] in map.
    """
    near = np.empty(robots.shape[0], np.int64)
    known_count = 0
    for j in range(robots.shape[0]):
        gap = math.hypot(robots[j, 0] - pose.x, robots[j, 1] - pose.y)
        if gap <= limits.max_range + reach[j] + 0.01:
            near[known_count] = j
            known_count += 1
    count = 0
    for k in range(ranges.shape[0]):
        r = ranges[k]
        if not (beam.range_min <= r <= limits.max_range):
            continue
        angle = pose.yaw + beam.angle_min + k * beam.angle_increment
        x = pose.x + r * math.cos(angle)
        y = pose.y + r * math.sin(angle)
        if sample(walls.distance, walls.frame, x, y) < limits.static_tolerance:
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
def ray_at(beam: Beam, rays: int, bearing: float) -> int:
    """Return the index of the ray nearest to a bearing, -1 outside the field of view.

    Args:
        rays: Number of rays in the scan.
        bearing: [rad] in the LiDAR's frame, any multiple of 2π.
    """
    index = round(((bearing - beam.angle_min) % (2.0 * math.pi)) / beam.angle_increment)
    if index >= rays and (rays + 0.5) * beam.angle_increment < 2.0 * math.pi:
        return -1  # a full circle closes
    return index % rays


@njit(cache=True)
def still_there(
    points: Floats,
    ranges: NDArray[np.float32],
    beam: Beam,
    pose: Place,
    max_range: float,
    robots: Floats,
    reach: Floats,
    keep: NDArray[np.bool_],
) -> None:
    """Clear the flags `keep` (n,) of points that a ray passes or that a known robot covers.

    Args:
        points: (n, 2) [m] in map.
        ranges: (m,) [m].
        max_range: [m] up to which rays count.
        keep: (n,) flags, cleared.
    """
    for k in range(points.shape[0]):
        dx = points[k, 0] - pose.x
        dy = points[k, 1] - pose.y
        for j in range(robots.shape[0]):
            ax = points[k, 0] - robots[j, 0]
            ay = points[k, 1] - robots[j, 1]
            if ax * ax + ay * ay < reach[j] * reach[j]:
                keep[k] = False
        d = math.hypot(dx, dy)
        if d > max_range or d < beam.range_min:
            continue
        index = ray_at(beam, ranges.shape[0], math.atan2(dy, dx) - pose.yaw)
        if index >= 0 and ranges[index] > d + 0.1:
            keep[k] = False


@njit(cache=True)
def marked(old: Floats, hits: Floats, cell: float, most: int) -> NDArray[np.float64]:
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
