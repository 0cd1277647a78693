"""Numba kernel on occupancy cells: the connected parts of free space."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray


@numba.njit(cache=True)
def flood(cells: NDArray[np.int8], seeds: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which cells are connected to a seed through free cells (four neighbours).

    Args:
        cells: int8 (height, width); 0 is free.
        seeds: Rows and columns (n, 2); those outside or not free are ignored.
    """
    height, width = cells.shape
    reached = np.zeros((height, width), np.bool_)
    stack = np.empty((height * width, 2), np.int64)
    size = 0
    for i in range(len(seeds)):
        row, column = seeds[i, 0], seeds[i, 1]
        if 0 <= row < height and 0 <= column < width and cells[row, column] == 0:
            if not reached[row, column]:
                reached[row, column] = True
                stack[size, 0], stack[size, 1] = row, column
                size += 1
    while size > 0:
        size -= 1
        row, column = stack[size, 0], stack[size, 1]
        for k in range(4):
            r = row + (1 if k == 0 else -1 if k == 1 else 0)
            c = column + (1 if k == 2 else -1 if k == 3 else 0)
            if 0 <= r < height and 0 <= c < width and cells[r, c] == 0 and not reached[r, c]:
                reached[r, c] = True
                stack[size, 0], stack[size, 1] = r, c
                size += 1
    return reached
