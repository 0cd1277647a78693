"""The pursuit of goals: begins them, goes from target to target, recovers, and ends them."""

from __future__ import annotations

from swarm_common.model.records import Pose
from swarm_nav.behaviour.behaviors import Behavior, recovery_goal
from swarm_nav.behaviour.charging import FAILED_TIME, ChargingTrip
from swarm_nav.behaviour.goal_progress import GoalProgress
from swarm_nav.behaviour.state_machine import StateMachine
from swarm_nav.core.goals import NO_POSES_CODES, ErrorCode, Goal, GoalEnded, GoalKind, Outcome
from swarm_nav.core.states import Event, State
from swarm_nav.interfaces import RuleEvent, RuleEventKind
from swarm_nav.traffic.arbiter import Arbiter
from swarm_nav.traffic.lease import Lease
from swarm_nav.traffic.right_of_way import RightOfWay
from swarm_nav.traffic.robot_state import RobotState

Kind = RuleEventKind
BEHAVIOR_KINDS = (
    GoalKind.SPIN, GoalKind.BACKUP, GoalKind.DRIVE_ON_HEADING, GoalKind.WAIT, GoalKind.TELEOP
)  # fmt: skip


class GoalManager:
    """The current or pending goal, at most one.

    Attributes:
        task: Progress of the current navigation goal, or of a trip to a charging station.
        behavior: The current behaviour, asked for or (`is_recovery`) in aid of the task.
        last_goal_tick: Tick at which the last target was reached.
        failure: Why the goal before was given up; empty if it was not.
    """

    def __init__(
        self,
        robot: RobotState,
        state_machine: StateMachine,
        lease: Lease,
        right: RightOfWay,
        arbiter: Arbiter,
        trip: ChargingTrip | None = None,
    ) -> None:
        """Start without a goal.

        Args:
            state_machine: Its state, which is switched as goals begin and end.
            lease: Its turn at stations; it is aimed at the present target.
            right: Tells whether it makes way; then its path outlives the goal.
            arbiter: Drops the path of a goal that is over.
            trip: When and where it charges; None for a robot without a battery.
        """
        self._arbiter = arbiter
        self._trip = trip
        self._put_off: GoalProgress | None = None  # goal that waits until the robot is charged
        self._s = robot
        self._state_machine = state_machine
        self._lease = lease
        self._right = right
        self._pending: Goal | None = None
        self.task: GoalProgress | None = None
        self.behavior: Behavior | None = None
        self.is_recovery = False
        self.last_goal_tick = 0
        self._reached_at: Pose | None = None  # where the goal before was reached, if it was
        self.failure = ""  # why the goal before was given up, if it was

    @property
    def has_goal(self) -> bool:
        """Whether there is a current goal; a pending one does not count yet."""
        return self.task is not None or (self.behavior is not None and not self.is_recovery)

    @property
    def is_on_trip(self) -> bool:
        """Whether the robot goes to charge, or is charged."""
        return self._trip is not None and self._trip.charger is not None

    @property
    def asked(self) -> GoalProgress | None:
        """The current navigation goal, also while the robot puts it off to charge."""
        return self._put_off if self.is_on_trip else self.task

    @property
    def goal_id(self) -> int | None:
        """Id of the current or pending goal, None without one."""
        if self._pending is not None:
            return self._pending.goal_id
        if self.asked is not None:
            return self.asked.goal.goal_id
        if self.behavior is not None and not self.is_recovery:
            return self.behavior.goal.goal_id
        return None

    @property
    def is_pausing(self) -> bool:
        """Whether the robot is served where it was sent, until the next goal takes effect.

        It stays there: it does not make way meanwhile, and keeps its turn at the station. So does
        a robot that is charged.
        """
        if self._trip is not None and self._trip.is_plugged:
            return True
        goal, place, s = self._pending, self._reached_at, self._s
        if goal is None or place is None or goal.start_tick <= s.tick + 1:
            return False
        return s.pose.distance(place) <= s.config.goal_checker.xy_goal_tolerance

    def set_goal(self, goal: Goal) -> None:
        """Accept a goal for its start tick; the current one ends as canceled (preempted).

        Args:
            goal: With the tick from which it counts.
        """
        self.end(Outcome.CANCELED, message="preempted by a new goal")
        self._pending = goal
        if self.is_pausing:
            self._lease.keep(self._s)

    def begin_pending(self) -> None:
        """Begin the pending goal when it is due."""
        goal = self._pending
        if goal is None or goal.start_tick > self._s.tick:
            return
        self._pending = None
        if goal.kind in BEHAVIOR_KINDS:
            if self.is_on_trip:  # an operator takes over; a battery that is low sets off anew
                self._end_trip()
            self.behavior = Behavior(goal, self._s)
            self.is_recovery = False
            self._state_machine.switch(Event.BEHAVIOR)
            return
        task = GoalProgress(goal, self._s)
        if self.is_on_trip:
            self._put_off = task
        else:
            self.task = task
        if not goal.poses_map and len(goal.path_map) == 0:
            code = NO_POSES_CODES.get(goal.kind, ErrorCode.PLAN_UNKNOWN)
            self.end(Outcome.ABORTED, code, "no poses given")
        elif not self.is_on_trip:
            self._aim(task)
            self._state_machine.switch(Event.GOAL)

    def end(self, outcome: Outcome, code: ErrorCode = ErrorCode.NONE, message: str = "") -> None:
        """End the current or pending goal, if any.

        Args:
            code: Nav2's error code.
        """
        s, task, goal_id = self._s, self.asked, self.goal_id
        if goal_id is None:
            return
        self._pending = None
        if task is not None:
            self._count(outcome)
        has_failed = task is not None and outcome is Outcome.ABORTED
        self.failure = f"error {code.value}: {message}" if has_failed else ""
        if self.is_on_trip:
            self._put_off = None
        else:
            self.task = self.behavior = None
            self.is_recovery = False
            has_reached = task is not None and outcome is Outcome.SUCCEEDED
            self._reached_at = s.pose if has_reached else None
            self._lease.aim(self._s, None)
            self._stop_short()
        missed = tuple(task.missed) if task is not None else ()
        self._state_machine.events.append(
            GoalEnded(goal_id, outcome, s.tick, code, message, missed)
        )
        if not self.is_on_trip:
            self._state_machine.switch(Event.FINISHED)

    def _stop_short(self) -> None:
        if not self._right.is_yielding:
            self._arbiter.stop_short()

    def update_charging(self) -> None:
        """Put the goal off for a trip to charge when it is due, and go on with it afterwards."""
        trip, s = self._trip, self._s
        if trip is None:
            return
        if trip.charger is None:
            is_busy = self.is_pausing or (self.behavior is not None and not self.is_recovery)
            charger = None if is_busy else trip.choice(s)
        elif trip.is_plugged:
            charger = None
            if trip.is_charged(s):
                self._end_trip()
            elif trip.lacks_current(s):
                trip.fail(s.tick, s.ticks(FAILED_TIME))
                self._end_trip()
        else:
            charger = trip.better(s, self._lease)
        if charger is not None:
            self._go_to_charge(trip, charger)

    def _go_to_charge(self, trip: ChargingTrip, charger: Pose) -> None:
        """Set off for a charging station, or turn to another one."""
        if not self.is_on_trip:
            self._put_off = self.task
        self._drop_recovery()
        self._stop_short()
        trip.begin(charger)
        self.task = GoalProgress(Goal(kind=GoalKind.NAVIGATE, poses_map=(charger,)), self._s)
        self._aim(self.task)
        self._state_machine.switch(Event.GOAL)

    def _plug_in(self, trip: ChargingTrip) -> None:
        """Stay at the charging station, which the lease keeps for the robot."""
        self.task = None
        self._lease.aim(self._s, None)
        self._lease.keep(self._s)
        self._stop_short()
        trip.plugged_tick = self._s.tick
        self._state_machine.switch(Event.FINISHED)

    def _end_trip(self) -> None:
        """Give the charging station back and go on with the goal that was put off, if any."""
        assert self._trip is not None
        self._trip.end()
        self._reached_at = None
        self._drop_recovery()
        self.task, self._put_off = self._put_off, None
        self._stop_short()
        if self.task is None:
            self._lease.aim(self._s, None)
            self._state_machine.switch(Event.FINISHED)
        else:
            self.task.resume(self._s)
            self._aim(self.task)
            self._state_machine.switch(Event.GOAL)

    def end_all(self, message: str) -> None:
        """End the current or pending goal, and a trip to charge."""
        if self.is_on_trip:
            self._end_trip()
        self.end(Outcome.CANCELED, message=message)

    def _count(self, outcome: Outcome) -> None:
        if outcome is Outcome.SUCCEEDED:
            self._s.counters.goals_reached += 1
            self.last_goal_tick = self._s.tick
        elif outcome is Outcome.ABORTED:
            self._s.counters.goals_failed += 1

    def _aim(self, task: GoalProgress) -> None:
        self._arbiter.drop_path()
        if task.goal.kind is GoalKind.FOLLOW_PATH or task.is_passing:
            self._lease.aim(self._s, None)
        else:
            self._lease.aim(self._s, (task.target.x, task.target.y))

    def _reach_target(self, task: GoalProgress) -> None:
        """Go on to the next target, or end the goal as succeeded."""
        if self._trip is not None and self.is_on_trip:
            self._plug_in(self._trip)
        elif task.has_next:
            task.next_target(self._s.tick)
            self.last_goal_tick = self._s.tick
            self._aim(task)
        else:
            self.end(Outcome.SUCCEEDED)

    def fail_target(self, task: GoalProgress, code: ErrorCode, message: str) -> None:
        """Leave out a waypoint, or end any other goal as aborted.

        Args:
            code: Nav2's error code.
        """
        if self._trip is not None and self.is_on_trip:
            if code is ErrorCode.FAILED_TO_MAKE_PROGRESS and self._lease.place:
                task.resume(self._s)  # others are charged first, however long that takes
            else:
                self._trip.fail(self._s.tick, self._s.ticks(FAILED_TIME))
                self._end_trip()
            return
        if task.goal.kind is not GoalKind.WAYPOINTS:
            self.end(Outcome.ABORTED, code, message)
            return
        task.missed.append((task.index, code))
        if task.has_next:
            task.next_target(self._s.tick)
            self._aim(task)
        else:
            self.end(Outcome.SUCCEEDED)

    def _recover_or_fail(self, task: GoalProgress, code: ErrorCode, message: str) -> None:
        """Start the next recovery, or give the target up when all are spent.

        Args:
            code: Nav2's error code if it is given up.
        """
        s = self._s
        if task.recoveries >= s.config.progress_checker.number_of_retries:
            self.fail_target(task, code, message)
            return
        goal = recovery_goal(task.recoveries, s)
        task.recoveries += 1
        s.counters.recoveries += 1
        task.progress_tick = s.tick
        s.obstacles.clear()
        self._arbiter.drop_path()
        task.is_planned = goal is not None
        self.is_recovery = goal is not None
        self.behavior = Behavior(goal, s) if goal is not None else None
        self._state_machine.switch(Event.NO_PROGRESS)

    def _drop_recovery(self) -> None:
        """Forget the current recovery, if any."""
        if self.is_recovery:
            self.behavior = None
            self.is_recovery = False

    @property
    def is_idle(self) -> bool:
        """Whether the robot has nothing to do, not even a goal that is to begin."""
        return self.goal_id is None and not self.is_on_trip

    def excuse(self) -> None:
        """Do not expect the robot to get on in this tick."""
        if self.task is not None:
            self.task.record_progress(self._s, True)

    def _resume(self) -> None:
        """Go on with the current goal, if it was interrupted."""
        if self._state_machine.state is not State.YIELDING:
            return
        if self.task is not None:
            self._state_machine.switch(Event.RELEASED)
        else:
            self._state_machine.switch(Event.RELEASED_IDLE)
            if self.behavior is not None and not self.is_recovery:
                self.behavior.resume(self._s)
                self._state_machine.switch(Event.BEHAVIOR)
        self._drop_recovery()

    def replan(self) -> None:
        """Request a new plan to the target."""
        if self.task is not None:
            self.task.is_planned = False

    def apply(self, event: RuleEvent) -> None:
        """Change goal and state as a rule asks for: the only place that does.

        Raises:
            IllegalTransitionError: If the state has no such change.
        """
        kind, task, machine = event.kind, self.task, self._state_machine
        if kind is Kind.DRIVEN or kind is Kind.EXCUSED or kind is Kind.CAUTIOUS:
            self._check_progress(kind)
        elif kind is Kind.INTERRUPTED:
            self.excuse()
            if machine.state is not State.YIELDING:
                machine.switch(Event.PUSHED)
        elif kind is Kind.RESUMED:
            self._resume()
        elif kind is Kind.LED:
            self._resume()
            if machine.state is State.HOLDING:
                machine.switch(Event.STATION_GRANTED)
            elif machine.state is State.RECOVERING:
                self._drop_recovery()
                machine.switch(Event.RECOVERED)
        elif kind is Kind.BEHAVIOR_ENDED:
            self._end_behavior(event)
        elif kind is Kind.TURN_AWAITED:
            machine.switch(Event.STATION_TAKEN)
        elif kind is Kind.TURN_GRANTED:
            machine.switch(Event.STATION_GRANTED)
        elif task is not None:
            self._change_task(task, event)

    def _change_task(self, task: GoalProgress, event: RuleEvent) -> None:
        s, kind = self._s, event.kind
        if kind is Kind.ARRIVED or kind is Kind.STRAYED:
            task.has_arrived = kind is Kind.ARRIVED
        elif kind is Kind.REACHED:
            self._reach_target(task)
        elif kind is Kind.QUEUED:
            task.record_holding(s)
        elif kind is Kind.UNUSED:
            self.replan()
        elif kind is Kind.FOLLOWED and task.given is not None:
            task.given.advance(s.pose.x, s.pose.y)
        elif kind is Kind.PLANNED:
            s.counters.replans += task.is_planned
            task.record_plan(event.place_map)
        elif kind is Kind.NO_WAY:
            task.is_planned = True
            if event.is_final:
                self.fail_target(task, event.code, event.message)
            else:
                self._recover_or_fail(task, event.code, event.message)
        elif kind is Kind.FAILED:
            self.fail_target(task, event.code, event.message)
        elif kind is Kind.UNLED:
            task.record_progress(s, True)
            self._check_patience(task, "the centre gave no way")

    def _end_behavior(self, event: RuleEvent) -> None:
        """End a behaviour that was asked for, or go on after a recovery."""
        if self.behavior is not None and not self.is_recovery:
            is_success = event.code is ErrorCode.NONE
            outcome = Outcome.SUCCEEDED if is_success else Outcome.ABORTED
            self.end(outcome, event.code, event.message)
        elif self._state_machine.state is State.RECOVERING:
            self._drop_recovery()
            self._arbiter.drop_path()
            self._state_machine.switch(Event.RECOVERED)
        else:
            self._state_machine.switch(Event.FINISHED)

    def _check_progress(self, kind: RuleEventKind) -> None:
        """Recover, or give the target up, where the robot does not get on."""
        s, task = self._s, self.task
        if task is None:
            return
        task.record_progress(s, kind is Kind.EXCUSED, kind is Kind.CAUTIOUS)
        if not self._check_patience(task) and task.lacks_progress(s):
            message = f"no progress after {task.recoveries} recoveries"
            self._recover_or_fail(task, ErrorCode.FAILED_TO_MAKE_PROGRESS, message)

    def _check_patience(self, task: GoalProgress, why: str = "") -> bool:
        """Give a target up on which the robot has not got on for too long; return whether."""
        s, patience = self._s, self._s.config.traffic.patience
        if s.tick - task.moved_tick <= s.ticks(patience):
            return False
        by = f" by {s.names.name_of(s.blocked_by)}" if s.blocked_by else ""
        message = f"{why or f'blocked{by}'} for {patience:.0f} s"
        self.fail_target(task, ErrorCode.FAILED_TO_MAKE_PROGRESS, message)
        return True
