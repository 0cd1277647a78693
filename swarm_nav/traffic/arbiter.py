"""Rules propose, the arbiter writes: what is held, and which path is followed.

In each tick the arbiter asks the rules in the order of their table (`behaviour/rules.py`) and
applies each answer before it asks the next one. The first final answer wins: lower rules are not
asked. Nothing else changes the path or the held space.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

from swarm_common.model.records import FloatArray, Twist
from swarm_nav.control.controller import Controller
from swarm_nav.interfaces import Proposal
from swarm_nav.reservation import tube_kernels
from swarm_nav.traffic.pilot import TwistPilot
from swarm_nav.traffic.robot_state import RobotState
from swarm_nav.traffic.single_lanes import SingleLanes
from swarm_nav.traffic.stop_filter import clip_to_held_space

WHY = {tube_kernels.ROBOT: "is in the way", tube_kernels.RIGHT_OF_WAY: "has the right of way"}
NEVER = 1 << 30  # ticks
COMES = "comes through a single lane"

GO_ON = Proposal()
STAND = Proposal(stands=True)
DROP_PATH = Proposal(drops_path=True)


class TrafficRule(Protocol):
    """One rule of the table; it reads the robot's state and changes nothing but its own."""

    def propose(self, robot: RobotState) -> Proposal | None:
        """Return the request of the rule in this tick, None for nothing."""


def planned(
    robot: RobotState, find: Callable[[tuple[float, float]], FloatArray | None]
) -> Proposal | None:
    """Return a proposal of a path from the stop point, None without one.

    A path that leads back along held space is planned again from where the robot can stop; then
    that space and the path before are given up, even if there is no path from there.

    Args:
        find: Returns the path (n, 2) [m] in map from a place (x, y); None if there is none.
    """
    path = find(robot.stop_point)
    keep = robot.points_kept_for(path) if path is not None else None
    if keep is None:
        return None if path is None else Proposal(path=path)
    path = find(robot.stop_point_after(keep))
    return Proposal(keep_ahead=keep, drops_path=True, path=path)


class Arbiter:
    """The only writer of the path and of the held space.

    Attributes:
        winner: The final proposal of this tick.
    """

    def __init__(self, robot: RobotState, single_lanes: SingleLanes) -> None:
        """Start with the robot's own place.

        Args:
            single_lanes: Lanes on which the held space must not grow.
        """
        self._s = robot
        self._single_lanes = single_lanes
        self.winner = GO_ON
        self._retracted_tick = self._retracting_since = -1000

    @property
    def why(self) -> str:
        """Reason that the rule that won in this tick gives to people; empty for none."""
        why = self.winner.why
        return why if isinstance(why, str) else why()

    def decide(self, rules: Iterable[TrafficRule]) -> None:
        """Ask the rules in their order, and apply what they propose, up to a final proposal."""
        self.winner = GO_ON
        for rule in rules:
            proposal = rule.propose(self._s)
            if proposal is not None:
                self.apply(proposal)
                if proposal.is_final:
                    self.winner = proposal
                    return

    def apply(self, proposal: Proposal) -> None:
        """Change path and held space as proposed; the robot keeps what it needs to stop."""
        s, tube = self._s, self._s.tube
        if proposal.keep_until is not None:
            s.release_beyond(proposal.keep_until)
        if proposal.keep_ahead is not None:
            s.release_ahead(proposal.keep_ahead)
        if proposal.drops_path:
            tube.cut()
        if proposal.holds_place:
            tube.shrink_to_place(s.pose)
        if proposal.path is not None and len(proposal.path) >= 2:
            tube.adopt(proposal.path)
        if proposal.more is not None:
            tube.lengthen(proposal.more)
        if proposal.is_reverse is not None:
            tube.is_reverse = proposal.is_reverse

    def drop_path(self) -> None:
        """Give up the path beyond the stop point: the goal that it led to is another one."""
        self.apply(DROP_PATH)

    def stop_short(self) -> None:
        """Give up the way ahead, and the held space that is not needed for stopping."""
        self.apply(Proposal(keep_ahead=self._s.brake_points, drops_path=True))

    def follow(self, controller: Controller, may_back: bool) -> Twist:
        """Return the twist that does what the winner asks for.

        Args:
            may_back: Whether the path may be driven backwards.
        """
        s, tube, winner = self._s, self._s.tube, self.winner
        if winner.stands:
            if winner.yaw is None:
                return controller.stop(s.twist)
            turn = controller.turn_to(winner.yaw, s.pose, s.twist)
            rate = max(-winner.most_rate, min(winner.most_rate, turn.wz))
            return Twist(turn.vx, turn.vy, rate)
        if winner.is_reverse is None:
            is_reverse = controller.is_reverse(tube, s.pose, s.twist, may_back)
            if is_reverse is None:
                return controller.stop(s.twist)
            tube.is_reverse = is_reverse
        tube.track(s.pose)
        twist = controller.follow(tube, s.pose, s.twist)
        speed = max(-winner.most_speed, min(winner.most_speed, twist.vx))
        return Twist(speed, twist.vy, twist.wz)

    def follow_pilot(self, pilot: TwistPilot) -> Twist:
        """Return the twist of somebody who steers in place of a controller."""
        self._s.tube.track(self._s.pose)
        return pilot.steer(self._s, self.winner.stands)

    def guard(self, wish: Twist) -> Twist:
        """Return what the stop filter leaves of a twist; give up what lies behind the robot."""
        twist, tail = clip_to_held_space(self._s, wish)
        self._s.tube.follow_robot(tail)
        return twist

    def extend(self) -> None:
        """Let the held space grow along the path as far as the neighbours leave room."""
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
        # A centre that gives the way has settled who goes first.
        last, ahead = (span[1], -1) if s.is_led else self._single_lanes.barrier(s, span[1])
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
            (
                NEVER if s.is_led else traffic.push_ticks,
                traffic.yield_slack,
                s.neighbors.hearing_reach,
            ),
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

    def retract(self) -> None:
        """Keep only the space that the robot needs to stop, and request nothing.

        A robot that is merely not heard for a moment keeps path and request: over a slow radio that
        happens more often than a request can be acknowledged.
        """
        s = self._s
        if s.tick - self._retracted_tick > 1:
            self._retracting_since = s.tick
        self._retracted_tick = s.tick
        waited = s.tick - self._retracting_since
        if s.neighbors.deaf_neighbor and waited < s.stuck_ticks:
            self.apply(Proposal(keep_ahead=0 if s.is_standing else s.brake_points))
            return
        self.apply(Proposal(keep_ahead=s.brake_points))
        s.tube.withdraw()
        if s.is_standing:
            s.tube.shrink_to_place(s.pose)
