"""Slow twin of the graph search: Dijkstra over an explicit table of edges."""

import heapq
import itertools
import math

import numpy as np
from numpy.typing import NDArray

WALL = 1e9
Floats = NDArray[np.float32]
Edges = dict[int, list[tuple[int, float]]]

STEPS = [(a, b) for a in range(-2, 3) for b in range(-2, 3) if math.gcd(a, b) == 1]


def between(row: int, column: int, dr: int, dc: int) -> list[tuple[int, int]]:
    """Return the cells that a move sweeps on its way, without its ends."""
    if abs(dr) + abs(dc) == 1:
        return []
    if abs(dr) == abs(dc) == 1:
        return [(row + dr, column), (row, column + dc)]
    if abs(dr) == 2:
        return [(row + dr // 2, column), (row + dr // 2, column + dc)]
    return [(row, column + dc // 2), (row + dr, column + dc // 2)]


def edges(base: Floats, lane: Floats, heading: Floats, extra: Floats, step: float) -> Edges:
    """Return the directed edges {node: [(neighbour, cost)]} of a lattice."""
    height, width = base.shape
    table: Edges = {node: [] for node in range(height * width)}
    for row, column in np.ndindex(height, width):
        for dr, dc in STEPS:
            i, j = row + dr, column + dc
            if not (0 <= i < height and 0 <= j < width):
                continue
            swept = [*between(row, column, dr, dc), (i, j)]
            if any(base[cell] >= WALL for cell in swept) or extra[i, j] >= WALL:
                continue
            length = math.hypot(dr, dc) * step
            direction = np.array((dc, dr)) / math.hypot(dr, dc)
            against = (1.0 - float(direction @ heading[i, j])) / 2.0
            cost = length * (float(base[i, j]) + float(lane[i, j]) * against + float(extra[i, j]))
            table[row * width + column].append((i * width + j, cost))
    return table


def distances(table: Edges, start: int) -> dict[int, float]:
    """Return the cost of the cheapest way from `start` to every node that can be reached."""
    best: dict[int, float] = {}
    queue = [(0.0, start)]
    while queue:
        cost, node = heapq.heappop(queue)
        if node in best:
            continue
        best[node] = cost
        for other, price in table[node]:
            if other not in best:
                heapq.heappush(queue, (cost + price, other))
    return best


def path_cost(table: Edges, path: list[int]) -> float:
    """Return the cost of a path; KeyError if it uses a move that does not exist."""
    total = 0.0
    for a, b in itertools.pairwise(path):
        total += dict(table[a])[b]
    return total
