"""Bare numba kernels on distance fields and polylines; checked faces are in terrain.py."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

INFINITE = 1e20


@njit(cache=True)
def squared_distance_1d(f, out, vertices, bounds):
    """Lower envelope of parabolas (Felzenszwalb & Huttenlocher 2012, algorithm 1)."""
    n = f.shape[0]
    k = 0
    vertices[0] = 0
    bounds[0] = -INFINITE
    bounds[1] = INFINITE
    for q in range(1, n):
        s = 0.0
        while True:
            r = vertices[k]
            s = ((f[q] + q * q) - (f[r] + r * r)) / (2.0 * q - 2.0 * r)
            if s > bounds[k]:
                break
            k -= 1
        k += 1
        vertices[k] = q
        bounds[k] = s
        bounds[k + 1] = INFINITE
    k = 0
    for q in range(n):
        while bounds[k + 1] < q:
            k += 1
        r = vertices[k]
        out[q] = (q - r) * (q - r) + f[r]


@njit(cache=True)
def distance_cells(occupied):
    """Exact Euclidean distance [cells] from each cell centre to the nearest occupied centre."""
    height, width = occupied.shape
    squared = np.empty((height, width))
    longest = max(height, width)
    vertices = np.empty(longest + 1, np.int64)
    bounds = np.empty(longest + 2)
    line = np.empty(longest)
    out = np.empty(longest)
    limit = float(height * height + width * width) * 4.0
    for c in range(width):
        for r in range(height):
            line[r] = 0.0 if occupied[r, c] else limit
        squared_distance_1d(line[:height], out[:height], vertices, bounds)
        for r in range(height):
            squared[r, c] = out[r]
    for r in range(height):
        for c in range(width):
            line[c] = squared[r, c]
        squared_distance_1d(line[:width], out[:width], vertices, bounds)
        for c in range(width):
            squared[r, c] = math.sqrt(out[c])
    return squared


@njit(cache=True)
def sample(field, origin_x, origin_y, resolution, x, y):
    """Bilinear value of a cell-centred field; the border value outside."""
    height, width = field.shape
    u = (x - origin_x) / resolution - 0.5
    v = (y - origin_y) / resolution - 0.5
    u = min(max(u, 0.0), width - 1.001)
    v = min(max(v, 0.0), height - 1.001)
    c = int(u)
    r = int(v)
    fu = u - c
    fv = v - r
    return (1.0 - fv) * ((1.0 - fu) * field[r, c] + fu * field[r, c + 1]) + fv * (
        (1.0 - fu) * field[r + 1, c] + fu * field[r + 1, c + 1]
    )


@njit(cache=True)
def sample_lattice(field, origin_x, origin_y, resolution, lattice, step):
    """Fill `lattice` (h, w), cells of `step` from the same origin, with bilinear samples."""
    for r in range(lattice.shape[0]):
        for c in range(lattice.shape[1]):
            lattice[r, c] = sample(
                field,
                origin_x,
                origin_y,
                resolution,
                origin_x + (c + 0.5) * step,
                origin_y + (r + 0.5) * step,
            )


@njit(cache=True)
def window_max(field, reach, out):
    """Largest value within `reach` cells (a disc) of each cell."""
    height, width = field.shape
    for r in range(height):
        for c in range(width):
            best = field[r, c]
            for i in range(max(0, r - reach), min(height, r + reach + 1)):
                for j in range(max(0, c - reach), min(width, c + reach + 1)):
                    if (i - r) * (i - r) + (j - c) * (j - c) <= reach * reach:
                        best = max(best, field[i, j])
            out[r, c] = best


@njit(cache=True)
def nearest_squared(points, count, x, y):
    """Smallest squared distance of (x, y) to the first `count` points."""
    best = INFINITE
    for k in range(count):
        dx = points[k, 0] - x
        dy = points[k, 1] - y
        d = dx * dx + dy * dy
        if d < best:
            best = d
    return best


@njit(cache=True)
def stamp_discs(grid, origin_x, origin_y, step, points, count, radius, value):
    """Raise the cells within `radius` of the points to at least `value`."""
    height, width = grid.shape
    for k in range(count):
        x = (points[k, 0] - origin_x) / step - 0.5
        y = (points[k, 1] - origin_y) / step - 0.5
        reach = radius / step
        for r in range(max(0, math.ceil(y - reach)), min(height, math.floor(y + reach) + 1)):
            for c in range(max(0, math.ceil(x - reach)), min(width, math.floor(x + reach) + 1)):
                if (c - x) * (c - x) + (r - y) * (r - y) < reach * reach:
                    if grid[r, c] < value:
                        grid[r, c] = value


@njit(cache=True)
def smooth_path(points, passes, reach, field, frame, floor, blocked, blocked_frame, out):
    """Moving average of +-`reach` points, kept where it stays clear.

    frame = (origin_x, origin_y, resolution) of `field` (distances), likewise blocked_frame of
    `blocked` (a point may not enter a cell whose value is larger than where it was).
    """
    n = points.shape[0]
    for k in range(n):
        out[k, 0] = points[k, 0]
        out[k, 1] = points[k, 1]
    previous = points.copy()
    for _ in range(passes):
        for k in range(1, n - 1):
            half = min(reach, k, n - 1 - k)
            x = 0.0
            y = 0.0
            for j in range(k - half, k + half + 1):
                x += previous[j, 0]
                y += previous[j, 1]
            x /= 2 * half + 1
            y /= 2 * half + 1
            now = sample(field, frame[0], frame[1], frame[2], x, y)
            if now < floor and now < sample(
                field, frame[0], frame[1], frame[2], previous[k, 0], previous[k, 1]
            ):
                x, y = previous[k, 0], previous[k, 1]
            elif cell_value(blocked, blocked_frame, x, y) > cell_value(
                blocked, blocked_frame, previous[k, 0], previous[k, 1]
            ):
                x, y = previous[k, 0], previous[k, 1]
            out[k, 0] = x
            out[k, 1] = y
        for k in range(n):
            previous[k, 0] = out[k, 0]
            previous[k, 1] = out[k, 1]


@njit(cache=True)
def cell_value(grid, frame, x, y):
    """Value of the cell that holds (x, y); frame = (origin_x, origin_y, resolution)."""
    r = math.floor((y - frame[1]) / frame[2])
    c = math.floor((x - frame[0]) / frame[2])
    if r < 0 or c < 0 or r >= grid.shape[0] or c >= grid.shape[1]:
        return grid[0, 0] * 0 + np.float32(1e9)
    return grid[r, c]


@njit(cache=True)
def lift_off_walls(points, field, frame, wanted, rounds):
    """Move inner points up the distance field until `wanted` clearance, a centimetre a round."""
    eps = frame[2]
    for _ in range(rounds):
        for k in range(1, points.shape[0] - 1):
            x = points[k, 0]
            y = points[k, 1]
            here = sample(field, frame[0], frame[1], frame[2], x, y)
            if here >= wanted:
                continue
            gx = sample(field, frame[0], frame[1], frame[2], x + eps, y) - sample(
                field, frame[0], frame[1], frame[2], x - eps, y
            )
            gy = sample(field, frame[0], frame[1], frame[2], x, y + eps) - sample(
                field, frame[0], frame[1], frame[2], x, y - eps
            )
            norm = math.hypot(gx, gy)
            if norm < 1e-6:
                continue
            step = min(0.01, wanted - here)
            x += step * gx / norm
            y += step * gy / norm
            if sample(field, frame[0], frame[1], frame[2], x, y) > here:
                points[k, 0] = x
                points[k, 1] = y


@njit(cache=True)
def resample(points, spacing, out):
    """Write points every `spacing` along the polyline, the last one exact; return the count."""
    n = points.shape[0]
    out[0, 0] = points[0, 0]
    out[0, 1] = points[0, 1]
    count = 1
    carried = 0.0
    for k in range(1, n):
        dx = points[k, 0] - points[k - 1, 0]
        dy = points[k, 1] - points[k - 1, 1]
        length = math.hypot(dx, dy)
        if length < 1e-12:
            continue
        along = spacing - carried
        while along <= length and count < out.shape[0] - 1:
            out[count, 0] = points[k - 1, 0] + dx * along / length
            out[count, 1] = points[k - 1, 1] + dy * along / length
            count += 1
            along += spacing
        carried = length - (along - spacing)
    last = math.hypot(points[n - 1, 0] - out[count - 1, 0], points[n - 1, 1] - out[count - 1, 1])
    if last > 0.2 * spacing or count == 1:
        if last > 1e-6:
            out[count, 0] = points[n - 1, 0]
            out[count, 1] = points[n - 1, 1]
            count += 1
    else:
        out[count - 1, 0] = points[n - 1, 0]
        out[count - 1, 1] = points[n - 1, 1]
    return count
