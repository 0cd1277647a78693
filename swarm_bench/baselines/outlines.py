"""Walls of a map as polygons, for methods that want them so."""

from __future__ import annotations

import functools
import math
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import FloatArray

TOLERANCE = 0.75  # [cells] that a polygon may be off the cells' edges: stairs become slopes

Corner = tuple[int, int]  # column, row


def wall_outlines(grid: Grid) -> tuple[FloatArray, ...]:
    """Return the outlines (n, 2) [m] of the occupied areas: solids to the left of their edges.

    Outer outlines are counterclockwise, those of holes (a room inside its walls) clockwise.

    Args:
        grid: The map, upright; unknown cells count as free.
    """
    shape = (grid.height, grid.width)
    return _outlines(grid.cells.tobytes(), shape, grid.resolution, (grid.origin_x, grid.origin_y))


@functools.lru_cache(maxsize=4)
def _outlines(
    cells: bytes, shape: tuple[int, int], resolution: float, origin: tuple[float, float]
) -> tuple[FloatArray, ...]:
    occupied = np.frombuffer(cells, np.int8).reshape(shape) == OCCUPIED
    polygons = [simplified(np.array(loop, np.float64), TOLERANCE) for loop in loops(occupied)]
    return tuple(polygon * resolution + origin for polygon in polygons if len(polygon) > 2)


def loops(occupied: NDArray[np.bool_]) -> list[list[Corner]]:
    """Return the closed chains of cell corners around occupied cells, cells on the left.

    Args:
        occupied: (rows, columns).

    Returns:
        The corners of each chain, the first not repeated at the end.
    """
    ahead = _edges(occupied)
    chains: list[list[Corner]] = []
    while ahead:
        start = next(iter(ahead))
        chain, here, before = [start], start, None
        while True:
            here, before = _step(ahead, here, before), here
            if here == start:
                break
            chain.append(here)
        chains.append(chain)
    return chains


def _edges(occupied: NDArray[np.bool_]) -> dict[Corner, list[Corner]]:
    """Return the directed edges between occupied and free cells, by where they begin."""
    solid = np.pad(occupied, 1)
    ahead: dict[Corner, list[Corner]] = defaultdict(list)
    rows, columns = np.nonzero(occupied)
    for r, c in zip(rows.tolist(), columns.tolist(), strict=True):
        if not solid[r, c + 1]:
            ahead[c, r].append((c + 1, r))
        if not solid[r + 1, c + 2]:
            ahead[c + 1, r].append((c + 1, r + 1))
        if not solid[r + 2, c + 1]:
            ahead[c + 1, r + 1].append((c, r + 1))
        if not solid[r + 1, c]:
            ahead[c, r + 1].append((c, r))
    return ahead


def _step(ahead: dict[Corner, list[Corner]], here: Corner, before: Corner | None) -> Corner:
    """Remove an edge from the pool; where two cells touch at a corner, stay with the same cell."""
    choices = ahead[here]
    index = 0
    if before is not None and len(choices) > 1:
        dx, dy = here[0] - before[0], here[1] - before[1]
        turns = [dx * (y - here[1]) - dy * (x - here[0]) for x, y in choices]
        index = int(np.argmax(turns))
    chosen = choices.pop(index)
    if not choices:
        del ahead[here]
    return chosen


def simplified(loop: FloatArray, tolerance: float) -> FloatArray:
    """Return a closed polygon with fewer corners (Douglas, Peucker 1973).

    Args:
        loop: Corners (n, 2), the first not repeated at the end.
        tolerance: By which corners that are left out may be off, in the unit of `loop`.

    Returns:
        Corners (m, 2) of `loop`, m at most n.
    """
    far = int(np.hypot(*(loop - loop[0]).T).argmax())
    first = _simplified_chain(loop[: far + 1], tolerance)
    second = _simplified_chain(np.vstack((loop[far:], loop[:1])), tolerance)
    return np.vstack((first[:-1], second[:-1]))


def _simplified_chain(chain: FloatArray, tolerance: float) -> FloatArray:
    if len(chain) < 3:
        return chain
    along = chain[-1] - chain[0]
    length = math.hypot(*along)
    offset = chain - chain[0]
    if length > 0.0:
        gaps = np.abs(along[0] * offset[:, 1] - along[1] * offset[:, 0]) / length
    else:
        gaps = np.hypot(offset[:, 0], offset[:, 1])
    worst = int(gaps.argmax())
    if gaps[worst] <= tolerance:
        return chain[[0, -1]]
    left = _simplified_chain(chain[: worst + 1], tolerance)
    right = _simplified_chain(chain[worst:], tolerance)
    return np.vstack((left[:-1], right))
