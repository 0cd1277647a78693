"""The best joint plan on a small grid, by search over all joint places."""

import heapq
import itertools
from collections.abc import Sequence


def best_cost(
    neighbors: Sequence[Sequence[int]], start: Sequence[int], goals: Sequence[int]
) -> int | None:
    """Return the least sum of loss; None if there is no plan."""
    goal = tuple(goals)
    best = {tuple(start): 0}
    heap = [(0, tuple(start))]
    while heap:
        cost, places = heapq.heappop(heap)
        if cost > best[places]:
            continue
        if places == goal:
            return cost
        ways = [[place, *(w for w in neighbors[place] if w >= 0)] for place in places]
        for after in itertools.product(*ways):
            if len(set(after)) < len(after) or _swaps(places, after):
                continue
            loss = sum(not (a == b == g) for a, b, g in zip(places, after, goal, strict=True))
            if cost + loss < best.get(after, 10**9):
                best[after] = cost + loss
                heapq.heappush(heap, (cost + loss, after))
    return None


def _swaps(before: Sequence[int], after: Sequence[int]) -> bool:
    moves = set(zip(before, after, strict=True))
    return any(a != b and (b, a) in moves for a, b in moves)
