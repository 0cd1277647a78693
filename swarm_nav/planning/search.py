"""The lattice and the work arrays as the search kernels take them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_nav.planning import oblong_kernels
from swarm_nav.planning import search_kernels as kernels
from swarm_nav.planning.directed import Directions, direct_moves
from swarm_nav.planning.oblong import Slots

HEAP_SHARE = 4  # entries of the heap per node
MOST_LISTS = 4096  # of nodes of about the same cost; usually there are about 20


class SearchSpace:
    """One lattice to search, one search at a time: all robots of a process share the arrays."""

    def __init__(
        self,
        base: NDArray[np.float32],
        lane: NDArray[np.float32],
        heading: NDArray[np.float32],
        step: float,
        slots: Slots | None = None,
        directions: Directions | None = None,
    ) -> None:
        """Find the open moves and allocate; the arguments are those of `terrain.Lattice`.

        Args:
            base: (h, w) cost factor of a metre, `search_kernels.WALL` where the robot does not fit.
            lane: (h, w) extra cost factor of driving against `heading`.
            heading: (h, w, 2) unit vectors.
            step: [m] edge of a cell.
            slots: Places through which a long robot only drives straight. None for other robots.
            directions: Directed zones. None for none.
        """
        moves = np.empty(base.shape, np.uint32)
        if slots is None:
            kernels.open_moves(base, moves)
        else:
            kernels.open_moves(np.where(slots.room, base, kernels.WALL), moves)
            oblong_kernels.add_straight_moves(slots.axes, slots.room, moves)
        self._most_weight = float(np.max(base, initial=0.0, where=base < kernels.WALL))
        if directions is not None:
            moves = direct_moves(moves, directions)
            self._most_weight += kernels.DEAR
        self._shape = base.shape
        self._ground = kernels.Ground(base, lane, heading, moves, step)
        heap = HEAP_SHARE * base.size + 64
        self._work = kernels.Work(
            np.empty(base.size, np.float32),
            np.empty(base.size, np.int32),
            np.zeros(base.size, np.int32),
            np.empty(heap),
            np.empty(heap, np.int32),
            np.zeros(1, np.int32),
        )
        self._path = np.empty(base.size, np.int32)

    def cost_to_go(self, goal: int) -> NDArray[np.float32]:
        """Return the cost of driving from every node to a goal, without other robots.

        Returns:
            (h, w) [m]; inf where there is no way to the goal.
        """
        return self._costs_and_effort(goal)[0]

    def _costs_and_effort(self, goal: int) -> tuple[NDArray[np.float32], int]:
        ground = self._ground
        cost = np.empty(self._shape, np.float32)
        most = kernels.LENGTHS.max() * ground.step * (self._most_weight + float(ground.lane.max()))
        span = max(ground.step, most / MOST_LISTS)
        heads = np.empty(math.ceil(most / span) + 3, np.int32)
        taken = kernels.cost_to_go(ground, goal, span, self._work, heads, cost.ravel())
        return cost, taken

    def cheapest(
        self, start: int, goal: int, extra: NDArray[np.float32], heuristic: NDArray[np.float32]
    ) -> tuple[NDArray[np.int32], int]:
        """Return the nodes from start to goal, none without a way, and the number expanded.

        Args:
            extra: (h, w) cost per metre that other robots add; `WALL` closes a node.
            heuristic: (h, w) `cost_to_go` of the goal.
        """
        count, expansions = kernels.astar(
            self._ground, extra, start, goal, heuristic, self._work, self._path
        )
        return self._path[:count], expansions

    def nearest(
        self, start: int, extra: NDArray[np.float32], places: NDArray[np.uint8], reach: float
    ) -> NDArray[np.int32]:
        """Return the way to the cheapest node of a set.

        Args:
            extra: (h, w) cost per metre that other robots add; `WALL` closes a node.
            places: (h, w); above 0 on the nodes of the set.
            reach: Cost [m] beyond which the search ends.

        Returns:
            Flat indices from the start to the node; empty if there is none within reach.
        """
        count = kernels.nearest_place(
            self._ground, extra, places, start, reach, self._work, self._path
        )
        return self._path[:count]
