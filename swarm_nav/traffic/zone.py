"""Zones: the floor that a robot on its way to a station needs, for how many, and in which order.

A zone is where a field of distances does not exceed its edge. On connected single lanes it is they
and all goals there, with room for as many robots as `lane_group` says. Elsewhere a dead end has
room for one robot, a blind aisle for a few, and the stations in one share its queue; else the zone
is the station. Requests are served in their order; `lease` is a robot's ticket for it.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_nav.core.goals import PlanError
from swarm_nav.planning import search_kernels
from swarm_nav.planning.search import SearchSpace
from swarm_nav.planning.terrain import Terrain
from swarm_nav.traffic import gate_kernels
from swarm_nav.traffic.gate import WAY_POINTS
from swarm_nav.traffic.lane_group import labels_with_rim, lane_group, lane_labels
from swarm_nav.traffic.robot_state import RobotView

PARKING_DISTANCE = 1.1  # [m] of a parking place in a passage from any station; twice that in a
# hall, where the ways to the station are kept free
LEAST_AISLE = 1.5  # [m²] of floor that a blind aisle has; if it is deeper than the hold distance,
# a dead end: one robot has it to itself
ROBOT_AREA = 1.0  # [m²] of a blind aisle's floor for each robot in it, and before it for the next
# one to leave free: a robot coming out can pass
MOUTH_GAP = 0.6  # [m] before single lanes that belongs to them: a robot coming out can pass
WAITING_GAP = 0.3  # [m] before that, which robots without a turn keep free


@functools.lru_cache(maxsize=16)  # each keeps its map in memory
def blind_aisle(
    terrain: Terrain, node: int, within: tuple[float, float], farthest: float, widest: float
) -> float:
    """Return the floor [m²] around a station that has one narrow mouth; results are kept.

    Args:
        within: (least, most) [m²] of floor.
        farthest: Distance [m] of the mouth by the way, at most.
        widest: [m] of the mouth.

    Returns:
        The largest such floor, 0.0 if there is none.
    """
    lattice = terrain.lattice
    beyond = math.sqrt(within[0])  # where a mouth leads on, so much can be seen
    reach = math.ceil((farthest + beyond) / lattice.step) + 1
    row, column = divmod(node, lattice.base.shape[1])
    first = max(0, row - reach), max(0, column - reach)
    box = slice(first[0], row + reach + 1), slice(first[1], column + reach + 1)
    is_floor = lattice.base[box] < search_kernels.WALL
    base = np.where(is_floor, np.float32(1.0), search_kernels.WALL)
    space = SearchSpace(base, np.zeros_like(base), lattice.heading[box].copy(), lattice.step)
    distances = space.cost_to_go((row - first[0]) * base.shape[1] + column - first[1])
    return float(gate_kernels.blind_floor(distances, lattice.step, within, farthest, widest))


def lane_at(robot: RobotView, place: tuple[float, float]) -> int:
    """Return the number of the connected single lanes that a place lies on, 0 for none.

    Args:
        place: (x, y) [m] in map.
    """
    node = robot.planner.lattice.node_of(*place)
    labels = lane_labels(*robot.passing)
    return 0 if node is None else int(labels.ravel()[node])


def is_large(robot: RobotView, lane: int) -> bool:
    """Whether robots before two mouths of connected single lanes may not hear each other.

    Args:
        lane: Number of the single lanes, 0 for none.
    """
    most = robot.config.traffic.radio_range - 2.0 * (MOUTH_GAP + WAITING_GAP)
    return lane > 0 and lane_group(*robot.passing, lane).extent > most


class Zone:
    """The floor around a station: its cells, its capacity, and the places with the same queue.

    Attributes:
        lattice: Lattice of the map.
        costs: (h, w) [m] of the planned way from each lattice cell to the station.
        lane: Number of the connected single lanes that the station lies on, 0 for none.
        is_large: Whether robots before two of their mouths may not hear each other.
        room: Number of robots with goals there that they have room for; without single lanes that
            of the blind aisle that the station lies in, 0 without either.
        is_inside: Whether the robot is there, or before a mouth.
    """

    def __init__(self, robot: RobotView, station: tuple[float, float]) -> None:
        """Derive the floor around a station; one without a way to it lies on no single lane.

        Args:
            station: (x, y) [m] in map.
        """
        self.lattice = robot.planner.lattice
        self._passing = on = robot.passing
        try:
            self.costs = robot.planner.cost_to_go(station, math.nan)
            self._in_order = robot.planner.costs_in_order(station)
        except PlanError:
            self.costs = np.full(self.lattice.base.shape, np.inf, np.float32)
            self._in_order = np.zeros(0, np.float32)
        self._labels = labels_with_rim(*on)
        self.lane = lane_at(robot, station)
        self.is_large = is_large(robot, self.lane)
        self._ways = self.costs  # along which the queue is measured
        if self.lane:
            group = lane_group(*on, self.lane)
            self._field, self._edge, self.room = group.gaps, MOUTH_GAP, group.capacity
            if self.is_large:
                self._ways, self._in_order = group.ways
        else:
            aisle = self._closed_floor(robot, station)
            self._field, self._edge, self.room = self.costs, 0.0, 0
            if aisle:
                self._edge = self.reach_of(aisle + ROBOT_AREA)
                self.room = max(1, int(aisle / ROBOT_AREA))
        self.is_inside = False
        self._floor: NDArray[np.bool_] | None = None
        self._sharing: dict[tuple[float, float], bool] = {}  # by place
        others = [other for other in robot.stations if self._shares_queue(robot, other)]
        self._own_targets = self._targets = np.array([station, *others])
        self._told = b""  # stations of the neighbours, of which `_targets` are

    def is_of(self, robot: RobotView) -> bool:
        """Whether map and sizes of robots are still those that were looked at."""
        return self._passing == robot.passing

    def _closed_floor(self, robot: RobotView, station: tuple[float, float]) -> float:
        """Return the floor [m²] of a dead end, or of a blind aisle for few robots.

        Args:
            station: (x, y) [m] in map.

        Returns:
            0 without either.
        """
        if self.reach_of(LEAST_AISLE) > robot.config.holding.hold_distance:
            return LEAST_AISLE
        node = self.lattice.node_of(*station)
        if node is None:
            return 0.0
        config = robot.config.holding
        within = LEAST_AISLE, config.approach_slots * ROBOT_AREA
        two_robots = 4.0 * robot.passing[1]  # side by side
        farthest = config.request_distance
        return blind_aisle(robot.terrain, node, within, farthest, two_robots)

    def _shares_queue(self, robot: RobotView, place: tuple[float, float]) -> bool:
        """Whether a place has one queue with the station; each place is looked up once."""
        known = self._sharing.get(place)
        if known is None:
            if self.lane:
                known = lane_at(robot, place) == self.lane
            else:
                node = self.lattice.node_of(*place)
                known = node is not None and float(self.costs.ravel()[node]) <= self._edge
            self._sharing[place] = known
        return known

    def targets(self, robot: RobotView) -> FloatArray:
        """Return the places (k, 2) [m] in map whose requests are served in one order.

        These are the station, and all to which robots drive on the same single lanes.
        """
        if not self.room:
            return self._own_targets
        told = robot.neighbors.heads["station"]
        raw = told.tobytes()
        if raw != self._told:  # seldom: robots keep to a station for long
            self._told = raw
            there = {(x, y) for x, y in told.tolist() if math.isfinite(x) and math.isfinite(y)}
            shared = sorted(place for place in there if self._shares_queue(robot, place))
            self._targets = np.array([*self._own_targets, *shared])
        return self._targets

    def kept_free(self, queue: float) -> NDArray[np.bool_]:
        """Return the lattice cells (h, w) where nobody parks who has no turn.

        Args:
            queue: [m] that those who are before it need.
        """
        near = self._field <= (self._edge + WAITING_GAP if self.lane else max(queue, self._edge))
        return near | (self._ways <= queue) if self.is_large else near

    @property
    def _rim(self) -> float:
        """Return up to where [m] the floor counts from which others are kept out."""
        return self._edge if self.lane else max(PARKING_DISTANCE, self._edge)

    @property
    def floor(self) -> NDArray[np.bool_]:
        """The lattice cells (h, w) where a robot keeps those out who want to go there."""
        if self._floor is None:
            self._floor = self._field <= self._rim
        return self._floor

    def is_full(self, robot: RobotView) -> bool:
        """Whether others take all the room of large single lanes, as far as anybody saw."""
        if not self.is_large:
            return False
        # deep inside nobody sees a robot until it comes out; one that never does has died
        patience = robot.ticks(robot.config.holding.station_patience)
        frame, since = self.lattice.frame, robot.tick - patience
        known, own_id = robot.neighbors.sightings, robot.robot_id
        seen = gate_kernels.count_seen(self._labels, self.lane, frame, known, since, own_id, True)
        return int(seen) >= self.room

    def contains(self, robot: RobotView) -> bool:
        """Whether the robot stops where it keeps those out who want to go there."""
        return self._is_on_floor(self.lattice.node_of(*robot.stop_point))

    def _is_on_floor(self, node: int | None) -> bool:
        """Whether a node is one of the `floor`, without looking at all of them."""
        return node is not None and bool((self._field.ravel()[node : node + 1] <= self._rim)[0])

    def gap(self, robot: RobotView) -> float:
        """Return the distance [m] from the stop point to the shared floor; inf without any."""
        node = self.lattice.node_of(*robot.stop_point) if self.room else None
        return math.inf if node is None else float(self._field.ravel()[node]) - self._edge

    def is_ahead(self, robot: RobotView) -> bool:
        """Whether the way ahead leads onto the single lanes, or the robot is there."""
        if not self.lane:
            return False
        tube = robot.tube
        way = tube.points[tube.near : tube.near + WAY_POINTS]
        if self._is_on_floor(self.lattice.node_of(*robot.stop_point)):
            return True
        return bool(gate_kernels.entry(self.floor, self.lattice.frame, way) >= 0)

    def way(self, robot: RobotView) -> float:
        """Return the distance from where the robot stops to the station."""
        node = self.lattice.node_of(*robot.stop_point)
        return math.inf if node is None else float(self.costs.ravel()[node])

    def way_to_queue(self, robot: RobotView) -> float:
        """Return the distance [m] from where the robot stops to large single lanes; else `way`."""
        node = self.lattice.node_of(*robot.stop_point)
        return math.inf if node is None else float(self._ways.ravel()[node])

    def forget_queue(self) -> None:
        """Free what only `reach_of` needs, once the robot does not queue here any more."""
        self._in_order = np.zeros(0, np.float32)

    def reach_of(self, area: float) -> float:
        """Return the `way_to_queue` [m] within which there are `area` [m²] of floor.

        Before large single lanes that is before each mouth, if all have the same floor.

        Args:
            area: [m²]
        """
        if not len(self._in_order):
            return 0.0
        cells = min(int(area / self.lattice.step**2), len(self._in_order) - 1)
        return float(self._in_order[cells])
