"""Stations: leases in the order of request, and the holding pattern until it is one's turn.

The order is (tick of the request, id), as in Lamport's mutual exclusion, known to all contenders
from their beacons: a request is made within radio range of the station, no centre is asked. The
lease orders the approach; safety does not depend on it. "Near" is measured along the way, not
through walls: a robot in the queue waits beyond the floor that the robots before it need. All goals
on connected single lanes share one queue, and as many robots as these have room for have a turn
(`lane_capacity`); a robot keeps its turn until it is out again. Where the lanes are so large that
those who wait may not hear each other, whoever was seen there and has asked takes room, too, and
ranks above those who wait. Elsewhere a dead end belongs to one robot, and a blind aisle to as many
as it has room for; the stations in one share its queue.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import FLAG_CIRCUIT
from swarm_common.model.records import FloatArray
from swarm_nav.core.config import HoldingConfig
from swarm_nav.core.goals import PlanError
from swarm_nav.core.priority import above
from swarm_nav.planning import search_kernels
from swarm_nav.planning.planner import path_length
from swarm_nav.planning.search import SearchSpace
from swarm_nav.planning.terrain import HALL_DISTANCE, Lattice, Terrain
from swarm_nav.traffic import gate_kernels, traffic_costs
from swarm_nav.traffic.blind_aisle_kernels import blind_floor
from swarm_nav.traffic.gate import WAY_POINTS
from swarm_nav.traffic.lane_capacity import capacity, extent, gaps_to, lane_labels
from swarm_nav.traffic.situation import Situation
from swarm_nav.traffic.traffic_costs import PARKING_GAP

SAME_STATION = 0.6  # [m] between targets that are one station
PARKING_DISTANCE = 1.1  # [m] of a parking place in a passage from any station; twice that in a
# hall, where the ways to the station are kept free
ARRIVED = 0.3  # [m] from a parking place within which the robot is there
CIRCUIT_LOOKAHEAD = 4.0  # [m] of circuit driven per plan
CIRCUIT_RENEW = 1.5  # [m] before the end of a plan at which the next is made
CIRCUIT_JOIN = 3.0  # [m] from the circuit up to which `auto` joins it
CIRCUIT_CORRIDOR = 0.8  # [m] on either side of the circuit that counts as on it
DETOUR = 2.5  # times the distance: what is farther by way is behind a wall
QUEUE_AREA = 2.0  # [m²] of floor that each robot before one in the queue needs
LEAST_AISLE = 1.5  # [m²] of floor that a blind aisle has; if it is deeper than the hold distance,
# a dead end: one robot has it to itself
ROBOT_AREA = 1.0  # [m²] of a blind aisle's floor for each robot in it, and before it for the next
# one to leave free: a robot coming out can pass
MOUTH_GAP = 0.6  # [m] before single lanes that belongs to them: a robot coming out can pass
WAITING_GAP = 0.3  # [m] before that, which robots without a turn keep free
QUEUE_STEP = 1.5  # [m] beyond its place in the queue from where a parked robot moves up


@functools.lru_cache(maxsize=16)  # each keeps its map in memory
def blind_aisle(
    terrain: Terrain, node: int, within: tuple[float, float], farthest: float, widest: float
) -> float:
    """Return the floor [m²] around a station that has one narrow mouth; results are kept.

    Args:
        terrain: Map for one size of robot.
        node: Flat index of the station.
        within: (least, most) [m²] of floor.
        farthest: Distance [m] of the mouth by the way, at most.
        widest: [m] of the mouth.

    Returns:
        The largest such floor, 0.0 if there is none.
    """
    lattice = terrain.lattice
    reach = math.ceil(farthest / lattice.step) + 1
    row, column = divmod(node, lattice.base.shape[1])
    first = max(0, row - reach), max(0, column - reach)
    box = slice(first[0], row + reach + 1), slice(first[1], column + reach + 1)
    is_floor = lattice.base[box] < search_kernels.WALL
    base = np.where(is_floor, np.float32(1.0), search_kernels.WALL)
    space = SearchSpace(base, np.zeros_like(base), lattice.heading[box].copy(), lattice.step)
    distances = space.cost_to_go((row - first[0]) * base.shape[1] + column - first[1])
    return float(blind_floor(distances, lattice.step, within, farthest, widest))


def lane_at(situation: Situation, place: tuple[float, float]) -> int:
    """Return the number of the connected single lanes that a place lies on, 0 for none.

    Args:
        situation: Of the robot.
        place: (x, y) [m] in map.
    """
    node = situation.planner.lattice.node_of(*place)
    labels = lane_labels(situation.terrain, situation.usual_radius)
    return 0 if node is None else int(labels.ravel()[node])


def is_large(situation: Situation, lane: int) -> bool:
    """Whether robots before two mouths of connected single lanes may not hear each other.

    Args:
        situation: Of the robot.
        lane: Number of the single lanes, 0 for none.
    """
    most = situation.config.traffic.radio_range - 2.0 * (MOUTH_GAP + WAITING_GAP)
    return lane > 0 and extent(situation.terrain, situation.usual_radius, lane) > most


class Approach:
    """The floor around a station: the way to it, and the single lanes that it lies on, if any.

    Attributes:
        lattice: Of the map.
        costs: (h, w) [m] of the planned way from each lattice cell to the station.
        lane: Number of the connected single lanes that the station lies on, 0 for none.
        room: Number of robots with goals there that they have room for; without single lanes that
            of the blind aisle that the station lies in, 0 without either.
        is_inside: Whether the robot is there, or before a mouth.
    """

    def __init__(self, situation: Situation, station: tuple[float, float]) -> None:
        """Look at the floor around a station; one without a way to it lies on no single lane.

        Args:
            situation: Of the robot.
            station: (x, y) [m] in map.
        """
        self.lattice = situation.planner.lattice
        try:
            self.costs = situation.planner.cost_to_go(station, math.nan)
            self._in_order = situation.planner.costs_in_order(station)
        except PlanError:
            self.costs = np.full(self.lattice.base.shape, np.inf, np.float32)
            self._in_order = np.zeros(0, np.float32)
        on = situation.terrain, situation.usual_radius
        self._labels = lane_labels(*on)
        self.lane = lane_at(situation, station)
        self.is_large = is_large(situation, self.lane)
        self._gaps = gaps_to(*on, self.lane) if self.lane else None
        cells = np.count_nonzero(self._labels == self.lane) if self.is_large else 0
        self._lane_area = cells * self.lattice.step**2
        aisle = 0.0 if self.lane else self._closed_floor(situation, station)
        self._depth = self.reach_of(aisle + ROBOT_AREA) if aisle else 0.0
        own = max(1, int(aisle / ROBOT_AREA)) if aisle else 0
        self.room = capacity(*on, self.lane) if self.lane else own
        self.is_inside = False
        others = [other for other in situation.stations if self._shares_queue(situation, other)]
        self._own_targets = np.array([station, *others])

    def _closed_floor(self, situation: Situation, station: tuple[float, float]) -> float:
        """Return the floor [m²] of a dead end, or of a blind aisle for few robots.

        Args:
            situation: Of the robot.
            station: (x, y) [m] in map.

        Returns:
            0 without either.
        """
        if self.reach_of(LEAST_AISLE) > situation.config.holding.hold_distance:
            return LEAST_AISLE
        node = self.lattice.node_of(*station)
        if node is None:
            return 0.0
        config = situation.config.holding
        within = LEAST_AISLE, config.approach_slots * ROBOT_AREA
        two_robots = 4.0 * situation.usual_radius  # side by side
        farthest = config.request_distance
        return blind_aisle(situation.terrain, node, within, farthest, two_robots)

    def _shares_queue(self, situation: Situation, place: tuple[float, float]) -> bool:
        if self.lane:
            return lane_at(situation, place) == self.lane
        node = self.lattice.node_of(*place)
        return node is not None and float(self.costs.ravel()[node]) <= self._depth

    def targets(self, situation: Situation) -> FloatArray:
        """Return the places (k, 2) [m] in map whose requests are served in one order.

        These are the station, and all to which robots drive on the same single lanes.

        Args:
            situation: Of the robot.
        """
        if not self.room:
            return self._own_targets
        told = situation.neighbors.heads["station"]
        there = told[np.isfinite(told[:, 0])].tolist()
        shared = [(x, y) for x, y in there if self._shares_queue(situation, (x, y))]
        return np.array([*self._own_targets, *shared]) if shared else self._own_targets

    def within(self, of_lane: float, of_station: float) -> NDArray[np.bool_]:
        """Return the lattice cells (h, w) near the single lanes; near the station without lanes.

        Where the lanes are large, those near the station count, too.

        Args:
            of_lane: [m] from the single lanes.
            of_station: [m] of the way to the station.
        """
        field, most = self._measure(of_lane, of_station)
        near = field <= most
        return near | (self.costs <= of_station) if self.is_large else near

    def _measure(self, of_lane: float, of_station: float) -> tuple[NDArray[np.float32], float]:
        """Return what says how near each lattice cell (h, w) [m] is, and up to where it counts."""
        if self._gaps is not None:
            return self._gaps, of_lane
        return self.costs, max(of_station, self._depth)

    @property
    def floor(self) -> NDArray[np.bool_]:
        """The lattice cells (h, w) where a robot keeps those out who want to go there."""
        return self.within(MOUTH_GAP, PARKING_DISTANCE)

    def is_full(self, situation: Situation) -> bool:
        """Whether others take all the room of large single lanes, as far as anybody saw.

        Args:
            situation: Of the robot.
        """
        if not self.is_large:
            return False
        # deep inside nobody sees a robot until it comes out; one that never does has died
        patience = situation.ticks(situation.config.holding.station_patience)
        frame, since = self.lattice.frame, situation.tick - patience
        known, own_id = situation.neighbors.sightings, situation.robot_id
        seen = gate_kernels.count_seen(self._labels, self.lane, frame, known, since, own_id, True)
        return int(seen) >= self.room

    def contains(self, situation: Situation) -> bool:
        """Whether the robot stops where it keeps those out who want to go there.

        Args:
            situation: Of the robot.
        """
        return self._is_on_floor(self.lattice.node_of(*situation.stop_point))

    def _is_on_floor(self, node: int | None) -> bool:
        """Whether a node is one of the `floor`, without looking at all of them."""
        if node is None:
            return False
        field, most = self._measure(MOUTH_GAP, PARKING_DISTANCE)
        return bool((field.ravel()[node : node + 1] <= most)[0])

    def gap(self, situation: Situation) -> float:
        """Return the distance [m] from where the robot stops to the shared floor; inf without any.

        Args:
            situation: Of the robot.
        """
        node = self.lattice.node_of(*situation.stop_point) if self.room else None
        if node is None:
            return math.inf
        if self._gaps is not None:
            return float(self._gaps.ravel()[node]) - MOUTH_GAP
        return float(self.costs.ravel()[node]) - self._depth

    def is_ahead(self, situation: Situation) -> bool:
        """Whether the way ahead leads onto the single lanes, or the robot is there.

        Args:
            situation: Of the robot.
        """
        if not self.lane:
            return False
        tube = situation.tube
        way = tube.points[tube.near : tube.near + WAY_POINTS]
        if self._is_on_floor(self.lattice.node_of(*situation.stop_point)):
            return True
        return bool(gate_kernels.entry(self.floor, self.lattice.frame, way) >= 0)

    def way(self, situation: Situation) -> float:
        """Return the distance from where the robot stops to the station.

        Args:
            situation: Of the robot.
        """
        node = self.lattice.node_of(*situation.stop_point)
        return math.inf if node is None else float(self.costs.ravel()[node])

    def forget_queue(self) -> None:
        """Free what only `reach_of` needs, once the robot does not queue here any more."""
        self._in_order = np.zeros(0, np.float32)

    def reach_of(self, area: float) -> float:
        """Return the distance within which there are `area` [m²] of floor, beyond large lanes.

        Args:
            area: [m²]
        """
        if not len(self._in_order):
            return 0.0
        area += self._lane_area
        cells = min(int(area / self.lattice.step**2), len(self._in_order) - 1)
        return float(self._in_order[cells])


@dataclass(slots=True)
class Cover:
    """Since when something has been on a station; another try of the goal does not wait anew.

    A station out of the LiDAR's reach counts as free, unless a silent robot is known to be on it.
    """

    station: tuple[float, float] = (math.inf, math.inf)  # (x, y) in map
    since: int = 0  # tick at which it last counted as free, or was first looked at
    seen: int = 0  # tick at which something was on it
    looked: int = 0  # tick at which it was looked at

    def update(self, situation: Situation, station: tuple[float, float], is_covered: bool) -> None:
        """Take what is known in this tick.

        Args:
            situation: Of the robot.
            station: (x, y) [m] in map.
            is_covered: Whether something is on it.
        """
        tick = situation.tick
        is_other = math.dist(station, self.station) > SAME_STATION
        if is_other or tick - self.looked > self._patience(situation):
            self.station, self.since, self.seen = station, tick, tick  # long ago, or elsewhere
        self.looked = tick
        if is_covered:
            self.seen = tick
        elif tick - self.seen > situation.retry_ticks:
            self.since = tick

    def lasts(self, situation: Situation) -> bool:
        """Whether the station has been covered for longer than `holding.station_patience`.

        Args:
            situation: Of the robot.
        """
        is_known = situation.tick == self.looked
        return is_known and self.seen - self.since > self._patience(situation)

    def _patience(self, situation: Situation) -> int:
        return situation.ticks(situation.config.holding.station_patience)


@dataclass(slots=True)
class Lease:
    """The station that the robot is on its way to."""

    station: tuple[float, float] | None = None  # (x, y) in map, None without a goal
    tick: int = 0  # tick of the request, 0 before it was made
    place: int = 0  # number of earlier requests known
    first: int = 0  # id of the robot that asked first, 0 if that is this one
    # priority of the highest robot that waits for this one to leave the station (priority
    # inheritance of a resource's holder: Sha, Rajkumar, Lehoczky 1990), 0 if none
    inherited: int = 0
    # whether the robot was there and keeps the lease until it is off the single lanes
    is_leaving: bool = False
    # whether others, who may be out of hearing, take all the room of its large single lanes
    is_full: bool = False
    # floor around the last station, as long as there is no new one
    left: Approach | None = None
    _next: tuple[float, float] | None = None
    # tick since which the robot leaves without another target, 0 before that is known
    _left_tick: int = 0
    _approach: Approach | None = None
    _is_through: bool = False  # whether it is on its large single lanes
    _lane_there: tuple[Lattice | None, int] = (None, 0)  # single lanes of the station, by the map
    _cover: Cover = field(default_factory=Cover)
    _alone: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))  # (1, 2) the station

    def aim(self, station: tuple[float, float] | None) -> None:
        """Take a new target; the old lease is given back, on single lanes once they are left.

        Args:
            station: (x, y) [m] in map; None for no station.
        """
        if station == self.station:
            self.is_leaving = False
        elif self.is_leaving or (self._approach is not None and self._approach.is_inside):
            self.is_leaving = True
            self._next, self._left_tick = station, 0
        else:
            self._take(station)

    def _take(self, station: tuple[float, float] | None) -> None:
        self.left = self._approach if station is None else None
        if self.left is not None:
            self.left.forget_queue()
        self.station = station
        self._alone = np.array([station] if station is not None else []).reshape(-1, 2)
        self.tick = 0
        self.place = self.first = 0
        self.inherited = 0
        self.is_leaving = False
        self._approach = None
        self.is_full = self._is_through = False
        self._lane_there = None, 0

    def update(self, situation: Situation) -> None:
        """Request within range of the station and work out the place in the queue.

        Args:
            situation: Of the robot.
        """
        if self.is_leaving:
            self._leave(situation)
        if self.station is None:
            return
        if self.tick == 0 and self._is_at_tail(situation):
            self.tick = situation.tick
        self.place, self.first = (0, 0)
        if self.tick:
            self.place, self.first, highest = self._requests(situation, self.tick)
            self._cover.update(situation, self.station, self._has_something_on_it(situation))
            approach = self._approach_of(situation)
            approach.is_inside = self._is_inside(situation)
            self._is_through = approach.is_large and self._is_inside(situation, -MOUTH_GAP)
            self.is_full = not self._is_through and approach.is_full(situation)
            if self.is_full:
                self.inherited = 0  # who waits for robots on the lanes ranks below these
            elif highest and (self._is_through or not self.place):
                # never less than before: a priority that comes and goes would delay all requests
                self.inherited = max(self.inherited, above(highest))

    def _leave(self, situation: Situation) -> None:
        """Give the station back once the robot is out, or has had no other target for a while."""
        self._left_tick = self._left_tick or situation.tick
        has_stayed = situation.tick - self._left_tick > situation.wait_ticks
        if (self._next is None and has_stayed) or not self._is_inside(situation):
            self._take(self._next)

    def _requests(self, situation: Situation, tick: int) -> tuple[int, int, int]:
        """Return how many asked before a tick, the first of them, and the highest who asked."""
        # before the robot is near, the floor around its station is not looked at
        near = self._approach
        targets = near.targets(situation) if near is not None else self._alone
        return situation.neighbors.queue(targets, tick, SAME_STATION)

    def _is_at_tail(self, situation: Situation) -> bool:
        """Whether the robot is near its station or its single lanes, or where the queue ends."""
        assert self.station is not None
        config = situation.config
        lane = self._lane(situation)
        is_far = situation.distance_to(*self.station) > config.traffic.radio_range
        may_ask = lane > 0 and (not is_far or is_large(situation, lane))
        if may_ask and self._approach_of(situation).is_ahead(situation):
            return True
        if is_far:
            return False
        if self._is_near(situation, config.holding.request_distance):
            return True
        place, _, _ = self._requests(situation, situation.tick)
        return place > 0 and self._way(situation) <= self._queue(situation, place + 1)

    def _lane(self, situation: Situation) -> int:
        """Return the number of the single lanes that the station lies on, 0 for none."""
        assert self.station is not None
        lattice = situation.planner.lattice
        if self._lane_there[0] is not lattice:
            self._lane_there = lattice, lane_at(situation, self.station)
        return self._lane_there[1]

    def _is_near(self, situation: Situation, distance: float) -> bool:
        """Whether the station is within `distance` [m], and not behind a wall."""
        assert self.station is not None
        if situation.distance_to(*self.station) > distance:
            return False
        return self._way(situation) <= DETOUR * distance

    def _is_inside(self, situation: Situation, slack: float = 0.0) -> bool:
        """Whether the robot is on the single lanes of its station or before them, or nearly so."""
        return self._approach_of(situation).gap(situation) <= slack

    def _way(self, situation: Situation) -> float:
        return self._approach_of(situation).way(situation)

    def _queue(self, situation: Situation, place: int) -> float:
        """Return the distance [m] that `place` robots of the queue need."""
        return self._approach_of(situation).reach_of(place * QUEUE_AREA)

    def _approach_of(self, situation: Situation) -> Approach:
        assert self.station is not None
        if self._approach is None or self._approach.lattice is not situation.planner.lattice:
            self._approach = Approach(situation, self.station)
        return self._approach

    def is_too_near(self, situation: Situation, slack: float = 0.0) -> bool:
        """Whether the robot is nearer to the station than its place in the queue allows.

        Args:
            situation: Of the robot.
            slack: Distance [m] by which it is to be beyond its place.
        """
        if self.station is None or self.tick == 0 or self.is_leaving:
            return False
        config = situation.config.holding
        if self._is_inside(situation, WAITING_GAP + slack):
            return True
        approach = self._approach_of(situation)
        if approach.is_large:
            may_approach = self.is_turn(config)
        else:
            may_approach = self.place < config.approach_slots or approach.lane > 0
        if may_approach:
            return False
        if self._is_near(situation, config.hold_distance + slack):
            return True
        return self._way(situation) <= self._queue(situation, self.place) + slack

    def kept_free(self, situation: Situation) -> NDArray[np.bool_] | None:
        """Return the lattice cells that those earlier in the queue need, None without any.

        Args:
            situation: Of the robot.
        """
        if self.station is None or self.tick == 0 or not (self.place or self.is_full):
            return None
        queue = self._queue(situation, self.place)
        return self._approach_of(situation).within(MOUTH_GAP + WAITING_GAP, queue)

    def is_turn(self, config: HoldingConfig) -> bool:
        """Whether the robot may drive the last metres, or onto the single lanes before them.

        Args:
            config: `holding.` parameters.
        """
        slots = config.approach_slots
        if self._approach is not None and self._approach.room:
            slots = min(slots, self._approach.room)
        has_turn = self.place < slots and not self.is_full
        return self.is_leaving or self._is_through or has_turn

    @property
    def is_shared(self) -> bool:
        """Whether the queue is one for all goals on the same single lanes."""
        return self._approach is not None and self._approach.room > 0

    def is_barred(self, situation: Situation) -> bool:
        """Whether something that does not move is on the station, and was waited for long enough.

        Args:
            situation: Of the robot.
        """
        return self.tick > 0 and not self.is_leaving and self._cover.lasts(situation)

    def _has_something_on_it(self, situation: Situation) -> bool:
        """Whether a silent robot is on the station, or anything that the LiDAR sees.

        A robot that was never heard, because it died before this one came, is only seen. Who walks
        to and fro there does not stand on it.
        """
        assert self.station is not None
        if self.is_covered(situation):
            return True
        points = situation.obstacle_points()
        if not len(points):
            return False
        if situation.distance_to(*self.station) > situation.config.costmap.obstacle_max_range:
            return False
        clearance = situation.obstacle_clearance
        limit = clearance - situation.config.goal_checker.xy_goal_tolerance
        if not self._is_within(points, limit):
            return False
        return not self._is_within(situation.obstacles.walked(situation.tick), clearance)

    def _is_within(self, points: FloatArray, limit: float) -> bool:
        assert self.station is not None
        return len(points) > 0 and float(np.hypot(*(points - self.station).T).min()) < limit

    def is_covered(self, situation: Situation) -> bool:
        """Whether a robot that will not move by itself is on the station, or may be.

        Args:
            situation: Of the robot.
        """
        return self.covering(situation) is not None

    def covering(self, situation: Situation) -> int | None:
        """Return the row of a neighbour that will not move by itself and may be on the station.

        Args:
            situation: Of the robot.
        """
        if self.station is None or self.tick == 0 or self.is_leaving:
            return None
        neighbors, near = situation.neighbors, situation.config.goal_checker.xy_goal_tolerance
        if not neighbors.has_immovable:
            return None
        for row in np.flatnonzero(neighbors.immovable):
            gaps = neighbors.tubes(int(row)) - self.station
            if float(np.hypot(*gaps.T).min()) < situation.reach(int(row)) - near:
                return int(row)
        return None


class HoldingPattern:
    """Where a robot waits: on a circuit or parked out of the lanes."""

    def __init__(
        self,
        circuits: dict[str, tuple[tuple[float, float], ...]],
        stations: list[tuple[float, float]],
    ) -> None:
        """Start outside of any pattern.

        Args:
            circuits: Closed polylines (x, y) [m] in map by name, in driving order, without the
                first point again at the end. Those of fewer than three points are left out.
            stations: (x, y) [m] in map, which parked robots keep free.
        """
        self._circuits = [_closed(points) for points in circuits.values() if len(points) >= 3]
        self._stations = stations
        self._next_search_tick = 0
        self.is_on_circuit = False
        self.target: tuple[float, float] | None = None

    def enter(self, situation: Situation) -> None:
        """Choose the pattern: `circuit`, `park`, or by the room on the circuit (`auto`).

        Args:
            situation: Of the robot.
        """
        mode = situation.config.holding.mode
        circuit = self._nearest_circuit(situation)
        if mode == "auto":
            self.is_on_circuit = circuit is not None and self._has_room(situation, circuit)
        else:
            self.is_on_circuit = mode == "circuit" and circuit is not None
        self._next_search_tick = situation.tick
        self.target = None
        situation.tube.cut()

    def leave(self) -> None:
        """Give up the pattern."""
        self.is_on_circuit = False
        self.target = None

    def update(self, situation: Situation, closed: NDArray[np.bool_] | None = None) -> None:
        """Keep going round, or look for a parking place, not in `closed`, until it is reached.

        Args:
            situation: Of the robot.
            closed: (h, w) lattice cells that are no parking places; None for none.
        """
        if self.is_on_circuit:
            self._drive_circuit(situation)
        elif situation.tick >= self._next_search_tick and self._needs_place(situation):
            self._next_search_tick = situation.tick + situation.wait_ticks
            path = parking_path(situation, self._stations, closed)
            if path is not None and len(path) >= 2:
                situation.tube.adopt(path)
                self.target = (float(path[-1, 0]), float(path[-1, 1]))

    def _needs_place(self, situation: Situation) -> bool:
        if self.target is None:
            return True
        if not situation.tube.is_complete:
            return situation.waited_ticks > situation.wait_ticks
        return situation.distance_to(*self.target) > ARRIVED

    def _nearest_circuit(self, situation: Situation) -> FloatArray | None:
        near = [c for c in self._circuits if _circuit_gap(c, situation)[0] < CIRCUIT_JOIN]
        if near or situation.config.holding.mode == "auto":
            return near[0] if near else None
        if not self._circuits:
            return None
        return min(self._circuits, key=lambda c: _circuit_gap(c, situation)[0])

    def _has_room(self, situation: Situation, circuit: FloatArray) -> bool:
        """Whether few enough robots are near the part of the circuit that the radio covers."""
        x, y = situation.pose.x, situation.pose.y
        reach = situation.config.traffic.radio_range
        heard = circuit[np.hypot(circuit[:, 0] - x, circuit[:, 1] - y) < reach]
        poses = situation.neighbors.heads["pose"]
        on_it = 0
        for pose in poses:
            gaps = np.hypot(circuit[:, 0] - pose[0], circuit[:, 1] - pose[1])
            on_it += bool(gaps.min() < CIRCUIT_CORRIDOR)
        room = len(heard) * _CIRCUIT_SPACING / situation.config.holding.circuit_spacing
        return on_it + 1 <= room

    def _drive_circuit(self, situation: Situation) -> None:
        circuit = self._nearest_circuit(situation)
        if circuit is None:
            self.is_on_circuit = False
            return
        is_late = situation.tick < self._next_search_tick
        if is_late or situation.tube.length_ahead() > CIRCUIT_RENEW:
            return
        self._next_search_tick = situation.tick + situation.ticks(1.0)
        _, nearest = _circuit_gap(circuit, situation)
        ahead = nearest + int(CIRCUIT_LOOKAHEAD / _CIRCUIT_SPACING)
        point = circuit[ahead % len(circuit)]
        target = (float(point[0]), float(point[1]))
        path = self._way_to(situation, target)
        if path is None:
            self.is_on_circuit = False  # park instead
            return
        situation.tube.adopt(path)
        self.target = None

    def _way_to(self, situation: Situation, point: tuple[float, float]) -> FloatArray | None:
        """Return the way to a point of the circuit, None if there is no short one."""
        extra = traffic_costs.congestion(situation)
        try:
            path = situation.planner.plan(situation.stop_point, point, extra)
        except PlanError:
            return None
        return path if path_length(path) <= 3.0 * CIRCUIT_LOOKAHEAD + CIRCUIT_JOIN else None

    @property
    def flags(self) -> int:
        """The beacon flag of a robot on the circuit."""
        return FLAG_CIRCUIT if self.is_on_circuit else 0


def parking_path(
    situation: Situation,
    stations: list[tuple[float, float]],
    closed: NDArray[np.bool_] | None = None,
    reach: float | None = None,
) -> FloatArray | None:
    """Return the way (n, 2) to the nearest free parking place, None if there is none in reach.

    Args:
        situation: Of the robot.
        stations: (x, y) [m] in map, to keep away from.
        closed: (h, w) lattice cells that are no places; None for none.
        reach: Cost [m] of the longest way; None for `holding.search_distance`.
    """
    lattice = situation.planner.lattice
    taken = situation.planner.no_extra()
    if stations:
        traffic_costs.stamp(taken, situation, np.array(stations), 2.0 * PARKING_DISTANCE, 1.0)
        taken[lattice.clearance <= HALL_DISTANCE] = 0.0
        traffic_costs.stamp(taken, situation, np.array(stations), PARKING_DISTANCE, 1.0)
    neighbors = situation.neighbors
    traffic_costs.stamp_tubes(taken, situation, PARKING_GAP, 1.0)
    targets = neighbors.heads["target"]
    for row in np.flatnonzero(np.isfinite(targets[:, 0])):
        traffic_costs.stamp(
            taken, situation, targets[row], situation.reach(int(row)) + PARKING_GAP, 1.0
        )
    if closed is not None:
        taken[closed] = 1.0
    places = situation.planner.free_places(taken, lattice.parking)
    extra = traffic_costs.congestion(situation)
    limit = situation.config.holding.search_distance if reach is None else reach
    return situation.planner.nearest(situation.stop_point, extra, places, limit)


_CIRCUIT_SPACING = 0.25  # [m] between the points of a closed circuit


def _closed(points: tuple[tuple[float, float], ...]) -> FloatArray:
    """Return the closed polyline with a point every `_CIRCUIT_SPACING`."""
    corners = np.array((*points, points[0]))
    pieces = []
    for a, b in itertools.pairwise(corners):
        count = max(1, round(math.hypot(*(b - a)) / _CIRCUIT_SPACING))
        pieces.append(a + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (b - a))
    return np.vstack(pieces)


def _circuit_gap(circuit: FloatArray, situation: Situation) -> tuple[float, int]:
    """Return (distance [m], index) of the nearest point of a circuit."""
    x, y = situation.stop_point
    gaps = np.hypot(circuit[:, 0] - x, circuit[:, 1] - y)
    nearest = int(gaps.argmin())
    return float(gaps[nearest]), nearest
