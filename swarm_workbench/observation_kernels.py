"""Bare numba kernels of what a policy sees of its neighbours."""

from __future__ import annotations

import math

from swarm_common.process.numba_compat import njit

TAU = 2.0 * math.pi


@njit(cache=True)
def nearest(poses, twists, reach, heard):
    """Write what each of the first m robots hears of its nearest neighbours.

    Args:
        poses: (n, 3) x, y [m], yaw [rad] in map.
        twists: (n, 3) vx [m/s], wz [rad/s], vy.
        reach: [m] up to which a neighbour counts.
        heard: (m, k, 6) zeros; rows of 1, x, y, yaw in base_footprint, vx, wz, the nearest first.
    """
    for i in range(heard.shape[0]):
        cos, sin = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        last = -1.0  # squared distance of the neighbour before
        before = -1
        for k in range(heard.shape[1]):
            best, found = reach * reach, -1
            for j in range(poses.shape[0]):
                gap = (poses[j, 0] - poses[i, 0]) ** 2 + (poses[j, 1] - poses[i, 1]) ** 2
                is_later = gap > last or (gap == last and j > before)
                if j != i and is_later and (gap < best or (found < 0 and gap == best)):
                    best, found = gap, j
            if found < 0:
                break
            last, before = best, found
            dx, dy = poses[found, 0] - poses[i, 0], poses[found, 1] - poses[i, 1]
            turn = poses[found, 2] - poses[i, 2]
            row = heard[i, k]
            row[0] = 1.0
            row[1], row[2] = cos * dx + sin * dy, cos * dy - sin * dx
            row[3] = turn - TAU * round(turn / TAU)
            row[4], row[5] = twists[found, 0], twists[found, 1]
