"""Admission control: limits the robots in a narrow region with stations (perimeter control).

Beyond a density the flow through a narrow region falls as more robots enter it (the fundamental
diagram of traffic; perimeter control: Daganzo 2007, Keyvan-Ekbatani et al. 2012). A robot in the
open whose path leads into such a region enters while fewer robots than the region has room for were
seen in it by anybody (`swarm_nav.perception.absence`), while few wait inside for a station, and
while few are on the last metres before it: those that are admitted, and those that ask from nearer
to where its way enters. So the mouth is fed by those who stand there, and never by a crowd.
Otherwise it waits in the open, wherever a place is free. Each robot decides alone.

The gate is subordinate to the priorities, with driving and waiting robots counted alike. A robot
that ranks so above all others that are inside, admitted or ask, enters after a while however many
they are, and so does the holder of a lease that inherits from such a robot. A robot that waits for
a lease does not ask, and a robot that is blocked on its way to the mouth takes no place.

Plain corridors are left alone: they have no station to wait for, and robots only pass.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, Mask
from swarm_common.model.robot_names import RobotNames
from swarm_nav.core.rank import SENIORITY
from swarm_nav.planning import search_kernels
from swarm_nav.planning.cells import distance_cells
from swarm_nav.planning.search import SearchSpace
from swarm_nav.planning.terrain import HALL_DISTANCE, Lattice, Terrain
from swarm_nav.traffic import gate_kernels
from swarm_nav.traffic.robot_state import RobotView
from swarm_nav.traffic.single_lane_kernels import label_at
from swarm_nav.traffic.single_lanes import connected_components, passing_areas, with_rim

NONE, ADMITTED = 0, 1  # values of a beacon's gate_tick that are not the tick of asking
LEAST_AREA = 16.0  # [m²] of a region; fewer robots than that has room for are led by the lease
MOST_AREA = 260.0  # [m²] of a region; a larger one has room for a swarm of 100
WAY_POINTS = 60  # path points, 3 m, in which the region's border is looked for
SEEN_TICKS = 150  # for which a robot counts as inside since it was seen there
MOST_COMING = 6  # robots on the last metres before a region
TURN_TICKS = 3000  # after which the highest robot waits no longer

label_of = label_at.py_func  # for one point cheaper than the call of a kernel


@functools.lru_cache(maxsize=4)
def narrow_region(
    terrain: Terrain, stations: tuple[tuple[float, float], ...], radius: float
) -> NDArray[np.int16] | None:
    """Return the parts of narrow regions with stations; the last few results are kept.

    A cell is narrow if it is farther than `HALL_DISTANCE` from all places with such clearance. In
    halls without open floor that is all of the hall, which never is full. There half the distance
    counts, for stations where two robots pass each other: in an aisle in which none can wait beside
    them. Only floor with a way to a station counts, not what lies outside of the outer walls.

    Args:
        stations: (x, y) [m] in map.
        radius: [m] safety radius.

    Returns:
        (h, w) number of the part that each lattice cell, or cell in a wall beside it, belongs to
        from 1, 0 outside; None if there is no such region, and on a map without an open place to
        wait in.
    """
    if not stations:
        return None
    lattice = terrain.lattice
    at_stations = [node for xy in stations if (node := lattice.node_of(*xy)) is not None]
    reach = _reachable(lattice, at_stations)
    narrow, aisles = (_narrow(lattice, reach, gap) for gap in (HALL_DISTANCE, HALL_DISTANCE / 2))
    for part in connected_components(narrow):
        if part.sum() * lattice.step**2 <= MOST_AREA:
            aisles &= ~part
    region = np.zeros(narrow.shape, np.int16)
    count = 0
    for floor, starts in ((aisles, aisles & passing_areas(terrain, radius)), (narrow, narrow)):
        for node in at_stations:
            if starts.flat[node] and not region.flat[node]:
                part = _component(lattice, floor, node)
                if part.sum() * lattice.step**2 >= LEAST_AREA and not region[part].any():
                    count += 1
                    region[part] = count
    return with_rim(region, lattice.base < search_kernels.WALL) if count else None


def _reachable(lattice: Lattice, nodes: list[int]) -> Mask:
    """Return the cells (h, w) with a way to one of the nodes."""
    is_open = lattice.base < search_kernels.WALL
    reach = np.zeros_like(is_open)
    for node in nodes:
        if not reach.flat[node]:
            reach |= _component(lattice, is_open, node)
    return reach


def _narrow(lattice: Lattice, reach: Mask, width: float) -> Mask:
    """Return the cells (h, w) of `reach` farther than `width` [m] from all with such clearance."""
    is_hall = reach & (lattice.clearance >= width)
    if not is_hall.any():
        return is_hall  # no open place to wait in
    is_far = distance_cells(is_hall) * lattice.step > width
    return np.asarray(reach & is_far, np.bool_)


def _component(lattice: Lattice, floor: Mask, node: int) -> Mask:
    """Return the cells (h, w) of the floor with a way to the node over it."""
    base = np.where(floor, np.float32(1.0), search_kernels.WALL)
    space = SearchSpace(base, np.zeros_like(lattice.lane), lattice.heading, lattice.step)
    return np.isfinite(space.cost_to_go(node))


@dataclass(slots=True)
class Gate:
    """One robot's admission to the narrow region ahead of it."""

    region: NDArray[np.int16] | None  # see `narrow_region`
    asked_tick: int = 0  # tick since which it waits or asks, 0 if it does not
    is_admitted: bool = False  # whether it may enter, or is inside
    first: int = 0  # id of the highest robot that it waits for, 0 for none
    _mouth: tuple[float, float] = (0.0, 0.0)  # [m] in map, where its way enters the region
    _part: int = 0  # of the region, in which its way leads
    _part_area: float = 0.0  # [m²]
    _measured: NDArray[np.int16] | None = None  # the region whose part that is
    # points of a path, from one index to before another, that lie outside a region
    _outside: tuple[FloatArray | None, NDArray[np.int16] | None, int, int] = (None, None, 0, 0)
    # a region, a depth [m], and the cells of `forecourt`
    _forecourt: tuple[NDArray[np.int16] | None, float, Mask | None] = (None, 0.0, None)

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

    def why(self, names: RobotNames) -> str:
        """Return for what a robot waits outside."""
        return f"for {names.name_of(self.first)}: the narrow region ahead is full"

    def leave(self) -> None:
        """Stop asking, as without a goal."""
        self.asked_tick = 0
        self.is_admitted = False

    def update(
        self,
        robot: RobotView,
        *,
        has_turn: bool,
        is_driving: bool,
        priority: Callable[[], int],
    ) -> None:
        """Ask, wait or be admitted.

        Args:
            has_turn: Whether the robot is on its way to a goal, and waits for no station's lease.
            is_driving: Whether the current path is the one to the goal: only that one counts.
            priority: Returns that of the robot while it drives, with what it inherits as holder of
                a lease; called only when the robot asks.
        """
        config = robot.config.holding
        if self.region is None or config.region_density <= 0.0:
            self.leave()
            return
        frame = robot.planner.lattice.frame
        if not has_turn or label_of(self.region, frame, robot.pose.x, robot.pose.y):
            self.leave()
            return
        if self.is_admitted:
            return
        if self.asked_tick == 0:
            if not is_driving or not self._leads_in(robot):
                return
            self.asked_tick = robot.tick
            self._look_at(robot)
        coming, waiting, is_highest = self._ahead(robot, priority())
        self.is_admitted = (is_highest and robot.tick - self.asked_tick >= TURN_TICKS) or (
            coming < MOST_COMING
            and waiting < config.approach_slots
            and self._seen_inside(robot) < max(1.0, config.region_density * self._part_area)
        )

    def _leads_in(self, robot: RobotView) -> bool:
        """Whether the way ahead leads into the region; each of its points is looked at once."""
        tube = robot.tube
        first, last = tube.near, min(tube.near + WAY_POINTS, len(tube.points))
        points, region, begin, end = self._outside
        if points is not tube.points or region is not self.region or not begin <= first <= end:
            begin = end = first
        if end < last:
            frame = robot.planner.lattice.frame
            if gate_kernels.entry(self.region, frame, tube.points[end:last]) >= 0:
                return True
            self._outside = tube.points, self.region, begin, last
        return False

    def _look_at(self, robot: RobotView) -> None:
        """Record where the way ahead enters the region, and how large that part of it is."""
        tube = robot.tube
        way = tube.points[tube.near : tube.near + WAY_POINTS]
        entry = gate_kernels.entry(self.region, robot.planner.lattice.frame, way)
        x, y = way[max(0, entry)].tolist()
        self._mouth = x, y
        self._choose_part(robot, x, y)

    def _choose_part(self, robot: RobotView, x: float, y: float) -> None:
        """Record in which part of the region a point lies, and how large that part is."""
        lattice = robot.planner.lattice
        part = int(label_at(self.region, lattice.frame, x, y))
        if part != self._part or self.region is not self._measured:
            self._part, self._measured = part, self.region
            cells = np.count_nonzero((self.region == part) & (lattice.base < search_kernels.WALL))
            self._part_area = float(cells) * lattice.step**2

    def _seen_inside(self, robot: RobotView) -> int:
        """Return how many others were seen in the part of the region not long ago."""
        frame, since = robot.planner.lattice.frame, robot.tick - SEEN_TICKS
        known, own_id = robot.neighbors.sightings, robot.robot_id
        seen = gate_kernels.count_seen(self.region, self._part, frame, known, since, own_id, False)
        return int(seen)

    def forecourt(self, lattice: Lattice, depth: float) -> Mask | None:
        """Return the lattice cells (h, w) of the region and before it, None without a region.

        Args:
            lattice: Lattice of the map to which the region belongs.
            depth: [m] from the region.
        """
        if self.region is None:
            return None
        region, known_depth, forecourt = self._forecourt
        if forecourt is None or region is not self.region or depth != known_depth:
            gaps = distance_cells(self.region > 0)
            forecourt = np.asarray(gaps * lattice.step <= depth, np.bool_)
            self._forecourt = self.region, depth, forecourt
        return forecourt

    def recheck(self, robot: RobotView, way: FloatArray) -> None:
        """Ask no more if the way to the goal does not lead through the region any longer.

        Args:
            way: (n, 2) [m] in map, from the robot to its goal.
        """
        frame = robot.planner.lattice.frame
        if self.region is not None and gate_kernels.entry(self.region, frame, way) < 0:
            self.leave()

    def _ahead(self, robot: RobotView, priority: int) -> tuple[int, int, bool]:
        """Count robots that enter before this one, and those that hold inside.

        Returns:
            Both numbers, and true if no robot inside, admitted or asking ranks higher.
        """
        neighbors = robot.neighbors
        coming, waiting, is_highest, self.first = gate_kernels.count_ahead(
            self.region,
            robot.planner.lattice.frame,
            neighbors.gate_columns,
            (neighbors.ids, neighbors.priorities, neighbors.gone),
            (priority & SENIORITY, robot.robot_id, robot.wait_ticks),
            (*self._mouth, robot.distance_to(*self._mouth)),
        )
        return int(coming), int(waiting), bool(is_highest)
