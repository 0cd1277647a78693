"""Graph of free cells, for shortest ways over eight neighbours (Dijkstra 1959)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

MOVES = ((0, 1), (1, 0), (1, 1), (1, -1))  # rows down and columns right, each edge once


def way_graph(free: NDArray[np.bool_], step: float) -> csr_matrix:
    """Return the lengths [m] of edges between free cells; nodes are flat indices.

    Args:
        free: (rows, columns) whether a robot's centre may be in a cell.
        step: [m] between neighbours in a row.
    """
    from scipy.sparse import coo_matrix  # takes a while, and not every process needs it

    height, width = free.shape
    numbers = np.arange(free.size).reshape(free.shape)
    starts, ends, lengths = [], [], []
    for down, right in MOVES:
        here = np.s_[: height - down, max(0, -right) : width - max(0, right)]
        there = np.s_[down:, max(0, right) : width + min(0, right)]
        is_edge = free[here] & free[there]
        starts.append(numbers[here][is_edge])
        ends.append(numbers[there][is_edge])
        lengths.append(np.full(int(is_edge.sum()), step * math.hypot(down, right)))
    values, rows, columns = (np.concatenate(parts) for parts in (lengths, starts, ends))
    return coo_matrix((values, (rows, columns)), shape=(free.size, free.size)).tocsr()
