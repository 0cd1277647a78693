"""What the robot does in each state: which path it follows, and which twist overrides that."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import CONTROL_PERIOD, Twist
from swarm_nav.behaviour.goal_manager import GoalManager
from swarm_nav.behaviour.goal_progress import GoalProgress
from swarm_nav.behaviour.route import Route
from swarm_nav.behaviour.state_machine import StateMachine
from swarm_nav.control.controller import Controller
from swarm_nav.core.goals import ErrorCode, Outcome, PlanError
from swarm_nav.core.states import Event, State
from swarm_nav.traffic.gate import Gate
from swarm_nav.traffic.holding import HoldingPattern
from swarm_nav.traffic.lease import QUEUE_STEP, Lease
from swarm_nav.traffic.robot_state import RobotState


class BehaviorExecutor:
    """Lets the state choose path and twist, and notices when the state is over."""

    def __init__(
        self,
        robot: RobotState,
        state_machine: StateMachine,
        goal_manager: GoalManager,
        lease: Lease,
        gate: Gate,
        holding: HoldingPattern,
        controller: Controller,
    ) -> None:
        """Connect the parts that a state acts on.

        Args:
            state_machine: Its state, which is switched when it is over.
            lease: Its turn at the station that it drives to.
            gate: Its admission to the narrow region ahead.
        """
        self._s = robot
        self._state_machine = state_machine
        self._goal_manager = goal_manager
        self._route = Route(robot, goal_manager)
        self._lease = lease
        self._gate = gate
        self._holding = holding
        self._controller = controller
        self._held_place = 0  # in the queue when the robot began to wait

    def choose_path(self, is_person_near: bool) -> Twist | None:
        """Let the state choose the path to follow, or a twist that overrides following it.

        Args:
            is_person_near: Whether the robot had to be slow for a person in the last tick.

        Returns:
            That twist, None if the path is followed.
        """
        state, task = self._state_machine.state, self._goal_manager.task
        if state in (State.BEHAVING, State.RECOVERING):
            return self._behave()
        if state is State.DRIVING:
            assert task is not None
            return self._navigate(task, is_person_near)
        if state is State.HOLDING:
            assert task is not None
            self._hold(task)
        return None

    def follow_path(self) -> Twist:
        """Return the twist along the path: backwards to make way or without room to turn."""
        s = self._s
        may_back = self._state_machine.state is State.YIELDING or s.is_confined
        if not self._controller.choose_direction(s.tube, s.pose, s.twist, may_back):
            return self._controller.stop(s.twist)
        return self._controller.follow(s.tube, s.pose, s.twist)

    def stand(self) -> None:
        """Note that the robot may not drive, so that this does not count as lack of progress."""
        task = self._goal_manager.task
        if task is not None:
            task.record_progress(self._s, True)

    def _behave(self) -> Twist:
        goal_manager = self._goal_manager
        behavior = goal_manager.behavior
        if behavior is None:
            is_recovering = self._state_machine.state is State.RECOVERING
            self._state_machine.switch(Event.RECOVERED if is_recovering else Event.FINISHED)
            return self._controller.stop(self._s.twist)
        twist = behavior.step(self._s, self._controller)
        end = behavior.end
        if end is None:
            return twist
        if goal_manager.is_recovery:
            goal_manager.drop_recovery()
            self._s.tube.cut()
            self._state_machine.switch(Event.RECOVERED)
        elif end.code is ErrorCode.NONE:
            goal_manager.end(Outcome.SUCCEEDED)
        else:
            goal_manager.end(Outcome.ABORTED, end.code, end.message)
        return twist

    def _navigate(self, task: GoalProgress, is_person_near: bool) -> Twist | None:
        """Return a twist that overrides following the tube, if any."""
        s = self._s
        if task.is_reached(s):
            self._goal_manager.reach_target(task)
            return None if self._goal_manager.task is task else self._controller.stop(s.twist)
        if task.has_arrived:
            return self._settle(task)
        if self._gate.is_closed:
            self._held_place = self._lease.place
            self._state_machine.switch(Event.STATION_TAKEN)
            return None
        is_barred = self._lease.is_barred(s)
        has_to_wait = self._lease.station is not None and not is_barred and not self._has_turn()
        if has_to_wait and self._lease.is_too_near(s):
            self._held_place = self._lease.place
            self._state_machine.switch(Event.STATION_TAKEN)
            return None
        if is_barred:
            message = self._who_is_on_the_station()
            self._goal_manager.fail_target(task, ErrorCode.GOAL_OCCUPIED, message)
            return None
        self._route.update(task)
        if self._goal_manager.task is task:
            self._check_progress(task, is_person_near)
        return None

    def _who_is_on_the_station(self) -> str:
        """Say what is known of what bars the station, and no more."""
        s = self._s
        row = self._lease.covering(s)
        if row is None:
            return "something that does not move stands on the station"
        robot = s.names.name_of(int(s.neighbors.ids[row]))
        if not s.neighbors.gone[row]:
            return f"{robot} stands on the station and its navigator is inactive"
        silence = s.neighbors.ages[row] * CONTROL_PERIOD
        return f"{robot} has not been heard for {silence:.0f} s and may still be on the station"

    def _settle(self, task: GoalProgress) -> Twist:
        """Stop within the tolerance and turn to the goal's heading."""
        s = self._s
        s.release_ahead(s.brake_points)
        s.tube.cut()
        if abs(s.twist.vx) < 0.02:
            s.tube.shrink_to_place(s.pose)
            if not math.isnan(task.target.yaw):
                return self._controller.turn_to(task.target.yaw, s.pose, s.twist)
        return self._controller.stop(s.twist)

    def _hold(self, task: GoalProgress) -> None:
        s = self._s
        task.record_holding(s)
        period = s.ticks(s.config.traffic.stuck_time)
        if self._gate.is_closed and (s.tick + s.robot_id) % period == 0:
            self._recheck_gate(task)
        has_turn = self._has_turn() or self._lease.is_barred(s) or self._moves_up()
        if has_turn and not self._gate.is_closed:
            self._state_machine.switch(Event.STATION_GRANTED)
        else:
            self._holding.update(s, self._kept_free)

    def _kept_free(self) -> NDArray[np.bool_] | None:
        """Return the lattice cells (h, w) where a robot that waits must not park."""
        region = self._gate.region if self._gate.is_closed else None
        return self._lease.kept_free(self._s) if region is None else region > 0

    def _moves_up(self) -> bool:
        """Whether the queue is much shorter now: the robot may wait nearer to the station."""
        if 2 * self._lease.place > self._held_place:
            return False
        return not self._lease.is_too_near(self._s, QUEUE_STEP)

    def _recheck_gate(self, task: GoalProgress) -> None:
        s = self._s
        try:
            way = s.planner.plan(s.stop_point, task.place, s.planner.no_extra())
        except PlanError:
            return
        self._gate.recheck(s, way)

    def _has_turn(self) -> bool:
        """Whether the robot may approach its station, and nobody stands on it for good."""
        return self._lease.is_turn(self._s.config.holding) and not self._lease.is_covered(self._s)

    def _check_progress(self, task: GoalProgress, is_person_near: bool) -> None:
        s = self._s
        traffic = s.config.traffic
        is_listening = s.tick - s.listening_since < 2 * traffic.listen_ticks
        is_waiting = s.blocked_ticks > 0 or s.is_unconfirmed
        task.record_progress(s, is_listening or is_waiting, is_person_near)
        code = ErrorCode.FAILED_TO_MAKE_PROGRESS
        if s.tick - task.moved_tick > s.ticks(traffic.patience):
            by = f" by {s.names.name_of(s.blocked_by)}" if s.blocked_by else ""
            message = f"blocked{by} for {traffic.patience:.0f} s"
            self._goal_manager.fail_target(task, code, message)
        elif task.lacks_progress(s):
            message = f"no progress after {task.recoveries} recoveries"
            self._goal_manager.recover_or_fail(task, code, message)
