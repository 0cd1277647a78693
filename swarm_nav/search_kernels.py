"""Bare numba kernels of graph search on the planning lattice: cost-to-go, A*, nearest place.

The lattice has 16 moves per node (8 neighbours and the knight's moves). A directed edge into a
node with unit direction u costs length * (base + lane * (1 - u.h) / 2 + extra), where h is the
direction with the nearer wall on the right and `extra` (>= 0) is what other robots add.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

MOVES = np.array(
    [
        (0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1),
        (1, 2), (2, 1), (-1, 2), (-2, 1), (1, -2), (2, -1), (-1, -2), (-2, -1),
    ],
    np.int64,
)  # fmt: skip  # (row, column)
WALL = np.float32(1e9)  # value of `base` or `extra` that no path may enter


@njit(cache=True)
def heap_push(keys, nodes, size, key, node):
    """Binary heap on two arrays; return the new size."""
    k = size
    while k > 0:
        parent = (k - 1) >> 1
        if keys[parent] <= key:
            break
        keys[k] = keys[parent]
        nodes[k] = nodes[parent]
        k = parent
    keys[k] = key
    nodes[k] = node
    return size + 1


@njit(cache=True)
def heap_pop(keys, nodes, size):
    """Move the last entry into the hole left by the smallest; return the new size."""
    size -= 1
    key = keys[size]
    node = nodes[size]
    k = 0
    while True:
        child = 2 * k + 1
        if child >= size:
            break
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[k] = keys[child]
        nodes[k] = nodes[child]
        k = child
    keys[k] = key
    nodes[k] = node
    return size


@njit(cache=True)
def passable(base, r, c, dr, dc):
    """Whether the move from (r, c) stays on the lattice and clears the cells it passes."""
    i = r + dr
    j = c + dc
    if i < 0 or j < 0 or i >= base.shape[0] or j >= base.shape[1] or base[i, j] >= WALL:
        return False
    if abs(dr) + abs(dc) == 1:
        return True
    if abs(dr) == 1 and abs(dc) == 1:
        return base[i, c] < WALL and base[r, j] < WALL
    if abs(dr) == 2:
        return base[r + dr // 2, c] < WALL and base[r + dr // 2, j] < WALL
    return base[r, c + dc // 2] < WALL and base[i, c + dc // 2] < WALL


@njit(cache=True)
def edge_cost(base, lane, heading, step, i, j, dr, dc):
    """Cost of the move (dr, dc) that ends in (i, j), without other robots."""
    cells = math.sqrt(dr * dr + dc * dc)
    along = (dc * heading[i, j, 0] + dr * heading[i, j, 1]) / cells
    return cells * step * (base[i, j] + lane[i, j] * (1.0 - along) * 0.5)


@njit(cache=True)
def cost_to_go(base, lane, heading, step, goal_r, goal_c):
    """Dijkstra backwards from the goal over directed edges; inf where it cannot be reached."""
    height, width = base.shape
    cost = np.full((height, width), np.inf, np.float32)
    capacity = height * width * 4 + 64
    keys = np.empty(capacity)
    nodes = np.empty(capacity, np.int64)
    cost[goal_r, goal_c] = 0.0
    size = heap_push(keys, nodes, 0, 0.0, goal_r * width + goal_c)
    while size > 0:
        key = keys[0]
        node = nodes[0]
        size = heap_pop(keys, nodes, size)
        r = node // width
        c = node % width
        if key > cost[r, c] + 1e-4:
            continue
        for m in range(16):
            dr = MOVES[m, 0]
            dc = MOVES[m, 1]
            i = r - dr
            j = c - dc
            if i < 0 or j < 0 or i >= height or j >= width or base[i, j] >= WALL:
                continue
            if not passable(base, i, j, dr, dc):
                continue
            new = cost[r, c] + edge_cost(base, lane, heading, step, r, c, dr, dc)
            if new < cost[i, j] - 1e-6 and size < capacity:
                cost[i, j] = new
                size = heap_push(keys, nodes, size, new, i * width + j)
    return cost


@njit(cache=True)
def astar(base, lane, heading, extra, step, start, goal, heuristic, path):
    """A* with an exact static heuristic; return (nodes written to path, expansions).

    0 nodes: no path. `path` receives flat indices from start to goal; `start` and `goal` are
    flat indices, `heuristic` is `cost_to_go` of the goal (admissible, since extra >= 0).
    """
    height, width = base.shape
    cost = np.full(height * width, np.inf, np.float32)
    parent = np.full(height * width, -1, np.int64)
    closed = np.zeros(height * width, np.bool_)
    capacity = height * width * 4 + 64
    keys = np.empty(capacity)
    nodes = np.empty(capacity, np.int64)
    cost[start] = 0.0
    size = heap_push(keys, nodes, 0, heuristic[start // width, start % width], start)
    expansions = 0
    while size > 0:
        node = nodes[0]
        size = heap_pop(keys, nodes, size)
        if closed[node]:
            continue
        closed[node] = True
        expansions += 1
        if node == goal:
            break
        r = node // width
        c = node % width
        for m in range(16):
            dr = MOVES[m, 0]
            dc = MOVES[m, 1]
            if not passable(base, r, c, dr, dc):
                continue
            i = r + dr
            j = c + dc
            other = i * width + j
            if closed[other] or extra[i, j] >= WALL or heuristic[i, j] == np.inf:
                continue
            cells = math.sqrt(dr * dr + dc * dc)
            new = (
                cost[node]
                + edge_cost(base, lane, heading, step, i, j, dr, dc)
                + cells * step * extra[i, j]
            )
            if new < cost[other] and size < capacity:
                cost[other] = new
                parent[other] = node
                size = heap_push(keys, nodes, size, new + heuristic[i, j], other)
    if not closed[goal]:
        return 0, expansions
    return trace_back(parent, goal, path), expansions


@njit(cache=True)
def trace_back(parent, goal, path):
    """Write the chain of parents to `path`, first node first; return its length."""
    count = 0
    node = goal
    while node >= 0 and count < path.shape[0]:
        path[count] = node
        count += 1
        node = parent[node]
    for k in range(count // 2):
        path[k], path[count - 1 - k] = path[count - 1 - k], path[k]
    return count


@njit(cache=True)
def nearest_place(base, extra, places, step, start, reach, path):
    """Dijkstra from `start` to the cheapest node with places > 0 within cost `reach`.

    Edges cost length * (1 + extra); nodes with extra >= WALL are closed. Returns the number of
    flat indices written to `path`, 0 if there is no such node.
    """
    height, width = base.shape
    cost = np.full(height * width, np.inf, np.float32)
    parent = np.full(height * width, -1, np.int64)
    capacity = height * width * 4 + 64
    keys = np.empty(capacity)
    nodes = np.empty(capacity, np.int64)
    cost[start] = 0.0
    size = heap_push(keys, nodes, 0, 0.0, start)
    while size > 0:
        key = keys[0]
        node = nodes[0]
        size = heap_pop(keys, nodes, size)
        if key > cost[node] + 1e-4:
            continue
        r = node // width
        c = node % width
        if places[r, c] > 0:
            return trace_back(parent, node, path)
        if key > reach:
            return 0
        for m in range(16):
            dr = MOVES[m, 0]
            dc = MOVES[m, 1]
            if not passable(base, r, c, dr, dc):
                continue
            i = r + dr
            j = c + dc
            if extra[i, j] >= WALL:
                continue
            other = i * width + j
            new = cost[node] + math.sqrt(dr * dr + dc * dc) * step * (1.0 + extra[i, j])
            if new < cost[other] - 1e-6 and size < capacity:
                cost[other] = new
                parent[other] = node
                size = heap_push(keys, nodes, size, new, other)
    return 0
