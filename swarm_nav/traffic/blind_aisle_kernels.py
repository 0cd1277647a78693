"""Bare numba kernel that finds blind aisles: floor around a station with one narrow mouth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit


@njit(cache=True)
def blind_floor(
    distances: NDArray[np.float32],
    step: float,
    within: tuple[float, float],
    farthest: float,
    widest: float,
) -> float:
    """Return the floor [m²] of the largest blind aisle around a station, 0.0 if there is none.

    A blind aisle is the floor within some distance of the station if all its cells from which the
    floor goes on lie in a square of `widest`, and `least` or more lies beyond them: the last corner
    of a closed room leads nowhere.

    Args:
        distances: (h, w) [m] by the way from each lattice cell to the station; inf without one.
        step: [m] of a cell.
        within: (least, most) [m²] of floor.
        farthest: Largest distance [m] of the mouth.
        widest: [m] edge of the square.
    """
    least, most = within
    height, width = distances.shape
    all_cells = np.isfinite(distances).sum()
    found = 0.0
    for number in range(1, int(farthest / step) + 1):
        mouth = number * step
        top, bottom, left, right, cells = height, -1, width, -1, 0
        for r in range(height):
            for c in range(width):
                if not distances[r, c] <= mouth:
                    continue
                cells += 1
                leads_on = False
                for y, x in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)):
                    if 0 <= y < height and 0 <= x < width:
                        leads_on |= mouth < distances[y, x] < np.inf
                if leads_on:
                    top, bottom = min(top, r), max(bottom, r)
                    left, right = min(left, c), max(right, c)
        floor = cells * step * step
        beyond = (all_cells - cells) * step * step
        if floor >= most or beyond < least:
            break
        if floor >= least and step * max(bottom - top, right - left) < widest:
            found = floor
    return found
