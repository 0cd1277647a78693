"""The robot's claim to space: extends, guards and gives up the held tube, tick by tick."""

from __future__ import annotations

import numpy as np

from swarm_nav.control import tube_kernels
from swarm_nav.traffic.robot_state import RobotState
from swarm_nav.traffic.single_lanes import SingleLanes

GROWTH_SLACK = 0.06  # [m] by which tubes are nearer than both radii without any growth
WATCHDOG_MOTION = 0.06  # [m]
WHY = {tube_kernels.ROBOT: "is in the way", tube_kernels.RIGHT_OF_WAY: "has the right of way"}
COMES = "comes through a single lane"


class ReservationManager:
    """Changes the tube by what the neighbours leave, the LiDAR sees and the robot uses."""

    def __init__(self, robot: RobotState, single_lanes: SingleLanes) -> None:
        """Start with the robot's own place.

        Args:
            robot: Of the robot; its tube is what changes.
            single_lanes: Where the tube must not grow.
        """
        self._s = robot
        self._single_lanes = single_lanes
        self._watch_pose = robot.pose
        self._watch_tick = robot.tick
        self._retracted_tick = self._retracting_since = -1000

    def extend(self) -> None:
        """Let the tube grow as far as the neighbours leave space."""
        s = self._s
        tube = s.tube
        traffic = s.config.traffic
        span = tube.span
        is_listening = s.tick - s.listening_since < traffic.listen_ticks
        if is_listening or span[1] <= span[0]:
            s.blocked_ticks = s.obstacle_ticks = 0
            s.blocked_by = 0
            s.has_grown = False
            return
        last, ahead = self._single_lanes.barrier(s, span[1])
        if last <= span[0]:
            s.has_grown = False
            self._record_block(tube_kernels.RIGHT_OF_WAY, ahead)
            s.blocked_why = COMES
            return
        last, clearance = self._stretch(span[0], last)
        stop, reason, row = tube_kernels.extend(
            tube.points,
            (span[0], last, span[2]),
            (s.radius, s.priority, s.robot_id, s.yields_for),
            *tube.published_held,
            tube.requests,
            (traffic.push_ticks, traffic.yield_slack, s.neighbors.hearing_reach),
            (s.obstacle_points(), clearance),
            s.neighbors.claims(),
        )
        s.has_grown = stop > tube.stop
        tube.stop = stop
        self._record_block(reason, row)

    def _stretch(self, first: int, last: int) -> tuple[int, float]:
        """Return (last point with the same clearance from LiDAR hits as the next, clearance)."""
        s = self._s
        if s.oblong is None:
            return last, s.obstacle_clearance
        clearances = s.obstacle_clearances(s.tube.points[first + 1 : last + 1])
        same = int((clearances != clearances[0]).argmax())
        return (first + same if same else last), float(clearances[0])

    def _record_block(self, reason: int, row: int) -> None:
        s = self._s
        is_robot = reason in (tube_kernels.ROBOT, tube_kernels.RIGHT_OF_WAY)
        s.is_unconfirmed = reason == tube_kernels.UNCONFIRMED and not s.has_grown
        s.obstacle_ticks = s.obstacle_ticks + 1 if reason == tube_kernels.OBSTACLE else 0
        if is_robot and not s.has_grown:
            s.blocked_ticks += 1
            s.blocked_by = int(s.neighbors.ids[row])
            s.blocked_why = WHY[reason]
            if int(s.neighbors.heads["yields_for"][row]) == s.robot_id:
                s.tube.withdraw()
        elif s.has_grown or reason != tube_kernels.UNCONFIRMED:
            if s.blocked_ticks > s.stuck_ticks:
                s.counters.deadlocks_resolved += 1
            s.blocked_ticks = 0
            s.blocked_by = 0

    def guard(self) -> None:
        """Shrink the tube before anything that the LiDAR sees in it."""
        s = self._s
        if s.is_corrected:
            self._part()
        tube = s.tube
        points = s.obstacle_points()
        if len(points) == 0:
            return
        held = tube.points[tube.near : tube.stop + 1]
        gaps = np.hypot(
            held[:, None, 0] - points[None, :, 0], held[:, None, 1] - points[None, :, 1]
        ).min(axis=1)
        clearance = s.obstacle_clearance if s.oblong is None else s.obstacle_clearances(held)
        bad = np.flatnonzero((gaps < clearance) & (gaps <= gaps[0]))
        bad = bad[bad > 0]
        if len(bad):
            s.release_beyond(tube.near + int(bad[0]) - 1)
            s.obstacle_ticks += 1

    def _part(self) -> None:
        """Give up points that are too near to another tube since a radius has grown."""
        s, tube = self._s, self._s.tube
        first = tube_kernels.first_overlap(
            tube.points, tube.near, tube.stop, s.radius, GROWTH_SLACK, s.neighbors.columns()
        )
        if first <= tube.stop:
            s.release_beyond(first - 1)

    def drop_if_unused(self) -> bool:
        """Drop a claim that is not being driven, whatever the reason; return whether it was."""
        s = self._s
        is_moving = s.pose.distance(self._watch_pose) > WATCHDOG_MOTION
        if is_moving or s.tube.stop <= s.tube.near:
            self._watch_pose = s.pose
            self._watch_tick = s.tick
        elif s.tick - self._watch_tick > s.stuck_ticks and abs(s.twist.vx) < 0.02:
            self._watch_tick = s.tick
            s.tube.reset(s.pose)
            return True
        return False

    def retract(self) -> None:
        """Keep only the space that the robot needs to stop, and request nothing.

        A robot that is merely not heard for a moment keeps path and request: over a slow radio that
        happens more often than a request can be acknowledged.
        """
        s, tube = self._s, self._s.tube
        if s.tick - self._retracted_tick > 1:
            self._retracting_since = s.tick
        self._retracted_tick = s.tick
        waited = s.tick - self._retracting_since
        if s.neighbors.deaf_neighbor and waited < s.stuck_ticks:
            s.release_ahead(0 if s.is_standing else s.brake_points)
            return
        s.release_ahead(s.brake_points)
        tube.withdraw()
        if s.is_standing:
            tube.reset(s.pose)
