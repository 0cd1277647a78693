"""Bare numba kernels on distance fields; checked faces are in terrain.py and crowd.py."""

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
def stamp_discs(grid, frame, points, count, radius, value):
    """Raise the cells within `radius` of the points to at least `value`.

    frame = (origin_x, origin_y, step). Cells are taken row by row, from the first to the last
    one whose centre is inside.
    """
    height, width = grid.shape
    origin_x, origin_y, step = frame
    reach = radius / step
    limit = reach * reach
    for k in range(count):
        x = (points[k, 0] - origin_x) / step - 0.5
        y = (points[k, 1] - origin_y) / step - 0.5
        for r in range(max(0, math.ceil(y - reach)), min(height, math.floor(y + reach) + 1)):
            aside = (r - y) * (r - y)
            half = math.sqrt(max(0.0, limit - aside))
            first = max(0, math.ceil(x - half) - 1)
            last = min(width - 1, math.floor(x + half) + 1)
            while first <= last and (first - x) * (first - x) + aside >= limit:
                first += 1
            while last >= first and (last - x) * (last - x) + aside >= limit:
                last -= 1
            for c in range(first, last + 1):
                grid[r, c] = max(grid[r, c], value)


@njit(cache=True)
def stamp_rows(grid, frame, points, sizes, radii, values):
    """Stamp discs of one radius and value per row; points (n, k, 2), sizes (n,) of them count."""
    for row in range(sizes.shape[0]):
        stamp_discs(grid, frame, points[row], sizes[row], radii[row], values[row])


@njit(cache=True)
def untouched(stamped, allowed, out):
    """Fill `out` with 1 where nothing is stamped and `allowed` is not 0, with 0 elsewhere."""
    for r in range(out.shape[0]):
        for c in range(out.shape[1]):
            out[r, c] = 1 if stamped[r, c] == 0.0 and allowed[r, c] != 0 else 0
