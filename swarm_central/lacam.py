"""LaCAM*: a whole plan for all robots by a lazy search over their joint places.

Okumura 2023 (AAAI, IJCAI). Each node makes its successors one at a time: PIBT decides for all
robots but those that the node's next constraint binds. All constraints together are all moves
there are, so the search finds a plan if there is one, and with time enough a best one.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swarm_central.pibt_kernels import JointStep, Wishes, step
from swarm_central.roadmap import NO_WAY, Costs, Roadmap
from swarm_common.model.records import FloatArray

Bound = tuple[tuple[int, int], ...]  # robots and the vertices that they must take


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Result of the search."""

    steps: NDArray[np.int32]  # (k + 1, n) vertices of all robots, step by step
    cost: int  # moves and waits of all robots that are not at their goals to stay ("sum of loss")
    is_best: bool  # whether the search ended since there is nothing better
    expansions: int  # joint places that were made


@dataclass(eq=False, slots=True)
class _Node:
    places: NDArray[np.int32]
    headings: NDArray[np.int32]
    order: NDArray[np.int64]  # robots, the first first
    waited: NDArray[np.int64]  # steps since each robot was at its goal
    rest: int  # least cost from here
    parent: _Node | None = None
    cost: int = 0
    followers: dict[int, _Node] = field(default_factory=dict)  # by identity
    bounds: deque[Bound] = field(default_factory=lambda: deque([()]))


class Lacam:
    """The search on one roadmap from one start."""

    def __init__(
        self,
        roadmap: Roadmap,
        start: NDArray[np.int32],
        goals: NDArray[np.int32],
        *,
        headings: NDArray[np.int32] | None = None,
        locked: NDArray[np.bool_] | None = None,
        closed: NDArray[np.bool_] | None = None,
        may_rotate: bool = True,
        seed: int = 0,
    ) -> None:
        """Prepare a search.

        Args:
            roadmap: Its costs say which moves robots prefer.
            start: (n,) vertices, all different.
            goals: (n,) vertices, all different.
            headings: (n,) directions; None where turns cost nothing.
            locked: (n,) robots that stay where they are; None for none.
            closed: (V,) vertices that nobody may enter; None for none.
            may_rotate: Whether a circle of robots may move on at once.
            seed: Seed of the choice among equals.
        """
        count, vertices = len(start), len(roadmap.points)
        self._goals = goals
        self._may_rotate = may_rotate
        self._costs = roadmap.costs
        self._locked = np.zeros(count, np.bool_) if locked is None else locked
        self._closed = np.zeros(vertices, np.bool_) if closed is None else closed
        self._random = np.random.default_rng(seed)
        targets = [np.array([goal]) for goal in goals]
        self._fields = np.stack([roadmap.costs_to(goal, self._closed) for goal in targets])
        hops = _unit(roadmap)
        self._hops = np.stack([hops.costs_to(goal, self._closed)[:, 0] for goal in targets])
        self._now, self._then = np.empty(vertices, np.int32), np.empty(vertices, np.int32)
        first = headings if headings is not None else np.zeros(count, np.int32)
        waited = np.zeros(count, np.int64)
        self._root = _Node(start, first, self._order(start, waited), waited, self._rest(start))
        self._nodes = {start.tobytes(): self._root}
        self._goal: _Node | None = None
        self.expansions = 0

    def solve(self, most: int, *, anytime: bool = False) -> Plan | None:
        """Search on.

        Args:
            anytime: Whether to go on after the first plan, up to the best.

        Returns:
            The best plan so far; None without one.
        """
        if (self._hops[np.arange(len(self._goals)), self._root.places] >= NO_WAY).any():
            return None
        stack = [self._root]
        while stack and self.expansions < most:
            node = stack[-1]
            if self._goal is not None and node.cost + node.rest >= self._goal.cost:
                stack.pop()
                continue
            if self._goal is None and (node.places == self._goals).all():
                self._goal = node
                if not anytime:
                    break
                continue
            if not node.bounds:
                stack.pop()
                continue
            following = self._successor(node, node.bounds.popleft())
            if following is None:
                continue
            known = self._nodes.get(following.places.tobytes())
            if known is None:
                self._nodes[following.places.tobytes()] = following
                node.followers[id(following)] = following
                stack.append(following)
                continue
            node.followers[id(known)] = known
            self._shorten(node, stack)
            if self._goal is None or known.cost + known.rest < self._goal.cost:
                stack.append(known)
        return None if self._goal is None else self._plan(is_best=not stack)

    def _successor(self, node: _Node, bound: Bound) -> _Node | None:
        """Return the node that PIBT makes within a constraint, and grow the constraint tree."""
        self.expansions += 1
        if len(bound) < len(self._goals):
            robot = int(node.order[len(bound)])
            here = int(node.places[robot])
            ways = [
                v for v in self._costs.neighbors[here].tolist() if v >= 0 and not self._closed[v]
            ]
            ways.append(here)
            self._random.shuffle(ways)
            node.bounds.extend((*bound, (robot, way)) for way in ways)
        following = np.where(self._locked, node.places, -1).astype(np.int32)
        for robot, way in bound:
            if self._locked[robot] and way != node.places[robot]:
                return None
            following[robot] = way
        count = len(self._goals)
        noise = self._random.random((count, 5), np.float32) * np.float32(0.01)
        moves = JointStep(node.places, node.headings, following, self._now, self._then)
        wishes = Wishes(self._fields, np.arange(count, dtype=np.int32), self._closed, noise)
        if not step(node.order, moves, self._costs, wishes, self._may_rotate):
            return None
        neighbors = self._costs.neighbors[node.places]
        arrived = (neighbors == following[:, None]) & (neighbors >= 0)
        headings = np.where(arrived.any(axis=1), arrived.argmax(axis=1), node.headings)
        waited = np.where(following == self._goals, 0, node.waited + 1)
        return _Node(
            following,
            headings.astype(np.int32),
            self._order(following, waited),
            waited,
            self._rest(following),
            node,
            node.cost + self._loss(node.places, following),
        )

    def _order(self, places: NDArray[np.int32], waited: NDArray[np.int64]) -> NDArray[np.int64]:
        rest = self._hops[np.arange(len(places)), places]
        return np.lexsort((-rest, -waited)).astype(np.int64)

    def _rest(self, places: NDArray[np.int32]) -> int:
        return int(self._hops[np.arange(len(places)), places].sum())

    def _loss(self, before: NDArray[np.int32], after: NDArray[np.int32]) -> int:
        return int(((before != self._goals) | (after != self._goals)).sum())

    def _shorten(self, node: _Node, stack: list[_Node]) -> None:
        """Pass a shorter way on to all that follow."""
        todo = deque([node])
        while todo:
            first = todo.popleft()
            for other in first.followers.values():
                cost = first.cost + self._loss(first.places, other.places)
                if cost < other.cost:
                    other.cost, other.parent = cost, first
                    todo.append(other)
                    if self._goal is not None and cost + other.rest < self._goal.cost:
                        stack.append(other)

    def _plan(self, *, is_best: bool) -> Plan:
        node: _Node | None = self._goal
        assert node is not None
        cost, steps = node.cost, []
        while node is not None:
            steps.append(node.places)
            node = node.parent
        return Plan(
            steps=np.stack(steps[::-1]), cost=cost, is_best=is_best, expansions=self.expansions
        )


def _unit(roadmap: Roadmap) -> Roadmap:
    """Return the roadmap with 1 s per move and turns for nothing."""
    neighbors = roadmap.costs.neighbors
    edges = np.where(neighbors >= 0, np.float32(1.0), NO_WAY).astype(np.float32)
    costs = Costs(neighbors, edges, np.zeros((4, 4), np.float32), np.float32(1.0))
    return Roadmap(roadmap.points, roadmap.cells, costs, roadmap.parking, roadmap.spacing)


def lower_bound(roadmap: Roadmap, start: NDArray[np.int32], goals: NDArray[np.int32]) -> FloatArray:
    """Return the fewest moves (n,) of each robot, as if it were alone."""
    unit, none = _unit(roadmap), np.zeros(len(roadmap.points), np.bool_)
    return np.array(
        [unit.costs_to(np.array([g]), none)[s, 0] for s, g in zip(start, goals, strict=True)]
    )
