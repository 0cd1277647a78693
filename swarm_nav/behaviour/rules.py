"""The rules of one robot, in the order in which the arbiter asks them.

Safety comes first, then service and making way, then admission to stations and narrow regions, and
last the way to the goal. `traffic.rules` leaves rules out, or adds one that a user brings. Lease
and gate decide in each tick before that, and `wait` obeys them; single lanes decide as the held
space grows. Each says why.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import CONTROL_PERIOD, RobotSpec
from swarm_nav.behaviour.parts import Parts
from swarm_nav.behaviour.plugin_rule import PluginRule
from swarm_nav.behaviour.route import Route
from swarm_nav.core.goals import ErrorCode, PlanError
from swarm_nav.core.plugins import RULE_NAMES, Report, rule_names
from swarm_nav.core.states import State
from swarm_nav.interfaces import Proposal, RuleEvent
from swarm_nav.interfaces import RuleEventKind as Kind
from swarm_nav.traffic.arbiter import STAND, TrafficRule
from swarm_nav.traffic.held_space_rules import DropUnused, KeepApart, StopBeforeObstacle
from swarm_nav.traffic.lease import QUEUE_STEP, Lease
from swarm_nav.traffic.robot_state import RobotView

QUEUED = (RuleEvent(Kind.QUEUED),)
REACHED_LAST = Proposal(events=(RuleEvent(Kind.REACHED),), stands=True)
REACHED = Proposal(events=REACHED_LAST.events)
TURN_GRANTED = Proposal(events=(*QUEUED, RuleEvent(Kind.TURN_GRANTED)))
INTERRUPT, RESUME, STRAYED, FOLLOW, DRIVEN, EXCUSED, CAUTIOUS = (
    Proposal(events=(RuleEvent(kind),), is_final=False)
    for kind in (
        Kind.INTERRUPTED, Kind.RESUMED, Kind.STRAYED, Kind.FOLLOWED,
        Kind.DRIVEN, Kind.EXCUSED, Kind.CAUTIOUS,
    )
)  # fmt: skip
FOLLOW_BACK = replace(FOLLOW, is_reverse=True)


class MakeWay:
    """Makes way for a robot that ranks higher, or steps back; not while the robot is served."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return the way to a refuge, once; then go on along it."""
        right = self._p.right
        is_served = self._p.goal_manager.is_pausing
        proposal = right.stay(robot) if is_served else right.propose(robot)
        if right.is_yielding:
            return (
                INTERRUPT
                if proposal is None
                else replace(proposal, events=INTERRUPT.events, is_final=False)
            )
        return None if proposal is None else replace(proposal, is_final=False)


class Leave:
    """Moves a robot without a goal out of the way of those who want to go where it stands."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts
        self._go_on = Proposal(why=self._why)
        self._leave = replace(INTERRUPT, is_final=True, why=self._why)

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return the way out, once; then go on along it. Else resume what was interrupted."""
        p = self._p
        is_yielding = p.right.is_yielding
        proposal = p.departure.propose(robot, p.goal_manager.is_idle and not is_yielding)
        if is_yielding:
            return self._go_on
        if p.departure.is_leaving:
            return (
                self._leave
                if proposal is None
                else replace(proposal, events=INTERRUPT.events, why=self._why)
            )
        return RESUME if p.state_machine.state is State.YIELDING else None

    def _why(self) -> str:
        """Return for whom the robot leaves its way, and for what it waits there."""
        robot, right = self._p.robot, self._p.right
        what = "steps back" if right.is_retreating else "leaves for others"
        if robot.donations.yields_for:
            what = f"makes way for {robot.names.name_of(robot.donations.yields_for)}"
        if robot.awaited:
            return f"{what}, waits {robot.awaited}"
        return f"{what}, finds no place" if right.is_stuck else what


class Behave:
    """Runs a behaviour that somebody asked for, or a recovery."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return the request of the behaviour; end it when it is over."""
        if self._p.state_machine.state not in (State.BEHAVING, State.RECOVERING):
            return None
        behavior = self._p.goal_manager.behavior
        if behavior is None:
            return Proposal(events=(RuleEvent(Kind.BEHAVIOR_ENDED),), stands=True)
        proposal, end = behavior.propose(robot), behavior.end
        if end is None:
            return proposal
        event = RuleEvent(Kind.BEHAVIOR_ENDED, end.code, end.message)
        return replace(proposal, events=(event,))


class Arrive:
    """Stops within the tolerance of a target, turns to its heading, and ends it."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return how to settle at the target once the robot has arrived."""
        task = self._p.goal_manager.task
        if self._p.state_machine.state is not State.DRIVING or task is None:
            return None
        arrives = task.arrives(robot)
        if task.is_reached(robot, arrives):
            return REACHED if task.has_next else REACHED_LAST
        if not arrives:
            return STRAYED if task.has_arrived else None
        is_standing = abs(robot.twist.vx) < 0.02
        turns = is_standing and not np.isnan(task.target.yaw)
        return Proposal(
            events=() if task.has_arrived else (RuleEvent(Kind.ARRIVED),),
            keep_ahead=robot.brake_points,
            drops_path=True,
            holds_place=is_standing,
            stands=True,
            yaw=task.target.yaw if turns else None,
        )


class WaitForTurn:
    """Waits before a full region, and for the turn at a station, in the holding pattern."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts
        self._held_place = 0  # in the queue when the robot began to wait
        self._begin = Proposal(events=(RuleEvent(Kind.TURN_AWAITED),), why=self._why)
        self._wait = Proposal(events=QUEUED, why=self._why)

    def propose(self, robot: RobotView) -> Proposal | None:
        """Begin to wait, or return where to wait until it is the robot's turn."""
        state = self._p.state_machine.state
        if state is State.HOLDING:
            return self._hold(robot)
        if state is not State.DRIVING:
            return None
        p = self._p
        has_to_wait = p.gate.is_closed
        if not has_to_wait:
            if p.lease.is_barred(robot):
                message = _who_is_on_the_station(p.lease, robot)
                failure = RuleEvent(Kind.FAILED, ErrorCode.GOAL_OCCUPIED, message)
                return Proposal(events=(failure,))
            is_others_turn = p.lease.station is not None and not self._has_turn(robot)
            has_to_wait = is_others_turn and p.lease.is_too_near(robot)
        if not has_to_wait:
            return None
        self._held_place = p.lease.place
        return self._begin

    def _hold(self, robot: RobotView) -> Proposal:
        p = self._p
        period = robot.ticks(robot.config.traffic.stuck_time)
        if p.gate.is_closed and (robot.tick + robot.robot_id) % period == 0:
            self._recheck_gate(robot)
        has_turn = self._has_turn(robot) or p.lease.is_barred(robot) or self._moves_up(robot)
        if has_turn and not p.gate.is_closed:
            return TURN_GRANTED
        proposal = p.holding.propose(robot, self._kept_free)
        if proposal is None:
            return self._wait
        return replace(proposal, events=QUEUED, why=self._why)

    def _why(self) -> str:
        """Return where the robot waits, and for whom."""
        p, names = self._p, self._p.robot.names
        where = "on the circuit" if p.holding.is_on_circuit else "parked"
        reason = p.gate.why(names) if p.gate.is_closed else p.lease.why(names, p.sites)
        return f"{where}, waits {reason}"

    def _kept_free(self) -> NDArray[np.bool_] | None:
        gate = self._p.gate
        region = gate.region if gate.is_closed else None
        return self._p.lease.kept_free(self._p.robot) if region is None else region > 0

    def _moves_up(self, robot: RobotView) -> bool:
        """Whether the queue is much shorter now: the robot may wait nearer to the station."""
        lease = self._p.lease
        return 2 * lease.place <= self._held_place and not lease.is_too_near(robot, QUEUE_STEP)

    def _recheck_gate(self, robot: RobotView) -> None:
        task = self._p.goal_manager.task
        assert task is not None
        try:
            way = robot.planner.plan(robot.stop_point, task.place, robot.planner.no_extra())
        except PlanError:
            return
        self._p.gate.recheck(robot, way)

    def _has_turn(self, robot: RobotView) -> bool:
        """Whether the robot may approach its station, and nobody stands on it for good."""
        lease = self._p.lease
        return lease.is_turn(robot.config.holding) and lease.covering(robot) is None


class Drive:
    """Plans the way to the target."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts
        self._route = Route(parts.robot)

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return a new path when one is due."""
        task = self._p.goal_manager.task
        if self._p.state_machine.state is not State.DRIVING or task is None:
            return None
        if task.goal.is_reverse and not (robot.is_standing or robot.tube.is_reverse):
            return STAND
        proposal = self._route.propose(task)
        if task.given is None:
            return proposal
        follow = FOLLOW_BACK if task.goal.is_reverse else FOLLOW
        if proposal is None:
            return follow
        events = follow.events + proposal.events
        return replace(proposal, events=events, is_reverse=follow.is_reverse)


class CheckProgress:
    """Says whether the robot was to get on in this tick: else it recovers, or gives the target up.

    Recoveries are proposed by `Behave`.
    """

    def __init__(self, parts: Parts) -> None:
        self._p = parts

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return the event of a robot that drives to a target."""
        if self._p.state_machine.state is not State.DRIVING or self._p.goal_manager.task is None:
            return None
        is_listening = robot.tick - robot.listening_since < 2 * robot.config.traffic.listen_ticks
        if is_listening or robot.blocked_ticks > 0 or robot.is_unconfirmed:
            return EXCUSED
        return CAUTIOUS if self._p.people.is_near else DRIVEN


def _who_is_on_the_station(lease: Lease, robot: RobotView) -> str:
    """Return what is known of the robot or thing that bars the station, and no more."""
    row = lease.covering(robot)
    if row is None:
        return "something that does not move stands on the station"
    name = robot.names.name_of(int(robot.neighbors.ids[row]))
    if not robot.neighbors.gone[row]:
        return f"{name} stands on the station and its navigator is inactive"
    silence = robot.neighbors.ages[row] * CONTROL_PERIOD
    return f"{name} has not been heard for {silence:.0f} s and may still be on the station"


MAKERS = (
    lambda parts: KeepApart(),
    lambda parts: StopBeforeObstacle(),
    lambda parts: DropUnused(parts.robot),
    MakeWay, Leave, Behave, Arrive, WaitForTurn, Drive, CheckProgress,
)  # fmt: skip
RULES: Mapping[str, Callable[[Parts], TrafficRule]] = dict(zip(RULE_NAMES, MAKERS, strict=True))
"""Makers of the built-in rules, in the order in which they are asked."""


def rules_of(parts: Parts, spec: RobotSpec, report: Report) -> list[TrafficRule]:
    """Return the rules that `traffic.rules` names, in its order.

    Args:
        report: Receives faults of rules that a user brings.

    Raises:
        ConfigError: If one is missing.
    """
    names = rule_names(parts.robot.config.traffic.rules)
    return [
        RULES[name](parts) if name in RULES else PluginRule(name, spec, report) for name in names
    ]
