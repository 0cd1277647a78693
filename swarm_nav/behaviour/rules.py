"""The rules of one robot, in the order in which the arbiter asks them.

Safety comes first, then service and making way, then admission to stations and narrow regions, and
last the way to the goal. `traffic.rules` leaves rules out, or adds one that a user brings.
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
from swarm_nav.core.goals import ErrorCode, Outcome, PlanError
from swarm_nav.core.plugins import RULE_NAMES, Report, rule_names
from swarm_nav.core.states import Event, State
from swarm_nav.interfaces import Proposal
from swarm_nav.traffic.arbiter import GO_ON, STAND, TrafficRule
from swarm_nav.traffic.held_space_rules import DropUnused, KeepApart, StopBeforeObstacle
from swarm_nav.traffic.lease import QUEUE_STEP, Lease
from swarm_nav.traffic.robot_state import RobotState


class MakeWay:
    """Makes way for a robot that ranks higher, or steps back; not while the robot is served."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts

    def propose(self, robot: RobotState) -> Proposal | None:
        """Return the way to a refuge, once; then go on along it."""
        p = self._p
        is_served = p.goal_manager.is_pausing
        proposal = p.right.stay(robot) if is_served else p.right.propose(robot)
        if p.right.is_yielding:
            p.goal_manager.interrupt()
        return None if proposal is None else replace(proposal, is_final=False)


class Leave:
    """Moves a robot without a goal out of the way of those who want to go where it stands."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts
        self._go_on = Proposal(why=self._why)

    def propose(self, robot: RobotState) -> Proposal | None:
        """Return the way out, once; then go on along it. Else resume what was interrupted."""
        p = self._p
        is_yielding = p.right.is_yielding
        proposal = p.departure.propose(robot, p.goal_manager.is_idle and not is_yielding)
        if is_yielding:
            return self._go_on
        if p.departure.is_leaving:
            p.goal_manager.interrupt()
            return self._go_on if proposal is None else replace(proposal, why=self._why)
        p.goal_manager.resume()
        return None

    def _why(self) -> str:
        """Return for whom the robot leaves its way, and for what it waits there."""
        robot, right = self._p.robot, self._p.right
        what = "steps back" if right.is_retreating else "leaves for others"
        if robot.yields_for:
            what = f"makes way for {robot.names.name_of(robot.yields_for)}"
        if robot.awaited:
            return f"{what}, waits {robot.awaited}"
        return f"{what}, finds no place" if right.is_stuck else what


class Behave:
    """Runs a behaviour that somebody asked for, or a recovery."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts

    def propose(self, robot: RobotState) -> Proposal | None:
        """Return the request of the behaviour; end it when it is over."""
        state_machine, goal_manager = self._p.state_machine, self._p.goal_manager
        if state_machine.state not in (State.BEHAVING, State.RECOVERING):
            return None
        behavior = goal_manager.behavior
        if behavior is None:
            is_recovering = state_machine.state is State.RECOVERING
            state_machine.switch(Event.RECOVERED if is_recovering else Event.FINISHED)
            return STAND
        proposal = behavior.propose(robot)
        end = behavior.end
        if end is None:
            return proposal
        if goal_manager.is_recovery:
            goal_manager.drop_recovery()
            self._p.arbiter.drop_path()
            state_machine.switch(Event.RECOVERED)
        elif end.code is ErrorCode.NONE:
            goal_manager.end(Outcome.SUCCEEDED)
        else:
            goal_manager.end(Outcome.ABORTED, end.code, end.message)
        return proposal


class Arrive:
    """Stops within the tolerance of a target, turns to its heading, and ends it."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts

    def propose(self, robot: RobotState) -> Proposal | None:
        """Return how to settle at the target once the robot has arrived."""
        goal_manager = self._p.goal_manager
        task = goal_manager.task
        if self._p.state_machine.state is not State.DRIVING or task is None:
            return None
        if task.is_reached(robot):
            goal_manager.reach_target(task)
            return GO_ON if goal_manager.task is task else STAND
        if not task.has_arrived:
            return None
        is_standing = abs(robot.twist.vx) < 0.02
        turns = is_standing and not np.isnan(task.target.yaw)
        return Proposal(
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
        self._wait = Proposal(why=self._why)

    def propose(self, robot: RobotState) -> Proposal | None:
        """Begin to wait, or return where to wait until it is the robot's turn."""
        state = self._p.state_machine.state
        if state is State.HOLDING:
            return self._hold(robot)
        if state is not State.DRIVING:
            return None
        p, task = self._p, self._p.goal_manager.task
        assert task is not None
        has_to_wait = p.gate.is_closed
        if not has_to_wait:
            if p.lease.is_barred(robot):
                message = _who_is_on_the_station(p.lease, robot)
                p.goal_manager.fail_target(task, ErrorCode.GOAL_OCCUPIED, message)
                return GO_ON
            is_others_turn = p.lease.station is not None and not self._has_turn(robot)
            has_to_wait = is_others_turn and p.lease.is_too_near(robot)
        if not has_to_wait:
            return None
        self._held_place = p.lease.place
        p.state_machine.switch(Event.STATION_TAKEN)
        return self._wait

    def _hold(self, robot: RobotState) -> Proposal:
        p = self._p
        task = p.goal_manager.task
        assert task is not None
        task.record_holding(robot)
        period = robot.ticks(robot.config.traffic.stuck_time)
        if p.gate.is_closed and (robot.tick + robot.robot_id) % period == 0:
            self._recheck_gate(robot)
        has_turn = self._has_turn(robot) or p.lease.is_barred(robot) or self._moves_up(robot)
        if has_turn and not p.gate.is_closed:
            p.state_machine.switch(Event.STATION_GRANTED)
            return GO_ON
        proposal = p.holding.propose(robot, self._kept_free)
        return self._wait if proposal is None else replace(proposal, why=self._why)

    def _why(self) -> str:
        """Return where the robot waits, and for whom."""
        lease, gate, name_of = self._p.lease, self._p.gate, self._p.robot.names.name_of
        where = "on the circuit" if self._p.holding.is_on_circuit else "parked"
        station = lease.name_in(self._p.sites) or "its goal"
        if gate.is_closed:
            return f"{where}, waits for {name_of(gate.first)}: the narrow region ahead is full"
        if lease.first:
            queue = f"{station} or others in its aisle" if lease.is_shared else station
            return f"{where}, waits for {name_of(lease.first)}, {lease.place} before it at {queue}"
        if lease.is_full:
            return f"{where}, waits for room on the single lanes at {station}"
        return f"{where}, waits until {station} is free"

    def _kept_free(self) -> NDArray[np.bool_] | None:
        gate = self._p.gate
        region = gate.region if gate.is_closed else None
        return self._p.lease.kept_free(self._p.robot) if region is None else region > 0

    def _moves_up(self, robot: RobotState) -> bool:
        """Whether the queue is much shorter now: the robot may wait nearer to the station."""
        lease = self._p.lease
        return 2 * lease.place <= self._held_place and not lease.is_too_near(robot, QUEUE_STEP)

    def _recheck_gate(self, robot: RobotState) -> None:
        task = self._p.goal_manager.task
        assert task is not None
        try:
            way = robot.planner.plan(robot.stop_point, task.place, robot.planner.no_extra())
        except PlanError:
            return
        self._p.gate.recheck(robot, way)

    def _has_turn(self, robot: RobotState) -> bool:
        """Whether the robot may approach its station, and nobody stands on it for good."""
        lease = self._p.lease
        return lease.is_turn(robot.config.holding) and lease.covering(robot) is None


class Drive:
    """Plans the way to the target."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts
        self._route = Route(parts.robot, parts.goal_manager)

    def propose(self, robot: RobotState) -> Proposal | None:
        """Return a new path when one is due."""
        task = self._p.goal_manager.task
        if self._p.state_machine.state is not State.DRIVING or task is None:
            return None
        proposal = self._route.propose(task)
        if self._p.goal_manager.task is not task:
            return GO_ON
        return None if proposal is None else replace(proposal, is_final=False)


class CheckProgress:
    """Recovers, or gives a target up, where the robot does not get on."""

    def __init__(self, parts: Parts) -> None:
        self._p = parts

    def propose(self, robot: RobotState) -> Proposal | None:
        """Return nothing: recoveries are proposed by `Behave`."""
        if self._p.state_machine.state is State.DRIVING and self._p.goal_manager.task is not None:
            self._check_progress(robot)
        return None

    def _check_progress(self, robot: RobotState) -> None:
        goal_manager = self._p.goal_manager
        task, traffic = goal_manager.task, robot.config.traffic
        assert task is not None
        is_listening = robot.tick - robot.listening_since < 2 * traffic.listen_ticks
        is_waiting = robot.blocked_ticks > 0 or robot.is_unconfirmed
        task.record_progress(robot, is_listening or is_waiting, self._p.people.is_near)
        code = ErrorCode.FAILED_TO_MAKE_PROGRESS
        if robot.tick - task.moved_tick > robot.ticks(traffic.patience):
            by = f" by {robot.names.name_of(robot.blocked_by)}" if robot.blocked_by else ""
            message = f"blocked{by} for {traffic.patience:.0f} s"
            goal_manager.fail_target(task, code, message)
        elif task.lacks_progress(robot):
            message = f"no progress after {task.recoveries} recoveries"
            goal_manager.recover_or_fail(task, code, message)


def _who_is_on_the_station(lease: Lease, robot: RobotState) -> str:
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
    lambda parts: DropUnused(parts.robot, parts.goal_manager.replan),
    MakeWay, Leave, Behave, Arrive, WaitForTurn, Drive, CheckProgress,
)  # fmt: skip
RULES: Mapping[str, Callable[[Parts], TrafficRule]] = dict(zip(RULE_NAMES, MAKERS, strict=True))
"""What makes each built-in rule, in the order in which they are asked."""


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
