"""Leases of stations, in the order of request.

The order is (tick of the request, id), as in Lamport's mutual exclusion, known to all contenders
from their beacons: a request is made within radio range of the station, no centre is asked. The
lease orders the approach; safety does not depend on it. "Near" is measured along the way, not
through walls: a robot in the queue waits beyond the floor that the robots before it need. A robot
on single lanes keeps its turn until it is out again (`zone` says who shares a queue), and one
that gets its goal there has a turn, too, if the goal lies elsewhere: it can only go out. Where the
lanes are so large that those who wait may not hear each other, whoever was seen there and has asked
takes room, too, and ranks above those who wait. The highest robot that waits passes its rank on to
the one that has the station (priority inheritance of a resource's holder: Sha, Rajkumar, Lehoczky
1990).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.sites import Sites
from swarm_nav.core.config import HoldingConfig
from swarm_nav.core.rank import OUT_OF_LANES, inherited_by_holder
from swarm_nav.planning.terrain import Terrain
from swarm_nav.traffic.robot_state import RobotView
from swarm_nav.traffic.zone import MOUTH_GAP, WAITING_GAP, Zone, is_large, lane_at

SAME_STATION = 0.6  # [m] between targets that are one station
DETOUR = 2.5  # times the distance: what is farther by way is behind a wall
QUEUE_AREA = 2.0  # [m²] of floor that each robot before one in the queue needs
QUEUE_STEP = 1.5  # [m] beyond its place in the queue from where a parked robot moves up


@dataclass(slots=True)
class Cover:
    """Time since when something has been on a station; another try of the goal does not wait anew.

    A station out of the LiDAR's reach counts as free, unless a silent robot is known to be on it.
    """

    station: tuple[float, float] = (math.inf, math.inf)  # (x, y) in map
    since: int = 0  # tick at which it last counted as free, or was first looked at
    seen: int = 0  # tick at which something was on it
    looked: int = 0  # tick at which it was looked at

    def update(self, robot: RobotView, station: tuple[float, float], is_covered: bool) -> None:
        """Update the station with what is known in this tick.

        Args:
            station: (x, y) [m] in map.
            is_covered: Whether something is on it.
        """
        tick = robot.tick
        is_other = math.dist(station, self.station) > SAME_STATION
        if is_other or tick - self.looked > self._patience(robot):
            self.station, self.since, self.seen = station, tick, tick  # long ago, or elsewhere
        self.looked = tick
        if is_covered:
            self.seen = tick
        elif tick - self.seen > robot.retry_ticks:
            self.since = tick

    def lasts(self, robot: RobotView) -> bool:
        """Whether the station has been covered for longer than `holding.station_patience`."""
        is_known = robot.tick == self.looked
        return is_known and self.seen - self.since > self._patience(robot)

    def _patience(self, robot: RobotView) -> int:
        return robot.ticks(robot.config.holding.station_patience)


@dataclass(slots=True)
class Lease:
    """The station that the robot is on its way to."""

    station: tuple[float, float] | None = None  # (x, y) in map, None without a goal
    tick: int = 0  # tick of the request, 0 before it was made
    place: int = 0  # number of earlier requests known
    first: int = 0  # id of the robot that asked first, 0 if that is this one
    # whether the robot was there and keeps the lease until it is off the single lanes
    is_leaving: bool = False
    # whether others, who may be out of hearing, take all the room of its large single lanes
    is_full: bool = False
    # whether the robot is served at the station, which it keeps until the next goal begins
    is_served: bool = False
    # floor around the last station, as long as there is no new one
    left: Zone | None = None
    _next: tuple[float, float] | None = None
    _given_back: tuple[tuple[float, float], int] = ((math.inf, math.inf), 0)  # station, its tick
    # tick since which the robot leaves without another target, 0 before that is known
    _left_tick: int = 0
    _zone: Zone | None = None
    _is_new: bool = False  # whether where the robot gets its goal is still to be looked at
    _is_through: bool = False  # whether it is on its large single lanes
    # single lanes of the station, by `RobotView.passing`
    _lane_there: tuple[tuple[Terrain, float] | None, int] = (None, 0)
    _cover: Cover = field(default_factory=Cover)
    _alone: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))  # (1, 2) the station

    def aim(self, robot: RobotView, station: tuple[float, float] | None) -> None:
        """Set a new target; the old lease is given back, on single lanes once they are left.

        Args:
            station: (x, y) [m] in map; None for no station.
        """
        self.is_served = False
        if station == self.station:
            self.is_leaving = False
        elif self.is_leaving or (self._zone is not None and self._zone.is_inside):
            self.is_leaving = True
            self._next, self._left_tick = station, 0
        else:
            self._take(robot, station)

    def keep(self, robot: RobotView) -> None:
        """Keep the station that was given back last until the next `aim`: the robot is served."""
        self.is_served = True
        station, tick = self._given_back
        if self.station is None and robot.distance_to(*station) <= SAME_STATION:
            self._take(robot, station)
            self.tick, self._is_new = tick, False

    def _take(self, robot: RobotView, station: tuple[float, float] | None) -> None:
        if self.station is not None:
            self._given_back = self.station, self.tick
        self.left = self._zone if station is None else None
        if self.left is not None:
            self.left.forget_queue()
        self.station = station
        self._alone = np.array([station] if station is not None else []).reshape(-1, 2)
        self.tick = 0
        self.place = self.first = 0
        robot.donations.station = 0
        self.is_leaving = False
        self._zone = None
        self.is_full = self._is_through = False
        self._is_new = True
        self._left_tick = 0
        self._lane_there = None, 0

    def update(self, robot: RobotView) -> None:
        """Request within range of the station and work out the place in the queue."""
        if self.is_leaving:
            self._leave(robot)
        if self.station is None:
            return
        if self._is_new:
            self._is_new = False
            self._hold_lanes_here(robot)
        if self.tick == 0 and self._is_at_tail(robot):
            self.tick = robot.tick
        self.place, self.first = (0, 0)
        if self.tick:
            self.place, self.first, highest = self._requests(robot, self.tick)
            self._cover.update(robot, self.station, self._has_something_on_it(robot))
            zone = self._zone_of(robot)
            zone.is_inside = self._is_inside(robot)
            self._is_through = zone.is_large and self._is_inside(robot, -MOUTH_GAP)
            self.is_full = not self._is_through and zone.is_full(robot)
            if not self.is_turn(robot.config.holding):
                robot.donations.station = 0  # who waits ranks below those that it waits for
            elif highest and (self.is_leaving or self._is_through or not self.place):
                if self.is_leaving:  # others inherit from it, too
                    highest = max(highest, robot.own_priority)
                # never less while it has its turn: a change would delay all requests
                hops = OUT_OF_LANES if self.is_leaving else 0
                robot.donations.station = max(
                    robot.donations.station, inherited_by_holder(highest, hops)
                )

    def _hold_lanes_here(self, robot: RobotView) -> None:
        """Hold the single lanes where the robot gets its goal, if that lies elsewhere."""
        here = robot.stop_point
        lane, target = lane_at(robot, here), self.station
        if lane and lane != self._lane(robot):
            self._take(robot, here)
            self.tick, self.is_leaving, self._next = robot.tick, True, target
            self._is_new = False

    def _leave(self, robot: RobotView) -> None:
        """Give the station back once the robot is out, or has had no other target for a while.

        Large single lanes are given back once it is out only: nobody may hear it there.
        """
        self._left_tick = self._left_tick or robot.tick
        has_stayed = robot.tick - self._left_tick > robot.wait_ticks
        is_done = self._next is None and has_stayed and not self.is_served
        zone = self._zone_of(robot)
        if (is_done and not zone.is_large) or not self._is_inside(robot):
            self._take(robot, self._next)
        elif is_done:
            self.left = zone

    def _requests(self, robot: RobotView, tick: int) -> tuple[int, int, int]:
        """Return how many asked before a tick, the first of them, and the highest who asked."""
        # before the robot is near, the floor around its station is not looked at
        near = self._zone
        targets = near.targets(robot) if near is not None else self._alone
        return robot.neighbors.queue(targets, tick, SAME_STATION)

    def _is_at_tail(self, robot: RobotView) -> bool:
        """Whether the robot is near its station or its single lanes, or where the queue ends."""
        assert self.station is not None
        config = robot.config
        lane = self._lane(robot)
        is_far = robot.distance_to(*self.station) > config.traffic.radio_range
        if is_far and not is_large(robot, lane):
            return False
        if lane and self._zone_of(robot).is_ahead(robot):
            return True
        if self._is_near(robot, config.holding.request_distance):
            return True
        place, _, _ = self._requests(robot, robot.tick)
        return place > 0 and self._is_in_queue(robot, place + 1)

    def _lane(self, robot: RobotView) -> int:
        """Return the number of the single lanes that the station lies on, 0 for none."""
        assert self.station is not None
        passing = robot.passing
        if self._lane_there[0] != passing:
            self._lane_there = passing, lane_at(robot, self.station)
        return self._lane_there[1]

    def _is_near(self, robot: RobotView, distance: float) -> bool:
        """Report whether the station is within `distance` [m], and not behind a wall."""
        assert self.station is not None
        if robot.distance_to(*self.station) > distance:
            return False
        return self._zone_of(robot).way(robot) <= DETOUR * distance

    def _is_inside(self, robot: RobotView, slack: float = 0.0) -> bool:
        """Whether the robot is on the single lanes of its station or before them, or nearly so."""
        return self._zone_of(robot).gap(robot) <= slack

    def _is_in_queue(self, robot: RobotView, place: int, slack: float = 0.0) -> bool:
        """Whether the robot is on the floor that `place` robots need, or within `slack` [m]."""
        return self._zone_of(robot).way_to_queue(robot) <= self._queue(robot, place) + slack

    def _queue(self, robot: RobotView, place: int) -> float:
        """Return the distance [m] that `place` robots need, and those on large single lanes."""
        zone = self._zone_of(robot)
        robots = place + zone.room if zone.is_large else place
        return zone.reach_of(robots * QUEUE_AREA)

    def _zone_of(self, robot: RobotView) -> Zone:
        assert self.station is not None
        if self._zone is None or not self._zone.is_of(robot):
            self._zone = Zone(robot, self.station)
        return self._zone

    def is_too_near(self, robot: RobotView, slack: float = 0.0) -> bool:
        """Whether the robot is nearer to the station than its place in the queue allows.

        Args:
            slack: Distance [m] by which it is to be beyond its place.
        """
        if self.station is None or self.tick == 0 or self.is_leaving:
            return False
        config = robot.config.holding
        if self._is_inside(robot, WAITING_GAP + slack):
            return True
        zone = self._zone_of(robot)
        is_among_first = self.place < config.approach_slots
        may_approach = self.is_turn(config) if zone.is_large else is_among_first
        if may_approach:
            return False
        if self._is_near(robot, config.hold_distance + slack):
            return True
        return self._is_in_queue(robot, self.place, slack)

    def kept_free(self, robot: RobotView) -> NDArray[np.bool_] | None:
        """Return the lattice cells that those earlier in the queue need, None without any."""
        if self.station is None or self.tick == 0 or not (self.place or self.is_full):
            return None
        queue = self._queue(robot, self.place)
        return self._zone_of(robot).kept_free(queue)

    def is_turn(self, config: HoldingConfig) -> bool:
        """Whether the robot may drive the last metres, or onto the single lanes before them.

        Args:
            config: `holding.` parameters.
        """
        slots = config.approach_slots
        if self._zone is not None and self._zone.room:
            slots = min(slots, self._zone.room)
        has_turn = self.place < slots and not self.is_full
        return self.is_leaving or self._is_through or has_turn

    def name_in(self, sites: Sites) -> str:
        """Return the name of the station, empty for a target without one."""
        if self.station is None:
            return ""
        for name, pose in sites.stations.items():
            if math.dist((pose.x, pose.y), self.station) < SAME_STATION:
                return name
        return ""

    @property
    def is_shared(self) -> bool:
        """Whether the queue is one for all goals on the same single lanes."""
        return self._zone is not None and self._zone.room > 0

    def why(self, names: RobotNames, sites: Sites) -> str:
        """Return for what a robot without a turn waits."""
        station = self.name_in(sites) or "its goal"
        if self.first:
            queue = f"{station} or others in its aisle" if self.is_shared else station
            return f"for {names.name_of(self.first)}, {self.place} before it at {queue}"
        if self.is_full:
            return f"for room on the single lanes at {station}"
        return f"until {station} is free"

    def is_barred(self, robot: RobotView) -> bool:
        """Whether something immovable has been on the station for long enough."""
        return self.tick > 0 and not self.is_leaving and self._cover.lasts(robot)

    def _has_something_on_it(self, robot: RobotView) -> bool:
        """Whether a silent robot is on the station, or anything that the LiDAR sees.

        A robot that was never heard, because it died before this one came, is only seen. Who walks
        to and fro there does not stand on it.
        """
        assert self.station is not None
        if self.covering(robot) is not None:
            return True
        points = robot.obstacle_points()
        if not len(points):
            return False
        if robot.distance_to(*self.station) > robot.config.costmap.obstacle_max_range:
            return False
        clearance = robot.obstacle_clearance
        limit = clearance - robot.config.goal_checker.xy_goal_tolerance
        if not self._is_within(points, limit):
            return False
        return not self._is_within(robot.obstacles.walked(robot.tick), clearance)

    def _is_within(self, points: FloatArray, limit: float) -> bool:
        assert self.station is not None
        return len(points) > 0 and float(np.hypot(*(points - self.station).T).min()) < limit

    def covering(self, robot: RobotView) -> int | None:
        """Return the row of a neighbour that will not move by itself and may be on the station."""
        if self.station is None or self.tick == 0 or self.is_leaving:
            return None
        neighbors, near = robot.neighbors, robot.config.goal_checker.xy_goal_tolerance
        if not neighbors.has_immovable:
            return None
        for row in np.flatnonzero(neighbors.immovable):
            gaps = neighbors.tubes(int(row)) - self.station
            if float(np.hypot(*gaps.T).min()) < robot.reach(int(row)) - near:
                return int(row)
        return None
