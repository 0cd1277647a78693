"""Bare numba kernels on distance fields; checked faces are in terrain.py and traffic_costs.py."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit

INFINITE = 1e20

Floats = NDArray[np.float64] | NDArray[np.float32]


class Frame(NamedTuple):
    """Position of a grid's cells in map.

    The centre of cell (r, c) is at (origin_x + (c + 0.5) step, origin_y + (r + 0.5) step).
    """

    origin_x: float  # [m] of the lower left corner
    origin_y: float
    step: float  # [m] edge of a cell


class Place(NamedTuple):
    """A pose in map, [m] and [rad]."""

    x: float
    y: float
    yaw: float


class Field(NamedTuple):
    """Distances to the nearest wall."""

    distance: NDArray[np.float64]  # (height, width) [m]
    frame: Frame


@njit(cache=True)
def squared_distance_1d(
    f: Floats, out: Floats, vertices: NDArray[np.int64], bounds: Floats
) -> None:
    """Transform one line: out[q] = min over r of (q - r)² + f[r].

    The lower envelope of parabolas (Felzenszwalb & Huttenlocher 2012, algorithm 1).

    Args:
        f: (n,) squared distances [cells²] so far; a large number where nothing is occupied.
        out: (n,) receives the result; not the same array as `f`.
        vertices: (n,) int64 scratch: the parabolas of the envelope.
        bounds: (n + 1,) scratch: where each of the parabolas begins.
    """
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
def face_distance(occupied: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Exact Euclidean distance from each cell centre to the nearest occupied cell, a square.

    The nearest point of a square lies in the middle of the centre's row or column or half a cell
    from it: so the transform has points at half cells, too.

    Args:
        occupied: (h, w) bool.

    Returns:
        (h, w) [cells], 0 on occupied cells.
    """
    height, width = occupied.shape
    distance = np.empty((height, width))
    longest = 2 * max(height, width) + 1
    vertices = np.empty(longest + 1, np.int64)
    bounds = np.empty(longest + 2)
    line = np.empty(longest)
    out = np.empty(longest)
    limit = float(height * height + width * width) * 16.0
    for c in range(width):
        for r in range(height):
            distance[r, c] = 0.0 if occupied[r, c] else limit
        _to_faces(distance[:, c], line, out, vertices, bounds)
    for r in range(height):
        _to_faces(distance[r], line, out, vertices, bounds)
        for c in range(width):
            distance[r, c] = math.sqrt(distance[r, c]) / 2.0
    return distance


@njit(cache=True)
def _to_faces(
    cells: Floats, line: Floats, out: Floats, vertices: NDArray[np.int64], bounds: Floats
) -> None:
    """Transform one line of cells (n,), whose faces have the smaller value of both sides."""
    n = cells.shape[0]
    line[0] = cells[0]
    for k in range(n):
        line[2 * k + 1] = cells[k]
        line[2 * k + 2] = min(cells[k], cells[min(k + 1, n - 1)])
    squared_distance_1d(line[: 2 * n + 1], out[: 2 * n + 1], vertices, bounds)
    for k in range(n):
        cells[k] = out[2 * k + 1]


@njit(cache=True)
def sample(field: Floats, frame: Frame, x: float, y: float) -> float:
    """Return the bilinear value of a cell-centred field (h, w) at (x, y) [m] in map.

    Outside of the field it is the value at the border.

    Args:
        field: (h, w), each at least 2.
        x: [m] in map.
        y: [m] in map.
    """
    height, width = field.shape
    u = (x - frame.origin_x) / frame.step - 0.5
    v = (y - frame.origin_y) / frame.step - 0.5
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
def sample_lattice(field: Floats, frame: Frame, lattice: Floats, step: float) -> None:
    """Fill `lattice` (h, w), cells of `step` [m] from the same origin, with bilinear samples.

    Args:
        field: (h, w).
        lattice: (h, w) receives the samples.
        step: [m] edge of its cells.
    """
    for r in range(lattice.shape[0]):
        for c in range(lattice.shape[1]):
            x = frame.origin_x + (c + 0.5) * step
            y = frame.origin_y + (r + 0.5) * step
            lattice[r, c] = sample(field, frame, x, y)


@njit(cache=True)
def stamp_discs(
    grid: Floats, frame: Frame, points: Floats, count: int, radius: float, value: float
) -> None:
    """Raise the cells of a grid (h, w) within `radius` of the points to at least `value`.

    Cells are taken row by row, from the first to the last one whose centre is inside.

    Args:
        grid: (h, w), changed.
        points: (n, 2) [m] in map.
        count: Number of points that count, from the first on.
        radius: [m].
        value: At least this much.
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
def stamp_rows(
    grid: Floats,
    frame: Frame,
    points: Floats,
    sizes: NDArray[np.integer],
    radii: Floats,
    values: Floats,
) -> None:
    """Stamp discs of one radius and value per row; points (n, k, 2), sizes (n,) of them count.

    Args:
        grid: (h, w) to raise.
        points: (n, k, 2) [m] in map.
        sizes: (n,) of the points that count.
        radii: (n,) [m].
        values: (n,) at least this much.
    """
    for row in range(sizes.shape[0]):
        stamp_discs(grid, frame, points[row], sizes[row], radii[row], values[row])
