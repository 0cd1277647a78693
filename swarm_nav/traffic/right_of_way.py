"""Liveness layer: which robot has right of way, makes way, or steps back.

Priorities are static between goals (class, then the longest time without reaching a goal, then
id) and compared as published one tick ago, including the own one, so that no two robots both
believe that they win. A robot that blocks a higher one inherits the pusher's priority minus one and
drives to a refuge (priority inheritance, PIBT: Okumura et al. 2022); a pusher whose blocker has no
refuge steps back (PIBT's backtracking).
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import MODE_YIELD
from swarm_common.model.records import FloatArray, Mask
from swarm_nav.core.rank import passed_on
from swarm_nav.core.states import MakingWay, Push, next_state
from swarm_nav.interfaces import Proposal
from swarm_nav.planning import path_cost_kernels
from swarm_nav.planning.planner import SPACING
from swarm_nav.reservation.tube_kernels import INTENT_SPACING, PRIORITY_LENGTH
from swarm_nav.traffic import traffic_costs
from swarm_nav.traffic.arbiter import DROP_PATH, planned
from swarm_nav.traffic.gate import label_of
from swarm_nav.traffic.robot_state import RobotView
from swarm_nav.traffic.single_lane_kernels import FORESIGHT
from swarm_nav.traffic.single_lanes import passing_areas

REFUGE_MARGIN = 0.03  # [m] between refuge and pusher's path beyond the reach; grows
# by as much after each refuge that did not free the pusher
RETREAT_DISTANCE = 0.95  # [m] of the first retreat from a robot
Try = tuple[float, bool]  # margin [m] to other robots beyond the reach, whether the way is smooth
TIGHTER: tuple[Try, ...] = ((0.0, False), (-0.04, False))
SLACK = 2  # points by which the way may lead towards the pusher
INTENT_POINTS = round(FORESIGHT / INTENT_SPACING)  # of the pusher's path that is kept free
WAY_AHEAD = round(FORESIGHT / SPACING)  # points of the own path that may lead out of its way
GAIN = round(PRIORITY_LENGTH / INTENT_SPACING)  # points of its way to get ahead instead


class RightOfWay:
    """Making way for one robot at a time, and stepping back; the state is by `MAKING_WAY`."""

    def __init__(self) -> None:
        self.state = MakingWay.FREE
        self._last_pushed_tick = 0
        self._next_search_tick = 0
        self._retreat_until = -1
        self._retreats, self._retreated_from = 0, 0  # one after another from a robot, and its id
        self._blocked_since = -1
        self._is_at_refuge = False  # by the last search
        self._margin = REFUGE_MARGIN
        self._kept_free: tuple[FloatArray, float] = np.zeros((0, 2)), 0.0  # pusher's way and reach

    @property
    def is_yielding(self) -> bool:
        """Whether the robot leaves its own way to make way or to step back."""
        return self.state is not MakingWay.FREE

    @property
    def is_retreating(self) -> bool:
        """Whether the robot steps back on its own account."""
        return self.state is MakingWay.RETREATING

    @property
    def is_stuck(self) -> bool:
        """Whether there is no refuge, or none that the robot gets to."""
        return self.state in (MakingWay.STUCK, MakingWay.BARRED)

    @property
    def _is_diverted(self) -> bool:
        return self.is_yielding and not self.is_retreating

    def _switch(self, event: Push) -> None:
        self.state = next_state(self.state, event)

    def pusher(self, robot: RobotView) -> int | None:
        """Return the row of the highest robot that this one blocks and that ranks above it."""
        traffic = robot.config.traffic
        # a robot that drives on its own path is not disturbed at once
        if robot.twist.vx > traffic_costs.MOVING_SPEED and not self.is_yielding:
            patience = robot.wait_ticks
        else:
            patience = traffic.push_ticks + robot.radio.extra
        return robot.neighbors.highest_pusher(robot.own_priority, patience)

    def propose(self, robot: RobotView) -> Proposal | None:
        """React to pushers: make way, step back, or go on; `is_yielding` tells which."""
        if robot.has_grown and self._is_diverted:
            self._switch(Push.GETS_ON)
        proposal = None
        row = self.pusher(robot)
        if row is not None:
            proposal = self._make_way(robot, row)
        elif robot.donations.push:
            proposal = self._await_release(robot)
        if not self.is_yielding:
            proposal = self._consider_retreat(robot) or proposal
        if self.is_retreating and self._retreat_until <= robot.tick:
            self._switch(Push.OVER)
            proposal = DROP_PATH
        return proposal

    def stay(self, robot: RobotView) -> Proposal | None:
        """Make way for nobody, as long as the robot is served where it stands."""
        proposal = None
        if self.is_retreating:
            self._switch(Push.OVER)
            proposal = DROP_PATH
        if robot.donations.push or self._is_diverted:
            return self._release(robot) or proposal
        return proposal

    def _await_release(self, robot: RobotView) -> Proposal | None:
        """Be free after a while; on a single lane look for a refuge while the pusher is away.

        Else a robot without a goal would stay in a blind end for ever: its pusher steps back, so
        that it is not pushed any more, and comes again.
        """
        patience = robot.retry_ticks
        if self._is_diverted and self._still_comes(robot):
            self._last_pushed_tick = robot.tick
        was_stuck = self._is_diverted and self.state is not MakingWay.LEAVING
        if was_stuck and not is_in_room(robot, robot.stop_point):
            patience += robot.stuck_ticks
        if robot.tick - self._last_pushed_tick > patience:
            return self._release(robot)
        if self.is_stuck and robot.tick >= self._next_search_tick:
            return self._search(robot)
        return None

    def _still_comes(self, robot: RobotView) -> bool:
        """Whether the pusher's way leads here, unblocked, and that to the refuge is free: drive on.

        Going back to the own way in between would only be in its way again.
        """
        neighbors = robot.neighbors
        row = neighbors.row(robot.donations.yields_for)
        if row is None or robot.tube.is_complete or robot.waited_ticks:
            return False
        if neighbors.immovable[row] or neighbors.priorities[row] <= robot.donations.push:
            return False
        if neighbors.heads["blocked_ticks"][row]:
            return False
        gaps = np.hypot(*(way_of(robot, row) - robot.stop_point).T)
        return bool(gaps.min() < robot.reach(row))

    def _release(self, robot: RobotView) -> Proposal | None:
        robot.donations.push = 0
        robot.donations.yields_for = 0
        self._blocked_since = -1
        was_diverted = self._is_diverted
        self._switch(Push.RELEASED)
        return DROP_PATH if was_diverted else None

    def _make_way(self, robot: RobotView, row: int) -> Proposal | None:
        neighbors = robot.neighbors
        pusher_id = int(neighbors.ids[row])
        is_new = pusher_id != robot.donations.yields_for
        self._last_pushed_tick = robot.tick
        robot.donations.push = passed_on(int(neighbors.priorities[row]))
        self._kept_free = way_of(robot, row), robot.reach(row)
        if not self._is_diverted and self._goes_on(robot, row):
            self._switch(Push.CLEARS)
            return None
        if is_new:
            self._switch(Push.PUSHED)
            robot.counters.pushes += 1
            robot.donations.yields_for = pusher_id
            self._is_at_refuge = False
            self._margin = REFUGE_MARGIN
            self._blocked_since = -1
            return self._search(robot)
        if robot.blocked_ticks == 0:
            self._blocked_since = -1
        elif self._blocked_since < 0:
            self._blocked_since = robot.tick
        waited = robot.tick - self._blocked_since if self._blocked_since >= 0 else 0
        if max(waited, robot.obstacle_ticks) > robot.stuck_ticks:
            self._switch(Push.WAITED)
        is_over = robot.tube.is_complete or self.is_stuck
        if robot.tick < self._next_search_tick or not is_over:
            return None
        if self._is_at_refuge:  # and in the way there, as the pusher says
            self._margin += REFUGE_MARGIN
        return self._search(robot)

    def _goes_on(self, robot: RobotView, row: int) -> bool:
        """Whether the robot gets out of the pusher's way by going its own, with its priority."""
        if robot.blocked_ticks:
            if robot.blocked_ticks > robot.wait_ticks:
                return False
            blocker = robot.neighbors.row(robot.blocked_by)
            if blocker is None or robot.neighbors.priorities[blocker] >= robot.donations.push:
                return False
        return clears_way(robot, row)

    def _search(self, robot: RobotView) -> Proposal | None:
        """Propose the way to the nearest refuge, or say that there is none."""
        self._next_search_tick = robot.tick + robot.retry_ticks
        way, reach = self._kept_free
        smooth = self.state not in (MakingWay.BARRED, MakingWay.TIGHTLY)
        gap, rank = reach + self._margin, robot.donations.push
        found = planned(robot, lambda start: refuge_path(robot, start, way, gap, rank, smooth))
        path = found.path if found is not None else None
        self._is_at_refuge = path is not None and len(path) < 2
        if path is None:
            self._margin = REFUGE_MARGIN
            self._switch(Push.NO_REFUGE)
        elif self._is_at_refuge:
            self._switch(Push.GETS_ON)
        else:
            self._blocked_since = -1
        return found

    def _consider_retreat(self, robot: RobotView) -> Proposal | None:
        """Step back from a robot that said that it cannot make way; if again, farther and longer.

        Before that one can make way, those behind this robot may have to step back in turn.
        """
        if robot.blocked_ticks < robot.wait_ticks:
            return None
        row = robot.neighbors.row(robot.blocked_by)
        if row is None or not robot.neighbors.stuck[row] or robot.neighbors.immovable[row]:
            return None
        is_again = robot.blocked_by == self._retreated_from
        times = self._retreats + 1 if is_again else 1
        found = planned(robot, lambda start: retreat_path(robot, start, times * RETREAT_DISTANCE))
        if is_again and (found is None or found.path is None):
            found = planned(robot, lambda start: retreat_path(robot, start, RETREAT_DISTANCE))
        if found is None or found.path is None:
            return found
        self._retreats, self._retreated_from = times, robot.blocked_by
        robot.counters.retreats += 1
        self._switch(Push.REFUSED)
        self._retreat_until = robot.tick + times * robot.stuck_ticks
        return found


def clears_way(robot: RobotView, row: int) -> bool:
    """Whether the robot's own path leads out of the way of a neighbour, or ahead of it."""
    tube = robot.tube
    path = tube.points[tube.near : tube.near + WAY_AHEAD]
    if len(path) < 3 or robot.obstacle_ticks:
        return False
    beacon = robot.neighbors.beacons[row]
    way = np.vstack(
        (
            beacon["held"][: beacon["held_size"]][::2],
            beacon["intent"][: min(int(beacon["intent_size"]), INTENT_POINTS)],
        )
    )
    reach = robot.reach(row) + REFUGE_MARGIN
    return bool(path_cost_kernels.clears(path, way, reach, SLACK, GAIN))


def is_in_room(robot: RobotView, place: tuple[float, float]) -> bool:
    """Whether a place (x, y) [m] in map is where two robots pass each other."""
    floor = passing_areas(*robot.passing)
    return bool(label_of(floor, robot.planner.lattice.frame, *place))


def way_of(robot: RobotView, row: int) -> FloatArray:
    """Return the way (n, 2) [m] in map that a pusher needs: held, requested, the next metres."""
    pusher = robot.neighbors.beacons[row]
    return np.vstack(
        (
            pusher["held"][: pusher["held_size"]],
            pusher["wanted"][: pusher["wanted_size"]],
            pusher["intent"][: min(int(pusher["intent_size"]), INTENT_POINTS)],
        )
    )


def refuge_path(
    robot: RobotView,
    start: tuple[float, float],
    way: FloatArray,
    reach: float,
    priority: int,
    smooth: bool = True,
) -> FloatArray | None:
    """Return the way (n, 2) from a place to the nearest place out of a pusher's way.

    On the floor where two robots pass each other, if one is free there: on a single lane the next
    robot would push it again, in a blind end without a way out. From a single lane it may be any
    distance away, since all who stand there have to leave; in a room others make room. Robots that
    rank at least `priority` and stuck ones are walls; lower ones may be pushed. Tries a smooth path
    with a margin first, then tighter ones; None if there is no refuge. A smooth one cuts corners
    and keeps off walls, which may lead nearer to a robot beside it or to what only the LiDAR sees:
    where that bars the way, none is tried.

    Args:
        start: (x, y) [m] in map.
        way: (n, 2) [m] in map that the pusher needs.
        reach: [m] to keep from that.
        smooth: Whether the first try is for a smooth path.
    """
    neighbors = robot.neighbors
    taken = robot.planner.no_extra()
    traffic_costs.stamp(taken, robot, way, reach, 1.0)
    gaps = np.hypot(*(way - start).T)
    if float(gaps.min()) < reach - REFUGE_MARGIN / 2:
        # a node within half a step may be out of the way where the robot itself is not
        traffic_costs.stamp(taken, robot, start, robot.planner.lattice.step, 1.0)
    traffic_costs.stamp_tubes(taken, robot, REFUGE_MARGIN, 1.0)
    for other in np.flatnonzero(neighbors.heads["mode"] == MODE_YIELD):
        target = neighbors.heads["target"][other]
        if int(neighbors.ids[other]) != robot.donations.yields_for and math.isfinite(
            float(target[0])
        ):
            traffic_costs.stamp(taken, robot, target, robot.reach(int(other)), 1.0)
    in_room = is_in_room(robot, start)
    most = robot.config.holding.search_distance if in_room else math.inf
    is_higher = neighbors.priorities >= priority
    tries = ((0.003, smooth and robot.obstacle_ticks == 0), *TIGHTER)
    anywhere = robot.planner.free_places(taken)
    in_rooms = anywhere & passing_areas(*robot.passing)
    for places in (in_rooms, anywhere) if (in_rooms != anywhere).any() else (anywhere,):
        path = _nearest(robot, start, places, is_higher, tries, most) if places.any() else None
        if path is not None:
            return path
    return place_of_another(robot, start, way, reach, is_higher) if in_room else None


def place_of_another(
    robot: RobotView, start: tuple[float, float], way: FloatArray, reach: float, is_higher: Mask
) -> FloatArray | None:
    """Return the way (n, 2) to a place in a room that a lower robot leaves for this one, if any.

    That robot is pushed in turn, as in PIBT: so a chain of robots moves up where no place is free
    as long as they stand as they do.

    Args:
        start: (x, y) [m] in map.
        way: (n, 2) [m] in map that the pusher needs.
        reach: [m] to keep from that.
        is_higher: (n,) neighbours that cannot be pushed for this.
    """
    is_wall = is_higher | robot.neighbors.unyielding
    most = robot.config.holding.search_distance
    taken = robot.planner.no_extra()
    traffic_costs.stamp(taken, robot, way, reach, 1.0)
    traffic_costs.stamp(taken, robot, start, 2.0 * robot.planner.lattice.step, 1.0)
    traffic_costs.stamp_tubes(taken, robot, REFUGE_MARGIN, np.where(is_wall, 1.0, 0.0))
    traffic_costs.stamp_obstacles(taken, robot, 1.0)
    places = robot.planner.free_places(taken)
    return _nearest(robot, start, places, is_higher, ((0.003, False), *TIGHTER), most)


def _nearest(
    robot: RobotView,
    start: tuple[float, float],
    places: NDArray[np.uint8],
    is_higher: Mask,
    tries: Iterable[Try],
    most: float,
) -> FloatArray | None:
    """Return the way to the nearest of some places by the first (margin, smooth) that has one."""
    for margin, smooth in tries:
        extra = traffic_costs.refuge_costs(robot, is_higher, margin)
        path = robot.planner.nearest(start, extra, places, most, smooth)
        if path is not None:
            return path
    return None


def retreat_path(
    robot: RobotView, start: tuple[float, float], distance: float
) -> FloatArray | None:
    """Return a way to a free place at least so far from where it starts, if any.

    Args:
        start: (x, y) [m] in map.
        distance: [m]
    """
    taken = robot.planner.no_extra()
    traffic_costs.stamp(taken, robot, start, distance, 1.0)
    traffic_costs.stamp_tubes(taken, robot, REFUGE_MARGIN, 1.0)
    places = robot.planner.free_places(taken)
    neighbors, own = robot.neighbors, robot.priority
    # of robots that inherited the same priority the smaller id may push, see `highest_pusher`
    is_equal = (neighbors.priorities == own) & (neighbors.ids < robot.robot_id)
    extra = traffic_costs.refuge_costs(robot, (neighbors.priorities > own) | is_equal, 0.003)
    most = robot.config.holding.search_distance
    return robot.planner.nearest(start, extra, places, most, False)
