"""Bare numba kernels of what a policy sees of its neighbours and of its way."""

from __future__ import annotations

import math

from swarm_common.process.numba_compat import njit

TAU = 2.0 * math.pi


@njit(cache=True)
def nearest(poses, twists, reach, heard, rows):
    """Write what each of the first m robots hears of its nearest neighbours.

    Args:
        poses: (n, 3) x, y [m], yaw [rad] in map.
        twists: (n, 3) vx [m/s], wz [rad/s], vy.
        reach: [m] up to which a neighbour counts.
        heard: (m, k, 6) zeros; rows of 1, x, y, yaw in base_footprint, vx, wz, the nearest first.
        rows: (m, k) receives the indices of these neighbours; the own one where there is none.
    """
    for i in range(heard.shape[0]):
        cos, sin = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        rows[i] = i
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
            last, before, rows[i, k] = best, found, found
            dx, dy = poses[found, 0] - poses[i, 0], poses[found, 1] - poses[i, 1]
            turn = poses[found, 2] - poses[i, 2]
            row = heard[i, k]
            row[0] = 1.0
            row[1], row[2] = cos * dx + sin * dy, cos * dy - sin * dx
            row[3] = turn - TAU * round(turn / TAU)
            row[4], row[5] = twists[found, 0], twists[found, 1]


@njit(cache=True)
def draw_neighbours(poses, twists, cell, images):
    """Write images of the neighbours of the first m robots, which look up in them.

    A neighbour at x, y in base_footprint is in row h/2 - x/cell and column w/2 - y/cell.

    Args:
        poses: (n, 3) x, y [m], yaw [rad] in map.
        twists: (n, 3) vx [m/s], wz [rad/s], vy.
        cell: [m] edge of a pixel.
        images: (m, 3, h, w) zeros; receives 1, and the velocity vx, vy [m/s] in base_footprint.
    """
    height, width = images.shape[2], images.shape[3]
    for i in range(images.shape[0]):
        cos, sin = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        for j in range(poses.shape[0]):
            dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
            row = math.floor(height / 2 - (cos * dx + sin * dy) / cell)
            column = math.floor(width / 2 - (cos * dy - sin * dx) / cell)
            if j == i or row < 0 or row >= height or column < 0 or column >= width:
                continue
            turn = poses[j, 2] - poses[i, 2]
            images[i, 0, row, column] = 1.0
            images[i, 1, row, column] = twists[j, 0] * math.cos(turn)
            images[i, 2, row, column] = twists[j, 0] * math.sin(turn)


@njit(cache=True)
def along_ways(lengths, frame, poses, steps, left, ahead):
    """Follow each robot's shortest way, downhill from cell to cell.

    Args:
        lengths: (m, h, w) [m] of the ways from each cell to the goal of each robot.
        frame: `distance_kernels.Frame` of the cells.
        poses: (n, 3) x, y [m], yaw [rad] in map, n >= m.
        steps: Cells to go ahead.
        left: (m,) receives the length of the way that is left [m].
        ahead: (m, 2) receives where the robot is after these cells [m] in map; the last of them
            where its way ends before.
    """
    height, width = lengths.shape[1], lengths.shape[2]
    for i in range(lengths.shape[0]):
        across = (poses[i, 0] - frame.origin_x) / frame.step - 0.5
        up = (poses[i, 1] - frame.origin_y) / frame.step - 0.5
        c = min(max(math.floor(across), 0), width - 2)
        r = min(max(math.floor(up), 0), height - 2)
        u, v = min(max(across - c, 0.0), 1.0), min(max(up - r, 0.0), 1.0)
        low = (1.0 - u) * lengths[i, r, c] + u * lengths[i, r, c + 1]
        high = (1.0 - u) * lengths[i, r + 1, c] + u * lengths[i, r + 1, c + 1]
        left[i] = (1.0 - v) * low + v * high
        r, c = r + int(v > 0.5), c + int(u > 0.5)
        for _ in range(steps):
            best, to_r, to_c = lengths[i, r, c], r, c
            for k in range(max(r - 1, 0), min(r + 2, height)):
                for j in range(max(c - 1, 0), min(c + 2, width)):
                    if lengths[i, k, j] < best:
                        best, to_r, to_c = lengths[i, k, j], k, j
            if to_r == r and to_c == c:
                break
            r, c = to_r, to_c
        ahead[i, 0] = frame.origin_x + (c + 0.5) * frame.step
        ahead[i, 1] = frame.origin_y + (r + 0.5) * frame.step
