"""Entry control: how many robots may be in a narrow region that has stations (perimeter control).

Beyond a density the flow through a narrow region falls as more robots enter it (the fundamental
diagram of traffic; perimeter control: Daganzo 2007, Keyvan-Ekbatani et al. 2012). A robot in the
open whose way leads into such a region counts those that it hears inside, those admitted and those
that have waited for longer; it enters while that is less than the region's share within radio
range allows, and otherwise waits in the open. Each robot decides alone. A queue that has not
advanced for a while lets one more in, then another, so that the gate only delays: safety and
liveness do not rest on it.

Plain corridors are left alone: they have no station to wait for, and robots only pass.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.records import CONTROL_PERIOD, FloatArray
from swarm_nav import distance_kernels, gate_kernels, search_kernels
from swarm_nav.search import SearchSpace
from swarm_nav.situation import Situation
from swarm_nav.terrain import HALL_DISTANCE, Lattice, Terrain

NONE, ADMITTED = 0, 1  # values of a beacon's gate_tick that are not the tick of asking
WAY_POINTS = 60  # path points, 3 m, in which the region's border is looked for

is_inside = gate_kernels.is_inside.py_func  # for one point cheaper than the call of a kernel


@functools.lru_cache(maxsize=4)
def narrow_region(
    terrain: Terrain, stations: tuple[tuple[float, float], ...]
) -> NDArray[np.bool_] | None:
    """Return the lattice cells of narrow regions with stations; None if there are none.

    Narrow is what lies farther than `HALL_DISTANCE` from any place with that much clearance.
    """
    lattice = terrain.lattice
    is_hall = lattice.clearance >= HALL_DISTANCE
    if not stations or not is_hall.any():
        return None  # no open place to wait in
    from_hall = distance_kernels.distance_cells(is_hall) * lattice.step
    is_free = lattice.base < search_kernels.WALL
    narrow = is_free & (from_hall > HALL_DISTANCE)
    region = np.zeros_like(narrow)
    for x, y in stations:
        node = lattice.node_of(x, y)
        if node is None:
            continue
        row, column = divmod(node, narrow.shape[1])
        if narrow[row, column] and not region[row, column]:
            region |= _component(lattice, narrow, row, column)
    return region if region.any() else None


def _component(
    lattice: Lattice, narrow: NDArray[np.bool_], row: int, column: int
) -> NDArray[np.bool_]:
    base = np.where(narrow, np.float32(1.0), search_kernels.WALL)
    space = SearchSpace(base, np.zeros_like(lattice.lane), lattice.heading, lattice.step)
    cost = space.cost_to_go(row * narrow.shape[1] + column)
    return np.isfinite(cost)


@dataclass(slots=True)
class Gate:
    """One robot's admission to the narrow region ahead of it.

    Attributes:
        asked_tick: Tick since which it waits or asks, 0 if it does not.
        is_admitted: Whether it may enter, or is inside.
    """

    region: NDArray[np.bool_] | None
    asked_tick: int = 0
    is_admitted: bool = False
    _advanced_tick: int = 0
    _fewest_ahead: int = 0
    _cells: int = 0  # of the region in a disc (x, y, radius): robots that wait stand
    _counted_disc: tuple[float, float, float] | None = None
    _counted_region: NDArray[np.bool_] | None = None
    # points of a path, from one index to before another, that lie outside a region
    _outside: tuple[FloatArray | None, NDArray[np.bool_] | None, int, int] = (None, None, 0, 0)

    @property
    def announced(self) -> int:
        """The beacon's gate_tick: none, admitted, or the tick of asking."""
        if self.asked_tick == 0:
            return NONE
        return ADMITTED if self.is_admitted else self.asked_tick

    @property
    def is_closed(self) -> bool:
        """Whether the robot has to wait outside."""
        return self.asked_tick > 0 and not self.is_admitted

    def leave(self) -> None:
        """Ask no more, as without a goal."""
        self.asked_tick = 0
        self.is_admitted = False

    def update(self, situation: Situation, has_goal: bool, is_driving: bool) -> None:
        """Ask, wait or be admitted.

        Args:
            situation: Of the robot.
            has_goal: Whether the robot is on its way to a goal.
            is_driving: Whether the path in hand is the one to the goal: only that one counts.
        """
        config = situation.config.holding
        if self.region is None or config.gate_density <= 0.0:
            return
        frame = situation.planner.lattice.frame
        if not has_goal or is_inside(self.region, frame, situation.pose.x, situation.pose.y):
            self.leave()
            return
        if self.is_admitted:
            return
        if self.asked_tick == 0:
            if not is_driving:
                return
            if not self._leads_in(situation):
                return
            self.asked_tick = self._advanced_tick = situation.tick
            self._fewest_ahead = 1 << 30
        ahead = self._ahead(situation)
        if ahead < self._fewest_ahead:
            self._fewest_ahead, self._advanced_tick = ahead, situation.tick
        self.is_admitted = ahead < self._capacity(situation)

    def _leads_in(self, situation: Situation) -> bool:
        """Whether the way ahead leads into the region; each of its points is looked at once."""
        tube = situation.tube
        first, last = tube.near, min(tube.near + WAY_POINTS, len(tube.points))
        points, region, begin, end = self._outside
        if points is not tube.points or region is not self.region or not begin <= first <= end:
            begin = end = first
        if end < last:
            frame = situation.planner.lattice.frame
            if gate_kernels.enters(self.region, frame, tube.points[end:last]):
                return True
            self._outside = tube.points, self.region, begin, last
        return False

    def recheck(self, situation: Situation, way: FloatArray) -> None:
        """Ask no more if the way (n, 2) to the goal does not lead through the region any longer."""
        frame = situation.planner.lattice.frame
        if self.region is not None and not gate_kernels.enters(self.region, frame, way):
            self.leave()

    def _ahead(self, situation: Situation) -> int:
        """Count who is inside, admitted, or has waited for longer."""
        hood = situation.hood
        return int(
            gate_kernels.count_ahead(
                self.region,
                situation.planner.lattice.frame,
                *hood.gate_columns,
                hood.ids,
                (self.asked_tick, situation.robot_id),
            )
        )

    def _capacity(self, situation: Situation) -> float:
        """Return how many robots the part of the region within radio range has room for."""
        assert self.region is not None
        config = situation.config
        lattice = situation.planner.lattice
        disc = (situation.pose.x, situation.pose.y, config.traffic.radio_range)
        if self._counted_disc != disc or self._counted_region is not self.region:
            self._cells = int(
                gate_kernels.cells_within(self.region, lattice.frame, disc[:2], disc[2])
            )
            self._counted_disc, self._counted_region = disc, self.region
        waited = (situation.tick - self._advanced_tick) * CONTROL_PERIOD
        share = config.holding.gate_density * self._cells * lattice.step**2
        return max(1.0, share) + math.floor(waited / config.holding.gate_patience)
