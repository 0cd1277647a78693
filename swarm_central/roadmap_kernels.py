"""Times from all vertices of a roadmap to a goal, by heading."""

from __future__ import annotations

import heapq

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def costs_to(
    targets: NDArray[np.int64],
    closed: NDArray[np.bool_],
    neighbors: NDArray[np.int32],
    edges: NDArray[np.float32],
    turns: NDArray[np.float32],
    wait: np.float32,
) -> NDArray[np.float32]:
    """Return (V, 4) [s] to the nearest target: Dijkstra backwards over (vertex, heading).

    Args:
        targets: Vertices, with any heading.
        closed: (V,) vertices that nobody may enter.
        neighbors: (V, 4) vertex in each direction, -1 where there is none.
        edges: (V, 4) [s] of driving there.
        turns: (4, 4) [s] from one heading to another.
        wait: Not used; it is a part of `Costs`.
    """
    count = neighbors.shape[0]
    costs = np.full((count, 4), np.float32(1e9), np.float32)
    heap = [(np.float32(0.0), np.int64(-1))]
    for target in targets:
        for heading in range(4):
            costs[target, heading] = 0.0
            heap.append((np.float32(0.0), np.int64(target * 4 + heading)))
    while len(heap) > 0:
        cost, state = heapq.heappop(heap)
        if state < 0:
            continue
        vertex, heading = state // 4, state % 4
        if cost > costs[vertex, heading]:
            continue
        before = neighbors[vertex, (heading + 2) % 4]
        if before < 0 or closed[vertex]:
            continue
        for old in range(4):
            new = cost + edges[before, heading] + turns[old, heading]
            if new < costs[before, old]:
                costs[before, old] = new
                heapq.heappush(heap, (np.float32(new), np.int64(before * 4 + old)))
    return costs
