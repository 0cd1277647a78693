"""The rule of a robot for which a centre decides: drive the way that it gives, stop at its end."""

from __future__ import annotations

import itertools
import math

import numpy as np

from swarm_common.model.central import Coordination, RobotReport, places_seen
from swarm_common.model.records import FloatArray
from swarm_nav.behaviour.parts import Parts
from swarm_nav.behaviour.rules import Arrive
from swarm_nav.core.states import State
from swarm_nav.interfaces import Proposal, RuleEvent, RuleEventKind
from swarm_nav.planning.planner import SPACING
from swarm_nav.traffic.arbiter import GO_ON, STAND, planned
from swarm_nav.traffic.command import Command, Point
from swarm_nav.traffic.robot_state import RobotState, RobotView

UNNAMED = 0xFFFFFFFF  # goal that has no id of its own: a charging station
SAME = 1e-9  # [m]
STUCK_TICKS = 50  # of standing, with a way to go
FAR = 0.1  # [m] of it, at least
LED = Proposal(events=(RuleEvent(RuleEventKind.LED),), is_final=False)
LED_ON_WAY = Proposal(events=(*LED.events, RuleEvent(RuleEventKind.UNLED)), is_final=False)
NOTHING: tuple[int, Point] = 0, (math.nan, math.nan)


class LeaveOwnRules:
    """Gives up waiting, making way and recovering while a centre decides, and a target without way.

    The rule stands right above `FollowCentre`, which sees what it has changed.
    """

    def __init__(self, parts: Parts, command: Command) -> None:
        self._p, self._command = parts, command

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return the events; None where the robot's own rules decide."""
        if not robot.is_led:
            return None
        p, manager = self._p, self._p.goal_manager
        p.right.stay(robot)
        p.departure.propose(robot, False)
        is_on_way = self._command.is_joined and not manager.is_pausing
        return LED_ON_WAY if is_on_way and manager.task is not None else LED


class FollowCentre:
    """Stands above the robot's own rules as long as the centre's word counts.

    What the robot holds, and how it takes more, stays as it is: so does the proof of safety.
    """

    def __init__(self, parts: Parts) -> None:
        traffic = parts.robot.config.traffic
        is_alone = traffic.coordination == Coordination.CENTRAL
        silence = None if is_alone else parts.robot.ticks(traffic.centre_silence)
        self.command = Command(silence)
        self._p = parts
        self._arrive = Arrive(parts)
        self._placed = NOTHING  # end of the path that was given, and its index

    def update(self, robot: RobotState) -> None:
        """Record whether the centre decides in this tick, and how long the robot has stood then."""
        manager = self._p.goal_manager
        is_busy = self._p.state_machine.state is State.BEHAVING
        was_led, robot.is_led = robot.is_led, self.command.counts(robot.tick) and not is_busy
        if was_led and not robot.is_led:
            manager.replan()
        waits = robot.is_standing and manager.task is not None and not manager.is_pausing
        stands = robot.is_led and waits and not robot.blocked_ticks
        robot.led_standing = robot.led_standing + 1 if stands else 0

    def propose(self, robot: RobotView) -> Proposal | None:
        """Return the proposal of the centre; None where the robot's own rules decide."""
        command, manager = self.command, self._p.goal_manager
        if not robot.is_led:
            return None
        if not command.is_joined:
            self._placed = NOTHING
            if robot.is_standing:
                command.join()
            return Proposal(keep_ahead=robot.brake_points, drops_path=True, stands=True)
        if manager.is_pausing:
            return STAND
        return self._arrive.propose(robot) or self._begin_anew(robot) or self._drive(robot)

    def report(self, robot: RobotView) -> RobotReport:
        """Return the robot's report to the centre."""
        manager = self._p.goal_manager
        task, command = manager.task, self.command
        is_busy = manager.is_pausing or self._p.state_machine.state is State.BEHAVING
        return RobotReport(
            robot_id=robot.robot_id,
            tick=robot.tick,
            pose_map=robot.pose,
            passed=command.passed,
            heard=command.heard,
            goal_id=0 if task is None else task.goal.goal_id or UNNAMED,
            goal_map=(math.nan, math.nan) if task is None else task.place,
            has_arrived=is_busy or (task is not None and task.has_arrived),
            seen_map=places_seen(robot.obstacle_points(), robot.pose),
        )

    def _begin_anew(self, robot: RobotView) -> Proposal | None:
        """Let a robot go that stands beside its path: a short way and back hides a bend."""
        command = self.command
        if not robot.led_standing or robot.led_standing % STUCK_TICKS or command.last == 0:
            return None
        end = command.ahead(command.passed)[-1]
        if math.dist((robot.pose.x, robot.pose.y), end) < FAR:
            return None
        self._placed = NOTHING
        return Proposal(keep_ahead=0, drops_path=True, holds_place=True, stands=True)

    def _drive(self, robot: RobotView) -> Proposal:
        """Let the path go on as far as the centre lets it; begin it anew where it was given up."""
        command, tube = self.command, robot.tube
        command.advance(tube.place)
        if command.last == 0:
            return STAND
        index, (x, y) = self._placed
        end = tube.points[-1]
        if index >= command.passed and math.hypot(end[0] - x, end[1] - y) < SAME:
            way = command.ahead(index)
            self._placed = command.last, way[-1]
            is_more = math.dist(way[-1], (x, y)) > SAME
            return Proposal(more=_points_on([(x, y), *way])) if is_more else GO_ON
        way = command.ahead(command.passed)
        self._placed = command.last, way[-1]
        return planned(robot, lambda start: _points_on([start, *way])) or GO_ON


def _points_on(corners: list[Point]) -> FloatArray:
    pieces = [np.array(corners[:1])]
    for start, end in itertools.pairwise(corners):
        count = max(1, round(math.dist(start, end) / SPACING))
        pieces.append(np.linspace(start, end, count + 1)[1:])
    return np.vstack(pieces)
