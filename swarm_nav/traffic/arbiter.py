"""Rules propose, the arbiter writes: what is held, and which path is followed.

In each tick the arbiter asks the rules in the order of their table (`behaviour/rules.py`). It has
the events of each answer applied, and applies its request, before it asks the next rule. The first
final answer wins: lower rules are not asked. Nothing else changes the path or the held space, and
every command passes the stop filter here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np

from swarm_common.model.beacon import HELD_POINTS
from swarm_common.model.grid import Grid
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Twist
from swarm_common.model.zones import DirectedZone
from swarm_nav.control.controller import Controller
from swarm_nav.core.config import NavConfig
from swarm_nav.interfaces import Proposal, RuleEvent
from swarm_nav.planning.planner import SPACING
from swarm_nav.planning.terrain import terrain_for
from swarm_nav.reservation import tube_kernels
from swarm_nav.reservation.tube import TOLERANCE
from swarm_nav.traffic.robot_state import RobotState, RobotView
from swarm_nav.traffic.single_lanes import SingleLanes
from swarm_nav.traffic.stop_filter import clip_to_held_space

WHY = {tube_kernels.ROBOT: "is in the way", tube_kernels.RIGHT_OF_WAY: "has the right of way"}
NEVER = 1 << 30  # ticks
MARGIN_STEP = 0.02  # [m] in which the announced margin grows: each step must be confirmed

GO_ON = Proposal()
STAND = Proposal(stands=True)
DROP_PATH = Proposal(drops_path=True)


class TrafficRule(Protocol):
    """One rule of the table; it reads the robot's state and changes nothing but its own."""

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return the request of the rule in this tick, None for nothing."""


class TwistPilot(TrafficRule, Protocol):
    """The last rule of a robot, and what drives it in place of its controller.

    Stop filter and speed limits stay above it. Its class may be one that is not compiled.
    """

    def steer(self, robot: RobotView, stands: bool) -> Twist:
        """Return the twist of this tick, in base_footprint.

        Args:
            robot: Its path is tracked up to now.
            stands: Whether the rule that won asks the robot to stand.
        """


def planned(
    robot: RobotView, find: Callable[[tuple[float, float]], FloatArray | None]
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
    """The only writer of the path and of the held space, and of what is announced of them.

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
        self._is_reverse: bool | None = None  # as proposed in this tick
        self._retracted_tick = self._retracting_since = -1000

    @property
    def why(self) -> str:
        """Reason that the rule that won in this tick gives to people; empty for none."""
        why = self.winner.why
        return why if isinstance(why, str) else why()

    def decide(self, rules: Iterable[TrafficRule], on_event: Callable[[RuleEvent], None]) -> None:
        """Ask the rules in their order, and apply what they propose, up to a final proposal.

        Args:
            on_event: Applies an event to goal and state.
        """
        self.winner, self._is_reverse = GO_ON, None
        for rule in rules:
            proposal = rule.propose(self._s)
            if proposal is not None:
                for event in proposal.events:
                    on_event(event)
                self.apply(proposal)
                if proposal.is_final:
                    self.winner = proposal
                    return

    def apply(self, proposal: Proposal) -> None:
        """Change path and held space as proposed; the robot keeps what it needs to stop."""
        s, tube = self._s, self._s.tube
        if proposal.is_obstructed:
            s.obstacle_ticks += 1
        if proposal.keep_until is not None:
            self._release_beyond(proposal.keep_until)
        if proposal.keep_ahead is not None:
            tube.advance(s.pose, min(tube.next_corner(), tube.stop))
            self._release_beyond(tube.near + proposal.keep_ahead)
        if proposal.drops_path:
            tube.cut()
        if proposal.holds_place:
            tube.shrink_to_place(s.pose)
        if proposal.path is not None and len(proposal.path) >= 2:
            tube.adopt(proposal.path)
        if proposal.more is not None:
            tube.lengthen(proposal.more)
        if proposal.is_reverse is not None:
            tube.is_reverse = self._is_reverse = proposal.is_reverse

    def _release_beyond(self, last: int) -> None:
        """Give up held space beyond a point, but not what the robot needs to stop."""
        s = self._s
        s.tube.release_beyond(s.last_needed(s.tube.near, last))

    def drop_path(self) -> None:
        """Give up the path beyond the stop point: the goal that it led to is another one."""
        self.apply(DROP_PATH)

    def stop_short(self) -> None:
        """Give up the way ahead, and the held space that is not needed for stopping."""
        self.apply(Proposal(keep_ahead=self._s.brake_points, drops_path=True))

    def hold_place(self) -> None:
        """Drop path, claim and request; hold the place, and ahead of it what it takes to stop.

        A robot that stands in its held space keeps the point of it that is nearest. For use between
        two ticks: the robot may have gone faster since its pose was taken.
        """
        s, tube = self._s, self._s.tube
        if s.is_standing and tube.gap(s.pose) <= TOLERANCE:
            tube.shrink_to_place(s.pose)
            return
        tube.reset(s.pose)
        if s.is_standing:
            return
        wz, speed = s.twist.wz, max(s.speed, 0.02)
        rest = s.way_to_stop(s.speed + s.acceleration * CONTROL_PERIOD)
        yaw = s.pose.yaw + math.atan2(s.twist.vy, s.twist.vx)
        x, y = s.pose.x, s.pose.y
        line = [(x, y)]
        spacing = max(SPACING, rest / (HELD_POINTS - 2))  # so that it fits a beacon
        while rest > 1e-9:
            step = min(rest, spacing)
            yaw += 0.5 * wz * step / speed
            x, y = x + step * math.cos(yaw), y + step * math.sin(yaw)
            yaw += 0.5 * wz * step / speed
            line.append((x, y))
            rest -= step
        tube.adopt(np.array(line))
        tube.stop = len(line) - 1
        tube.is_reverse = s.twist.vx < 0.0

    # Parameters, map and what is announced: a request counts only as it was announced

    def load_map(self, grid: Grid) -> None:
        """Replace the map; the path on the old one ends at the stop point.

        Args:
            grid: Occupancy, in the same map frame.

        Raises:
            MapError: If the map has too many cells when it is divided into finer ones.
        """
        s, config = self._s, self._s.config
        s.terrain = terrain_for(grid, config.planner, config.costmap, s.body_radius, s.oblong)
        s.tube.slots = s.terrain.lattice.slots
        s.planner = s.make_planner(s.terrain, config.planner)
        self.direct(s.directed)
        s.record_bodies()

    def direct(self, zones: tuple[DirectedZone, ...]) -> None:
        """Plan ways to goals as directed zones want; the present path ends at the stop point.

        Held space, ranks and admission know nothing of them.
        """
        s = self._s
        s.directed = zones
        s.planner.direct(zones)
        s.tube.cut()

    def configure(self, config: NavConfig) -> None:
        """Apply new parameters, and hand them to every layer."""
        s, old, traffic = self._s, self._s.config, config.traffic
        s.config = config
        s.radius = s.usual_radius
        s.neighbors.configure(traffic)
        s.obstacles.configure(config.costmap)
        s.tube.configure(traffic.confirmations, traffic.held_length, traffic.wanted_length)
        s.tube.corner_angle = config.controller.corner_angle
        s.record_bodies()
        if (config.planner, config.costmap) != (old.planner, old.costmap):
            self.load_map(s.terrain.grid)

    def announce_margin(self, needed: float) -> None:
        """Announce another safety margin [m], never less than configured.

        Space is granted only to requests that all have acknowledged together with the radius that
        it was requested with; what is held is checked by `held_space_rules`.

        Args:
            needed: [m]
        """
        s, least = self._s, self._s.usual_radius
        wanted = max(least, s.body_radius + needed)
        if s.radius >= wanted > s.radius - 2.0 * MARGIN_STEP or wanted == s.radius:
            return
        if wanted > s.radius:
            s.tube.forget_requests()
        s.radius = least + MARGIN_STEP * math.ceil((wanted - least) / MARGIN_STEP - 1e-9)

    def announce_priorities(self, own: int, published: int) -> None:
        """Announce a priority.

        Args:
            own: Without what is inherited from robots that push.
        """
        s = self._s
        if published != s.priority:
            s.tube.forget_requests()  # robots that acknowledged them compared another priority
        s.own_priority, s.priority = own, published

    def publish(self) -> None:
        """Put what is held and requested into the next beacon."""
        self._s.tube.publish(self._s.pose, self._s.tick)

    # The command of a tick

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
        if self._is_reverse is None:
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

    def guard(self, wish: Twist, *, releases: bool) -> Twist:
        """Return what the stop filter leaves of a twist.

        Args:
            releases: Whether the robot gives up what lies behind it.
        """
        twist, tail = clip_to_held_space(self._s, wish)
        if releases:
            self._s.tube.follow_robot(tail)
        return twist

    def settle(self) -> None:
        """Hold only the stop point once the robot stands on it."""
        self._s.tube.record_rest(self._s.pose, self._s.is_standing)

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
            s.blocked_why = self._single_lanes.why
            return
        last, clearance = self._stretch(span[0], last)
        stop, reason, row = tube_kernels.extend(
            tube.points,
            (span[0], last, span[2]),
            (s.radius, s.priority, s.robot_id, s.donations.yields_for),
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
