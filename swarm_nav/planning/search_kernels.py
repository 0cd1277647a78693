"""Bare numba kernels of graph search on the planning lattice: cost-to-go, A*, nearest place.

The lattice has 16 moves per node (8 neighbours and the knight's moves). A directed edge into a
node with unit direction u costs length * (base + lane * (1 - u.h) / 2 + extra), where h is the
direction with the nearer wall on the right and `extra` (>= 0) is what other robots add; and
length * DEAR more by a move that a directed zone has made dear.

The kernels share `Ground` and `Work`, made by `search.SearchSpace`.
Args of more than one kernel:
    base: (h, w) cost factors, `WALL` where no path may enter.
    goal: Flat index.
    start: Flat index.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Floats, Frame

MOVES = np.array(
    [
        (0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1),
        (1, 2), (2, 1), (-1, 2), (-2, 1), (1, -2), (2, -1), (-1, -2), (-2, -1),
    ],
    np.int64,
)  # fmt: skip  # (row, column)
LENGTHS = np.sqrt((MOVES**2).sum(axis=1).astype(np.float64))  # [cells] of each move
DEAR = 4.0  # more cost per metre of a dear move: as much as a keepout mask's 99
WALL = np.float32(1e9)  # value of `base` or `extra` that no path may enter
IN_NO_LIST = -2  # in place of the node before
Costs = NDArray[np.float32]


class Ground(NamedTuple):
    """Costs that do not change between searches; see `terrain.Lattice`."""

    base: NDArray[np.float32]  # (h, w) cost factor of a metre, WALL where there is no room
    lane: NDArray[np.float32]  # (h, w) extra factor of driving against `heading`
    heading: NDArray[np.float32]  # (h, w, 2) unit vectors
    # (h, w) bit m says that `MOVES[m]` leads somewhere, bit 16 + m that it is dear
    moves: NDArray[np.uint32]
    step: float  # [m] edge of a cell


class Work(NamedTuple):
    """Arrays of a search, which are never cleared.

    A node has been reached in the present search if its mark is the clock's value or, once it is
    closed, the next one.
    """

    cost: NDArray[np.float32]  # (h * w,) of the way from the start
    parent: NDArray[np.int32]  # (h * w,) node before, -1 for the start
    marks: NDArray[np.int32]  # (h * w,)
    keys: NDArray[np.float64]  # (capacity,) of the heap
    nodes: NDArray[np.int32]  # (capacity,) of the heap; in `cost_to_go` the links of its lists
    clock: NDArray[np.int32]  # (1,)


@njit(cache=True)
def heap_push(keys: Floats, nodes: NDArray[np.int32], size: int, key: float, node: int) -> int:
    """Add an entry to a binary heap on two arrays; the smallest key is at index 0.

    Args:
        keys: (capacity,) keys; not full.
        nodes: (capacity,) node of each key.
        size: Entries so far.
        key: Key of the new entry.
        node: Node of the new entry.

    Returns:
        The new size.
    """
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
def heap_pop(keys: Floats, nodes: NDArray[np.int32], size: int) -> int:
    """Remove the smallest entry of a heap; the caller has read it at index 0.

    Args:
        keys: See `heap_push`.
        nodes: See `heap_push`.
        size: Entries so far, at least 1.

    Returns:
        The new size.
    """
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
def passable(base: NDArray[np.float32], r: int, c: int, dr: int, dc: int) -> bool:
    """Whether a move stays on the lattice and clears all cells that it passes.

    Args:
        r: Row of the node where it begins.
        c: Column of the same.
        dr: Rows of the move, see `MOVES`.
        dc: Columns of the move.
    """
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
def open_moves(base: NDArray[np.float32], moves: NDArray[np.uint32]) -> None:
    """Find the moves that are possible from each node; none is dear.

    Args:
        moves: (h, w), written: bit m says that `MOVES[m]` leads somewhere.
    """
    for r in range(base.shape[0]):
        for c in range(base.shape[1]):
            bits = 0
            for m in range(16):
                if passable(base, r, c, MOVES[m, 0], MOVES[m, 1]):
                    bits |= 1 << m
            moves[r, c] = bits


@njit(cache=True)
def nearest_open(
    base: NDArray[np.float32], extra: NDArray[np.float32], frame: Frame, x: float, y: float
) -> int:
    """Return the flat index of the open node nearest to (x, y) within two cells, or -1.

    Nodes of (h, w) that `extra` closes count as ten cells further away.

    Args:
        extra: (h, w) what other robots add.
        x: [m] in map.
        y: [m] in map.
    """
    height, width = base.shape
    step = frame.step
    row = math.floor((y - frame.origin_y) / step)
    column = math.floor((x - frame.origin_x) / step)
    best = -1
    nearest = np.inf
    for i in range(max(0, row - 2), min(height, row + 3)):
        for j in range(max(0, column - 2), min(width, column + 3)):
            if base[i, j] >= WALL:
                continue
            dx = frame.origin_x + (j + 0.5) * step - x
            gap = math.hypot(dx, frame.origin_y + (i + 0.5) * step - y)
            if extra[i, j] >= WALL:
                gap += 10.0 * step
            if gap < nearest:
                best = i * width + j
                nearest = gap
    return best


@njit(cache=True)
def _weight(base: Costs, lane: Costs, heading: NDArray[np.float32], node: int, m: int) -> float:
    """Return the cost of a metre into a node by move `m`, without other robots (formula on top)."""
    if lane[node] == 0.0:  # on open floor there is nothing to divide
        return np.float64(base[node])
    along = (MOVES[m, 1] * heading[node, 0] + MOVES[m, 0] * heading[node, 1]) / LENGTHS[m]
    return base[node] + lane[node] * (1.0 - along) * 0.5


@njit(cache=True)
def cost_to_go(
    ground: Ground, goal: int, span: float, work: Work, heads: NDArray[np.int32], cost: Costs
) -> int:
    """Dijkstra backwards from a goal, on Dial's buckets: the cost of driving there from each node.

    Nodes wait in lists by the cost so far, `span` metres to a list. A node that becomes cheaper
    moves to another list, so each is there at most once. Costs are compared as they are stored:
    otherwise rounding alone makes a node cheaper than itself, again and again.

    Source: R. B. Dial, "Algorithm 360: Shortest-path forest with topological ordering", 1969.

    Args:
        span: [m] that a list covers; all of them together more than any move costs.
        heads: (lists,) first node of each list; overwritten.
        cost: (h * w,) receives the costs [m]; inf where the goal cannot be reached from.

    Returns:
        Number of times that a node was taken from a list: hardly more than once each.
    """
    height, width = ground.base.shape
    base, lane, moves = ground.base.ravel(), ground.lane.ravel(), ground.moves.ravel()
    heading = ground.heading.reshape((base.size, 2))
    after, before = work.nodes[: base.size], work.nodes[base.size : 2 * base.size]
    ways = MOVES[:, 0] * width + MOVES[:, 1]
    lists = len(heads)
    per_span = 1.0 / span
    cost[:] = np.inf
    heads[:] = -1
    cost[goal] = 0.0
    heads[0] = goal
    after[goal] = before[goal] = -1
    k = empty = taken = 0
    while empty < lists:
        node = heads[k]
        if node < 0:
            k = (k + 1) % lists
            empty += 1
            continue
        empty = 0
        heads[k] = after[node]
        if after[node] >= 0:
            before[after[node]] = -1
        before[node] = IN_NO_LIST
        taken += 1
        r = node // width
        c = node % width
        is_inside = 2 <= r < height - 2 and 2 <= c < width - 2
        for m in range(16):
            if not is_inside:
                i = r - MOVES[m, 0]
                j = c - MOVES[m, 1]
                if i < 0 or j < 0 or i >= height or j >= width:
                    continue
            other = node - ways[m]
            if not moves[other] >> m & 1 or base[other] >= WALL:
                continue
            length = LENGTHS[m] * ground.step
            weight = _weight(base, lane, heading, node, m)
            if moves[other] >> (16 + m) & 1:
                weight += DEAR
            new = np.float32(cost[node] + length * weight)
            old = cost[other]
            if new >= old:
                continue
            if old < np.inf and before[other] != IN_NO_LIST:
                _unlink(other, after, before, heads, np.int64(old * per_span) % lists)
            cost[other] = new
            to = np.int64(new * per_span) % lists
            after[other], before[other] = heads[to], -1
            if heads[to] >= 0:
                before[heads[to]] = other
            heads[to] = other
    return taken


@njit(cache=True)
def _unlink(
    node: int, after: NDArray[np.int32], before: NDArray[np.int32], heads: NDArray[np.int32], k: int
) -> None:
    """Remove a node from list `k`."""
    if before[node] >= 0:
        after[before[node]] = after[node]
    else:
        heads[k] = after[node]
    if after[node] >= 0:
        before[after[node]] = before[node]


@njit(cache=True)
def astar(
    ground: Ground,
    extra: NDArray[np.float32],
    start: int,
    goal: int,
    heuristic: NDArray[np.float32],
    work: Work,
    path: NDArray[np.int32],
) -> tuple[int, int]:
    """A* with an exact static heuristic.

    Args:
        extra: (h, w) cost per metre, >= 0, that other robots add; `WALL` closes a node.
        heuristic: (h, w) `cost_to_go` of the goal; admissible, since extra >= 0.
        path: (h * w,) receives flat indices from start to goal.

    Returns:
        (number of nodes written to `path`, 0 if there is no path; number of expansions).
    """
    cost, parent, marks = work.cost, work.parent, work.marks
    keys, nodes, clock = work.keys, work.nodes, work.clock
    step = ground.step
    width = ground.base.shape[1]
    ways = MOVES[:, 0] * width + MOVES[:, 1]  # flat: one index for all arrays, never negative
    base, lane, moves = ground.base.ravel(), ground.lane.ravel(), ground.moves.ravel()
    heading = ground.heading.reshape((base.size, 2))
    extra, heuristic = extra.ravel(), heuristic.ravel()
    clock[0] += 2
    seen = clock[0]
    capacity = keys.shape[0]
    cost[start] = 0.0
    parent[start] = -1
    marks[start] = seen
    size = heap_push(keys, nodes, 0, heuristic[start], start)
    expansions = 0
    while size > 0:
        node = nodes[0]
        size = heap_pop(keys, nodes, size)
        if marks[node] == seen + 1:
            continue
        marks[node] = seen + 1
        expansions += 1
        if node == goal:
            return trace_back(parent, goal, path), expansions
        for m in range(16):
            if not moves[node] >> m & 1:
                continue
            other = np.uint64(node + ways[m])
            mark = marks[other]
            if mark == seen + 1 or extra[other] >= WALL or heuristic[other] == np.inf:
                continue
            length = LENGTHS[m] * step
            weight = _weight(base, lane, heading, other, m)
            if moves[node] >> (16 + m) & 1:
                weight += DEAR
            new = np.float32(cost[node] + length * weight + length * extra[other])
            if (mark != seen or new < cost[other]) and size < capacity:
                cost[other] = new
                parent[other] = node
                marks[other] = seen
                size = heap_push(keys, nodes, size, new + heuristic[other], other)
    return 0, expansions


@njit(cache=True)
def trace_back(parent: NDArray[np.int32], goal: int, path: NDArray[np.int32]) -> int:
    """Write the chain of parents that ends at a node.

    Args:
        parent: (h * w,) flat index of each node's parent, -1 for the first.
        goal: Flat index of the last node.
        path: (h * w,) receives the chain, first node first.

    Returns:
        Its length.
    """
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
def nearest_place(
    ground: Ground,
    extra: NDArray[np.float32],
    places: NDArray[np.uint8],
    start: int,
    reach: float,
    work: Work,
    path: NDArray[np.int32],
) -> int:
    """Dijkstra from a node to the cheapest node of a set. Edges cost length * (1 + extra).

    Args:
        extra: (h, w) cost per metre, >= 0; `WALL` closes a node.
        places: (h, w); above 0 on the nodes of the set.
        reach: Cost [m] beyond which the search ends.
        path: (h * w,) receives flat indices from the start to the node found.

    Returns:
        The number of nodes written, 0 if there is no such node.
    """
    moves, step = ground.moves, ground.step
    cost, parent, marks = work.cost, work.parent, work.marks
    keys, nodes, clock = work.keys, work.nodes, work.clock
    width = ground.base.shape[1]
    clock[0] += 2
    seen = clock[0]
    capacity = keys.shape[0]
    cost[start] = 0.0
    parent[start] = -1
    marks[start] = seen
    size = heap_push(keys, nodes, 0, 0.0, start)
    while size > 0:
        key = keys[0]
        node = nodes[0]
        size = heap_pop(keys, nodes, size)
        if key > cost[node]:
            continue
        r = node // width
        c = node % width
        if places[r, c] > 0:
            return trace_back(parent, node, path)
        if key > reach:
            return 0
        for m in range(16):
            if not moves[r, c] >> m & 1:
                continue
            i = r + MOVES[m, 0]
            j = c + MOVES[m, 1]
            if extra[i, j] >= WALL:
                continue
            other = i * width + j
            new = np.float32(cost[node] + LENGTHS[m] * step * (1.0 + extra[i, j]))
            if (marks[other] != seen or new < cost[other]) and size < capacity:
                cost[other] = new
                parent[other] = node
                marks[other] = seen
                size = heap_push(keys, nodes, size, new, other)
    return 0
