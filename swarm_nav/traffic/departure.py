"""Leaving the place of the last goal when a robot without a goal keeps others out there.

A robot without a goal stands where its last one ended. In the open it blocks no robot, and where
robots only pass it is pushed. But in a narrow region with stations each standing robot takes the
room of a working one; and on single lanes the robot that pushes it stands in its only way out. So
it leaves: a region, when it hears a robot that waits to enter or asks for a station in it, and the
floor before it, through which the others come, if it has left its goal; a station, and the single
lanes around it, when another robot asks for it, large ones unasked, since nobody may be heard
there; and the way of people, who may have no other.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_nav.core.rank import OUT_OF_LANES, inherited_by_holder
from swarm_nav.interfaces import Proposal
from swarm_nav.traffic import gate_kernels, traffic_costs
from swarm_nav.traffic.gate import Gate, label_of
from swarm_nav.traffic.holding import ARRIVED, parking_path
from swarm_nav.traffic.lease import Lease
from swarm_nav.traffic.robot_state import RobotView
from swarm_nav.traffic.single_lanes import passing_areas

PERSON_ROOM = 2.0  # times what a robot keeps from people: so far from where they walk it parks


class Departure:
    """Moves a robot without a goal to a place outside, once it keeps others out.

    That is a parking place, or, where none is free, one where two robots pass each other.

    It ranks just above the robots that wait for it (inheritance, as with a station's lease), as
    they stand between it and the exit: at once where there is one way out, elsewhere once it was
    blocked on its way.
    """

    def __init__(self, gate: Gate, lease: Lease) -> None:
        """Start as a robot that has not asked to leave.

        Args:
            lease: Knows the station that is left; without a goal it has a station on single lanes
                only, until the robot is out.
        """
        self._gate = gate
        self._lease = lease
        self._idle_since = -1
        self._next_search_tick = 0
        self._target: tuple[float, float] | None = None
        self._insists = False  # whether it was blocked on its way out
        self._has_left = False  # whether it left for others since its last goal

    @property
    def is_leaving(self) -> bool:
        """Whether the robot is on its way out."""
        return self._target is not None

    def propose(self, robot: RobotView, is_idle: bool) -> Proposal | None:
        """Propose the way out, once, when the robot is to leave.

        Args:
            is_idle: Whether it has no goal, and does not make way for anybody.
        """
        if not is_idle:
            self._idle_since = -1
            self._insists &= self._lease.station is None
            self._has_left &= self._lease.station is None
            if self._target is not None:
                self._give_up(robot)
            return None
        tick = robot.tick
        if self._idle_since < 0:
            self._idle_since = tick
            self._next_search_tick = tick + robot.wait_ticks
        is_blocked = robot.waited_ticks > robot.wait_ticks
        self._insists |= self._target is not None and is_blocked
        if not self._is_under_way(robot):
            self._give_up(robot)
        if (self._target is None or is_blocked) and tick >= self._next_search_tick:
            way = self._way_for_others(robot)
            return Proposal(path=way) if way is not None and len(way) >= 2 else None
        return None

    def _give_up(self, robot: RobotView) -> None:
        self._target = None
        self._inherit(robot, 0)

    def _inherit(self, robot: RobotView, priority: int) -> None:
        if self._lease.station is None:  # else the lease sees to it
            robot.donations.station = priority

    def _is_under_way(self, robot: RobotView) -> bool:
        """Whether the way out goes on; where there is no other, until it is barred for good."""
        left = self._lease.left
        has_one_way = left is not None and left.room > 0
        waited = robot.unproductive_ticks if has_one_way else robot.waited_ticks
        if self._target is None or waited > robot.wait_ticks:
            return False
        x, y = robot.tube.points[-1]
        return (x, y) == self._target and robot.distance_to(x, y) > ARRIVED

    def _way_for_others(self, robot: RobotView) -> FloatArray | None:
        """Return the way out for others in a region, for a station, or for people."""
        way = self._way_out_of_region(robot)
        if way is not None:
            return way
        pose = robot.pose
        left = self._lease.left
        if left is not None and left.is_of(robot) and left.contains(robot):
            highest = highest_asking(robot, left.floor)
            if highest or left.is_large:
                if left.room:  # one way out: no other robot gets past it
                    return self._way_out(robot, highest, left.floor, OUT_OF_LANES)
                return self._way_out(robot, highest if self._insists else 0, left.floor)
        walked = robot.obstacles.walked(robot.tick)
        room = PERSON_ROOM * robot.obstacle_clearance
        if len(walked) and float(np.hypot(*(walked - (pose.x, pose.y)).T).min()) < room:
            near = robot.planner.no_extra()
            traffic_costs.stamp(near, robot, walked, room, 1.0)
            return self._way_out(robot, 0, near > 0.0)
        return None

    def _way_out_of_region(self, robot: RobotView) -> FloatArray | None:
        """Return the way off the region and the floor before it, for those who ask."""
        region, pose = self._gate.region, robot.pose
        lattice = robot.planner.lattice
        if region is None:
            return None
        stands_inside = label_of(region, lattice.frame, pose.x, pose.y) > 0
        if not (stands_inside or self._has_left):
            return None
        forecourt = self._gate.forecourt(lattice, robot.config.holding.request_distance)
        if forecourt is None or not label_of(forecourt, lattice.frame, pose.x, pose.y):
            return None
        highest = highest_asking(robot, region, at_gate=True)
        if not highest:
            self._insists = False
            return None
        inherited = highest if self._insists and stands_inside else 0
        way = self._parking_way(robot, inherited, forecourt)
        if way is None and stands_inside:
            way = self._way_out(robot, inherited, region > 0)
        return way

    def _way_out(
        self, robot: RobotView, highest: int, closed: NDArray[np.bool_], hops: int = 1
    ) -> FloatArray | None:
        """Return the way to a parking place, else to where others get past."""
        way = self._parking_way(robot, highest, closed, hops)
        if way is None:
            way = self._parking_way(robot, highest, closed, hops, passing_areas(*robot.passing))
        return way

    def _parking_way(
        self,
        robot: RobotView,
        highest: int,
        closed: NDArray[np.bool_],
        hops: int = 1,
        allowed: NDArray[np.bool_] | None = None,
    ) -> FloatArray | None:
        """Return the way to the nearest place outside; of one point if the robot stands there."""
        self._next_search_tick = robot.tick + robot.wait_ticks
        way = parking_path(robot, list(robot.stations), closed, math.inf, allowed)
        if way is not None and len(way) >= 2:
            self._target = robot.tube.end_of(way)
            self._has_left = True
            self._inherit(robot, inherited_by_holder(highest, hops) if highest else 0)
        return way


def highest_asking(
    robot: RobotView, floor: NDArray[np.int16] | NDArray[np.bool_], *, at_gate: bool = False
) -> int:
    """Return the highest priority of robots that ask for a station on a floor, 0 without any.

    Args:
        floor: (h, w) of the lattice.
        at_gate: Whether robots that wait to enter a region count as well.
    """
    neighbors = robot.neighbors
    highest = gate_kernels.highest_asking(
        floor,
        robot.planner.lattice.frame,
        neighbors.request_columns,
        (neighbors.ids, neighbors.priorities, neighbors.gone),
        at_gate,
    )
    return int(highest)
