"""The brain of one robot: observations in, one twist and one beacon per tick out. No I/O."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from swarm_common.beacon import BeaconArray
from swarm_common.grid import Grid
from swarm_common.records import CONTROL_PERIOD, FloatArray, Odometry, Pose, RobotSpec, Scan, Twist
from swarm_common.sites import Sites
from swarm_nav import costmap as costmaps
from swarm_nav import crowd
from swarm_nav.announcement import compose_beacon, compose_status
from swarm_nav.behaviors import Behavior, recovery_goal
from swarm_nav.claim import Claim
from swarm_nav.config import NavConfig
from swarm_nav.controller import Controller
from swarm_nav.costmap import Costmap
from swarm_nav.goals import (
    ErrorCode,
    Feedback,
    Goal,
    GoalEnded,
    GoalKind,
    Outcome,
    Output,
    PlanError,
    StateChanged,
    Status,
)
from swarm_nav.holding import HoldingPattern, Lease
from swarm_nav.localisation import OdometryLocaliser
from swarm_nav.right_of_way import RightOfWay
from swarm_nav.senses import Senses
from swarm_nav.situation import begin
from swarm_nav.states import Event as E
from swarm_nav.states import State, next_state
from swarm_nav.task import Task

BEHAVIOR_KINDS = (GoalKind.SPIN, GoalKind.BACKUP, GoalKind.DRIVE_ON_HEADING, GoalKind.WAIT)
REPLAN_PAUSE = 1.2  # [s] between replans of a blocked robot; shorter ones are never granted
OBSTACLE_PATIENCE = 1.0  # [s] before another way around a sensed obstacle is looked for


class Navigator:
    """Nav2-like navigator of one robot with reservation-based traffic. See ARCHITECTURE.md."""

    def __init__(
        self,
        config: NavConfig,
        spec: RobotSpec,
        grid: Grid,
        sites: Sites,
        robot_id: int,
        initial_pose_map: Pose,
    ) -> None:
        """Build the layers; the first plan comes with the first goal."""
        self.spec = spec
        self.sites = sites
        self.is_active = True
        self._localiser = OdometryLocaliser(initial_pose_map)
        self._controller = Controller(config.controller)
        stations = [(p.x, p.y) for p in sites.stations.values()]
        self._holding = HoldingPattern(sites.circuits, stations)
        self._lease = Lease()
        self._right = RightOfWay()
        self._s = begin(config, spec, grid, robot_id, initial_pose_map)
        self._state = State.IDLE
        self._pending: Goal | None = None
        self._task: Task | None = None
        self._behavior: Behavior | None = None
        self._is_recovery = False
        self._senses = Senses(self._s)
        self._claim = Claim(self._s)
        self._last_goal_tick = 0
        self._holding_since = 0

    # --- what the robot is told ---

    @property
    def config(self) -> NavConfig:
        """The parameters in force."""
        return self._s.config

    @property
    def pose_map(self) -> Pose:
        """Estimated pose of base_footprint in map."""
        return self._localiser.pose_map

    @property
    def map_from_odom(self) -> Pose:
        """The transform map → odom."""
        return self._localiser.map_from_odom

    @property
    def goal_id(self) -> int | None:
        """Id of the goal in hand or pending, None without one."""
        if self._pending is not None:
            return self._pending.goal_id
        if self._task is not None:
            return self._task.goal.goal_id
        if self._behavior is not None and not self._is_recovery:
            return self._behavior.goal.goal_id
        return None

    def particles(self) -> FloatArray:
        """Return the localiser's hypotheses (k, 3)."""
        return self._localiser.particles()

    def on_odom(self, odom: Odometry) -> None:
        """Take the odometry of this tick."""
        self._localiser.on_odom(odom)
        self._s.twist = odom.twist
        self._s.pose = self._localiser.pose_map

    def on_scan(self, scan: Scan) -> None:
        """Take a scan."""
        self._localiser.on_scan(scan)
        self._senses.on_scan(scan)

    def on_neighbors(self, beacons: BeaconArray) -> None:
        """Take the radio's batch of this tick, which may be empty."""
        self._senses.on_neighbors(beacons)

    def on_initial_pose(self, pose_map: Pose) -> None:
        """Take a pose from the operator; claims made at the old one are dropped."""
        self._localiser.initialise(pose_map)
        self._s.pose = self._localiser.pose_map
        self._s.tube.reset(self._s.pose)

    def load_map(self, grid: Grid) -> None:
        """Take another map."""
        self._s.load_map(grid)

    def reconfigure(self, config: NavConfig) -> None:
        """Take new parameters, effective from the next tick."""
        self._controller.configure(config.controller)
        self._s.configure(config)

    def activate(self) -> None:
        """Start to navigate; listens first."""
        if not self.is_active:
            self.is_active = True
            self._s.listening_since = self._s.tick
            self._s.tube.reset(self._s.pose)

    def deactivate(self) -> None:
        """Stop, end the goal in hand, and hold the place."""
        self.cancel_goal()
        self.is_active = False

    def clear_costmap(self) -> None:
        """Forget what the LiDAR saw."""
        self._s.obstacles.clear()

    def set_goal(self, goal: Goal) -> None:
        """Take a goal; the one in hand ends as canceled (preempted)."""
        self._end_goal(Outcome.CANCELED, message="preempted by a new goal")
        self._pending = goal

    def cancel_goal(self) -> None:
        """End the goal in hand, if any."""
        self._end_goal(Outcome.CANCELED, message="canceled")

    # --- one tick ---

    def tick(self, tick: int) -> Output:
        """Decide; call once per control tick after the observations of that tick."""
        s = self._s
        if s.tick == 0 and tick > 1:
            s.listening_since = tick  # a navigator that joins late listens first
        s.tick = tick
        s.hood.refresh(tick)
        self._begin_pending()
        self._lease.update(s)
        if self._senses.update() and self.is_active:
            twist = self._drive()
        else:
            self._claim.retract()
            twist = self._controller.stop(s.twist)
        events, s.events = tuple(s.events), []
        beacon = compose_beacon(
            s, self.spec, self._state, self._right, self._lease, self._holding,
            self._last_goal_tick, self._has_goal, self.is_active,
        )  # fmt: skip
        self._claim.note_published(beacon)
        if self._state is State.HOLDING:
            s.counters.hold_ticks += 1
        return Output(twist, beacon, events)

    def _drive(self) -> Twist:
        """Choose the twist inside the held space, then let that space grow."""
        self._claim.guard()
        if self._claim.drop_if_unused() and self._task is not None:
            self._task.is_planned = False
        self._follow_yielding(self._right.update(self._s))
        twist = self._act()
        self._claim.extend()
        return twist

    @property
    def _has_goal(self) -> bool:
        return self._task is not None or (self._behavior is not None and not self._is_recovery)

    def _switch(self, event: E) -> None:
        new = next_state(self._state, event)
        if new is not self._state:
            if self._state is State.HOLDING:
                self._holding.leave()
                if event is not E.PUSHED:  # that one brought a path of its own
                    self._s.tube.cut()
            if new is State.HOLDING:
                self._holding_since = self._s.tick
                self._holding.enter(self._s)
            self._state = new
            self._s.events.append(StateChanged(new.value, self._s.tick))

    # --- goals ---

    def _begin_pending(self) -> None:
        goal = self._pending
        if goal is None or goal.start_tick > self._s.tick:
            return
        self._pending = None
        if goal.kind in BEHAVIOR_KINDS:
            self._behavior = Behavior(goal, self._s)
            self._is_recovery = False
            self._switch(E.BEHAVIOR)
            return
        if not goal.poses_map and len(goal.path_map) == 0:
            self._task = Task(goal, self._s)
            self._end_goal(Outcome.ABORTED, ErrorCode.NO_WAYPOINTS_GIVEN, "no poses given")
            return
        self._task = Task(goal, self._s)
        self._aim()
        self._switch(E.GOAL)

    def _aim(self) -> None:
        """Point the lease at the present target."""
        task = self._task
        self._s.tube.cut()
        if task is None or task.goal.kind is GoalKind.FOLLOW_PATH or task.is_passing:
            self._lease.aim(None)
        else:
            self._lease.aim((task.target.x, task.target.y))

    def _end_goal(
        self, outcome: Outcome, code: ErrorCode = ErrorCode.NONE, message: str = ""
    ) -> None:
        s = self._s
        goal_id = self.goal_id
        if goal_id is None:
            return
        missed = tuple(self._task.missed) if self._task is not None else ()
        was_navigation = self._task is not None
        self._pending = self._task = None
        self._behavior = None
        self._is_recovery = False
        if was_navigation:
            if outcome is Outcome.SUCCEEDED:
                s.counters.goals_reached += 1
                self._last_goal_tick = s.tick
            elif outcome is Outcome.ABORTED:
                s.counters.goals_failed += 1
        self._lease.aim(None)
        if not self._right.is_yielding:
            s.tube.release_ahead(s.brake_points)
            s.tube.cut()
        self._s.events.append(GoalEnded(goal_id, outcome, s.tick, code, message, missed))
        self._switch(E.FINISHED)

    def _target_reached(self) -> None:
        task = self._task
        assert task is not None
        if task.next_target(self._s.tick):
            self._last_goal_tick = self._s.tick
            self._aim()
        else:
            self._end_goal(Outcome.SUCCEEDED)

    def _target_failed(self, code: ErrorCode, message: str) -> None:
        task = self._task
        assert task is not None
        if task.goal.kind is GoalKind.WAYPOINTS:
            task.missed.append(task.index)
            if task.next_target(self._s.tick):
                self._aim()
                return
            self._end_goal(Outcome.SUCCEEDED)
            return
        self._end_goal(Outcome.ABORTED, code, message)

    # --- states ---

    def _follow_yielding(self, is_yielding: bool) -> None:
        if is_yielding and self._task is not None:
            self._task.note_progress(self._s, True)
        if is_yielding and self._state is not State.YIELDING:
            self._switch(E.PUSHED)
        elif not is_yielding and self._state is State.YIELDING:
            self._resume()

    def _resume(self) -> None:
        if self._task is not None:
            self._switch(E.RELEASED)
        else:
            self._switch(E.RELEASED_IDLE)
            if self._behavior is not None and not self._is_recovery:
                self._behavior.resume(self._s)
                self._switch(E.BEHAVIOR)
        if self._is_recovery:
            self._behavior = None
            self._is_recovery = False

    def _act(self) -> Twist:
        """Let the state choose path and twist."""
        if self._state is State.BEHAVING or self._state is State.RECOVERING:
            return self._behave()
        if self._state is State.DRIVING:
            twist = self._navigate()
            if twist is not None:
                return twist
        elif self._state is State.HOLDING:
            self._hold()
        return self._controller.follow(self._s.tube, self._s.pose, self._s.twist)

    def _behave(self) -> Twist:
        behavior = self._behavior
        if behavior is None:
            self._switch(E.RECOVERED if self._state is State.RECOVERING else E.FINISHED)
            return self._controller.stop(self._s.twist)
        twist = behavior.step(self._s, self._controller)
        end = behavior.end
        if end is not None:
            if self._is_recovery:
                self._behavior = None
                self._is_recovery = False
                self._s.tube.cut()
                self._switch(E.RECOVERED)
            elif end.code is ErrorCode.NONE:
                self._end_goal(Outcome.SUCCEEDED)
            else:
                self._end_goal(Outcome.ABORTED, end.code, end.message)
        return twist

    def _navigate(self) -> Twist | None:
        """Return a twist that overrides following the tube, if any."""
        s, task = self._s, self._task
        assert task is not None
        is_reached = task.is_reached(s)
        if is_reached:
            self._target_reached()
            return self._controller.stop(s.twist) if self._task is None else None
        if task.has_arrived:
            return self._settle(task)
        config = s.config.holding
        if not self._lease.is_turn(config) and self._lease.station is not None:
            if s.distance_to(*self._lease.station) <= config.hold_distance:
                self._switch(E.STATION_TAKEN)
                return None
        if self._is_station_dead(task):
            self._target_failed(
                ErrorCode.GOAL_OCCUPIED, "a robot that no longer answers stands on the station"
            )
            return None
        self._plan_if_due(task)
        if self._task is task:
            self._check_progress(task)
        return None

    def _settle(self, task: Task) -> Twist:
        """Stop within the tolerance and turn to the goal's heading."""
        s = self._s
        s.tube.release_ahead(s.brake_points)
        s.tube.cut()
        if abs(s.twist.vx) < 0.02:
            s.tube.reset(s.pose)
            if not math.isnan(task.target.yaw):
                return self._controller.turn_to(task.target.yaw, s.pose, s.twist)
        return self._controller.stop(s.twist)

    def _hold(self) -> None:
        s = self._s
        assert self._task is not None
        self._task.note_progress(s, True)
        if self._lease.is_turn(s.config.holding):
            self._switch(E.STATION_GRANTED)
            return
        if self._is_station_dead(self._task):
            self._switch(E.STATION_GRANTED)
            return
        self._holding.update(s)

    def _is_station_dead(self, task: Task) -> bool:
        """Whether a silent robot has stood on the target for longer than the patience."""
        s = self._s
        if task.is_passing or self._lease.tick == 0:
            return False
        patience = s.ticks(s.config.holding.station_patience)
        for row in np.flatnonzero(s.hood.gone):
            gaps = s.hood.tubes(int(row)) - (task.target.x, task.target.y)
            if float(np.hypot(*gaps.T).min()) < s.reach(int(row)) - 0.25:
                return s.tick - self._lease.tick > patience
        return False

    def _plan_if_due(self, task: Task) -> None:
        s = self._s
        since = s.tick - s.last_plan_tick
        traffic = s.config.traffic
        if task.given is not None:
            task.given.advance(s.pose.x, s.pose.y)
        gap = math.dist(s.stop_point, task.place)
        at_end = s.tube.is_complete and gap > 0.6 * s.config.goal_checker.xy_goal_tolerance
        pause = s.ticks(REPLAN_PAUSE)
        is_blocked = (
            s.blocked_ticks >= s.ticks(traffic.replan_blocked)
            or s.obstacle_ticks >= s.ticks(OBSTACLE_PATIENCE)
        ) and since >= pause
        period = s.ticks(s.config.planner.replan_period)
        is_periodic = (
            task.given is None and since >= period and (s.tick + 7 * s.robot_id) % period == 0
        )
        if task.is_planned and not is_blocked and not is_periodic:
            if not at_end or since < pause:
                return
        self._plan(task)

    def _plan(self, task: Task) -> None:
        s = self._s
        s.last_plan_tick = s.tick
        try:
            path = self._path_to(task)
            if self._turns_back(path):
                s.tube.release_ahead(s.brake_points if s.twist.vx > 0.05 else 0)
                path = self._path_to(task)
        except PlanError as error:
            task.is_planned = True
            fatal = (
                ErrorCode.GOAL_OCCUPIED, ErrorCode.GOAL_OUTSIDE_MAP, ErrorCode.NO_VALID_CONTROL,
            )  # fmt: skip
            if error.code in fatal or task.recoveries >= self._retries:
                self._target_failed(error.code, str(error))
            else:
                self._recover(task)
            return
        s.counters.replans += task.is_planned
        task.note_plan(path)
        if len(path) >= 2:
            s.tube.adopt(path)

    def _turns_back(self, path: FloatArray) -> bool:
        """Whether a plan from the stop point leads back along space that is still held."""
        tube = self._s.tube
        if tube.stop - tube.near <= self._s.brake_points or len(path) < 3:
            return False
        arriving = tube.points[tube.stop] - tube.points[tube.stop - 2]
        return float(arriving @ (path[2] - path[0])) < 0.0

    def _path_to(self, task: Task) -> FloatArray:
        s = self._s
        if task.given is not None:
            return task.given.way(s)
        return s.planner.plan(s.stop_point, (task.target.x, task.target.y), crowd.congestion(s))

    @property
    def _retries(self) -> int:
        return self._s.config.progress_checker.number_of_retries

    def _check_progress(self, task: Task) -> None:
        s = self._s
        is_excused = s.blocked_ticks > 0 or s.tick - self._s.listening_since < 2 * (
            s.config.traffic.listen_ticks
        )
        task.note_progress(s, is_excused)
        if s.tick - task.moved_tick > s.ticks(s.config.traffic.patience):
            self._target_failed(
                ErrorCode.FAILED_TO_MAKE_PROGRESS,
                f"blocked by Srobot{s.blocked_by} for {s.config.traffic.patience:.0f} s",
            )
        elif task.lacks_progress(s):
            if task.recoveries >= self._retries:
                self._target_failed(
                    ErrorCode.FAILED_TO_MAKE_PROGRESS,
                    f"no progress after {task.recoveries} recoveries",
                )
            else:
                self._recover(task)

    def _recover(self, task: Task) -> None:
        s = self._s
        goal = recovery_goal(task.recoveries, s)
        task.recoveries += 1
        s.counters.recoveries += 1
        task.progress_tick = s.tick
        s.obstacles.clear()
        s.tube.cut()
        task.is_planned = goal is not None
        self._is_recovery = goal is not None
        self._behavior = Behavior(goal, s) if goal is not None else None
        self._switch(E.NO_PROGRESS)

    # --- what the robot tells ---

    def make_plan(self, start: Pose | None, goals: Sequence[Pose]) -> FloatArray:
        """Return a path (n, 2) through the goals from `start` (None: the robot's pose).

        Raises:
            PlanError: With Nav2's code, if there is none.
        """
        s = self._s
        here = start or s.pose
        pieces: list[FloatArray] = []
        point = (here.x, here.y)
        for goal in goals:
            path = s.planner.plan(point, (goal.x, goal.y), s.planner.no_extra())
            pieces.append(path if not pieces else path[1:])
            point = (goal.x, goal.y)
        return np.vstack(pieces) if pieces else np.zeros((0, 2))

    def plan_map(self) -> FloatArray:
        """Return the path ahead (n, 2) in map."""
        return self._s.tube.points[self._s.tube.near :].copy()

    def local_plan_map(self) -> FloatArray:
        """Return the controller's predicted positions (m, 2) in map."""
        return self._controller.arc[:, :2].copy()

    def global_costmap(self) -> Costmap:
        """Return the costmap of the whole map."""
        return costmaps.compose(self._s, self.spec.inscribed_radius, None)

    def local_costmap(self) -> Costmap:
        """Return the rolling costmap around the robot."""
        size = self._s.config.costmap.local_size
        return costmaps.compose(self._s, self.spec.inscribed_radius, size)

    def distance_remaining(self) -> float:
        """Return the path length [m] to the goal in hand, 0 without one."""
        return 0.0 if self._task is None else self._task.distance_remaining(self._s)

    def feedback(self) -> Feedback | None:
        """Return the progress of the goal in hand, None without one."""
        s, task, behavior = self._s, self._task, self._behavior
        if task is None and (behavior is None or self._is_recovery):
            return None
        rest = self.distance_remaining()
        navigation = (s.tick - task.start_tick) * CONTROL_PERIOD if task is not None else 0.0
        traveled, angle = 0.0, 0.0
        if task is None and behavior is not None:
            traveled, angle = behavior.distance_traveled(s), behavior.angle_traveled
        return Feedback(
            goal_id=self.goal_id or 0,
            pose_map=s.pose,
            navigation_time=navigation,
            estimated_time_remaining=rest / s.config.controller.max_vel_x,
            number_of_recoveries=task.recoveries if task is not None else 0,
            distance_remaining=rest,
            poses_remaining=task.poses_remaining if task is not None else 0,
            current_waypoint=task.index if task is not None else 0,
            distance_traveled=traveled,
            angle_traveled=angle,
            speed=s.twist.vx,
        )

    def status(self) -> Status:
        """Return the state for the operator."""
        target = self._task.target if self._task is not None else None
        return compose_status(
            self._s, self.is_active, self._state, target, self._lease, self.sites,
            self._holding, self._holding_since, self.distance_remaining(),
        )  # fmt: skip
