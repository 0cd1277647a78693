"""Bare numba kernels of the conditions of a run: the blind ends of lanes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit


@njit(cache=True)
def steps_from(mask: NDArray[np.bool_], seeds: NDArray[np.bool_], out: NDArray[np.int32]) -> None:
    """Write how many steps each cell is from the nearest seed (breadth-first, eight neighbours).

    Args:
        mask: (h, w) cells that may be stepped on.
        seeds: (h, w) cells where steps begin.
        out: (h, w), filled with -1, which stays where no way leads; changed.
    """
    height, width = mask.shape
    queue = np.empty((height * width, 2), np.int64)
    first = last = 0
    for i in range(height):
        for j in range(width):
            if seeds[i, j]:
                out[i, j] = 0
                queue[last, 0], queue[last, 1] = i, j
                last += 1
    while first < last:
        i, j = queue[first]
        first += 1
        for r in range(max(0, i - 1), min(height, i + 2)):
            for c in range(max(0, j - 1), min(width, j + 2)):
                if mask[r, c] and out[r, c] < 0:
                    out[r, c] = out[i, j] + 1
                    queue[last, 0], queue[last, 1] = r, c
                    last += 1


@njit(cache=True)
def root_of(parents: NDArray[np.int64], cell: int) -> int:
    """Return the cell that stands for the set of a cell (union-find; halves the way to it).

    Args:
        parents: (n,) a cell of the same set nearer to the root, for the root itself; changed.
        cell: Of the set.
    """
    while parents[cell] != cell:
        parents[cell] = parents[parents[cell]]
        cell = parents[cell]
    return cell


@njit(cache=True)
def peaks(values: NDArray[np.int32], order: NDArray[np.int64], width: int, prominence: int) -> int:
    """Count the peaks that rise by `prominence` or more above the saddle to a higher one, or 0.

    Cells flow together from the highest to the lowest (union-find): where two sets meet, the one
    with the lower peak ends, and counts if it is that high above the meeting point.

    Args:
        values: (h · width,) heights, row after row.
        order: Cells (k,) from the highest to the lowest.
        width: Cells of a row.
        prominence: In the unit of the values.
    """
    parents = np.full(values.shape[0], -1, np.int64)
    count = 0
    for k in range(order.shape[0]):
        cell = order[k]
        parents[cell] = cell
        for down in (-width, 0, width):
            for aside in (-1, 0, 1):
                beside = cell + down + aside
                if not 0 <= beside < values.shape[0] or abs(beside % width - cell % width) > 1:
                    continue
                if parents[beside] < 0:
                    continue
                one, two = root_of(parents, cell), root_of(parents, beside)
                if one == two:
                    continue
                if values[one] > values[two]:
                    one, two = two, one
                if values[one] - values[cell] >= prominence:
                    count += 1
                parents[one] = two
    for k in range(order.shape[0]):
        cell = order[k]
        if parents[cell] == cell and values[cell] >= prominence:
            count += 1
    return count
