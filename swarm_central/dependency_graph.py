"""Action dependency graph: robots enter each vertex in the plan's order, whatever their delays.

Hönig, Kiesel, Tinka, Durham, Ayanian 2019. Waiting is no action, and of the robots that were at a
vertex before only the last counts: other edges follow from these (Dunkel 2024). A plan in which no
circle of robots moves at once has a graph without circles, so that some robot can always go on.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class PlannedMove:
    """One move of a robot."""

    target: int  # vertex
    after_robot: int  # that must have begun to leave the target; -1 for none
    after_count: int  # number of moves which that robot must have begun


class DependencyGraph:
    """The moves that are left of a plan."""

    def __init__(self, plan: NDArray[np.int32]) -> None:
        """Store the moves of a plan.

        Args:
            plan: (steps + 1, n) vertices of n robots.
        """
        count = plan.shape[1]
        self._actions: list[list[PlannedMove]] = [[] for _ in range(count)]
        self._begun = [0] * count
        last = {int(vertex): (robot, 1) for robot, vertex in enumerate(plan[0])}
        moves = [0] * count
        for before, after in pairwise(plan):
            movers = np.flatnonzero(before != after).tolist()
            for robot in movers:
                moves[robot] += 1
                other, number = last.get(int(after[robot]), (-1, 0))
                if other == robot:
                    other, number = -1, 0
                self._actions[robot].append(PlannedMove(int(after[robot]), other, number))
            for robot in movers:
                last[int(after[robot])] = (robot, moves[robot] + 1)

    def next_target(self, robot: int) -> int:
        """Return the vertex that a robot may move to now; -1 if it has to wait or is through."""
        begun = self._begun[robot]
        if begun >= len(self._actions[robot]):
            return -1
        action = self._actions[robot][begun]
        if action.after_robot >= 0 and self._begun[action.after_robot] < action.after_count:
            return -1
        return action.target

    def begin(self, robot: int) -> None:
        """Record that a robot begins its next move and leaves the vertex where it was."""
        self._begun[robot] += 1

    @property
    def is_done(self) -> bool:
        """Whether all moves have begun."""
        return all(
            begun == len(actions) for begun, actions in zip(self._begun, self._actions, strict=True)
        )
