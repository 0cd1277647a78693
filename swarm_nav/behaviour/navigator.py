"""The brain of one robot: observations in, one twist and one beacon per tick out. No I/O."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.battery import BatteryReading
from swarm_common.model.beacon import BeaconArray, Reception
from swarm_common.model.central import RobotReport, TeamOrder
from swarm_common.model.coordination import Coordination
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Odometry, Pose, RobotSpec, Scan, Twist
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.sites import Sites
from swarm_common.model.zones import with_mask
from swarm_nav.behaviour import costmap as costmaps
from swarm_nav.behaviour.announcement import compose_beacon, compose_feedback, compose_status
from swarm_nav.behaviour.behaviors import BehaviorEnd
from swarm_nav.behaviour.charging import ChargingTrip
from swarm_nav.behaviour.costmap import Costmap
from swarm_nav.behaviour.follow_centre import FollowCentre, LeaveOwnRules
from swarm_nav.behaviour.goal_manager import GoalManager
from swarm_nav.behaviour.goal_progress import GoalProgress
from swarm_nav.behaviour.parts import Parts
from swarm_nav.behaviour.plugin_priority import PluginPriority
from swarm_nav.behaviour.rules import rules_of
from swarm_nav.behaviour.state_machine import StateMachine
from swarm_nav.control.omni import make_controller
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import ErrorCode, Feedback, Goal, GoalKind, Outcome, Output, Status
from swarm_nav.core.localisation_config import START_DEVIATION
from swarm_nav.core.plugins import PRIORITY
from swarm_nav.core.rank import CLASS_DONE, CLASS_DRIVING, CLASS_HOLDING, base_priority
from swarm_nav.core.states import State
from swarm_nav.localisation.localiser import make_localiser
from swarm_nav.planning.plugin_planner import planner_maker
from swarm_nav.traffic.arbiter import Arbiter
from swarm_nav.traffic.departure import Departure
from swarm_nav.traffic.gate import Gate, narrow_region
from swarm_nav.traffic.held_space_rules import KeepApart, StopBeforeObstacle
from swarm_nav.traffic.holding import HoldingPattern
from swarm_nav.traffic.lease import Lease
from swarm_nav.traffic.pilot import TwistPilot
from swarm_nav.traffic.right_of_way import RightOfWay
from swarm_nav.traffic.robot_state import initial_state
from swarm_nav.traffic.senses import Senses
from swarm_nav.traffic.single_lanes import SingleLanes
from swarm_nav.traffic.speed_limits import SpeedLimits
from swarm_nav.traffic.speed_near_people import people_near, slow_near_people

SAFETY_RULES = (KeepApart, StopBeforeObstacle)  # above what a centre wants


class Navigator:
    """Nav2-like navigator of one robot with reservation-based traffic. See ARCHITECTURE.md.

    A facade: what the robot is told goes to the parts, `tick` lets them decide in order, and what
    it tells is composed from them. The parts share one `RobotState`.
    """

    goal_kinds = tuple(GoalKind)  # that it takes

    def __init__(
        self,
        config: NavConfig,
        spec: RobotSpec,
        grid: Grid,
        sites: Sites,
        robot_id: int,
        initial_pose_map: Pose,
        names: RobotNames | None = None,
        pilot: TwistPilot | None = None,
    ) -> None:
        """Build all parts of an active robot without a goal.

        Args:
            grid: The map, upright.
            sites: Stations, circuits and zones of the world, in the same map frame.
            robot_id: From 1.
            initial_pose_map: Pose of base_footprint at the first odometry.
            names: Names of all robots, for people; None for the usual ones.
            pilot: Steers in place of the controller; None to follow goals.

        Raises:
            MapError: If the map has too many cells when it is divided into finer ones, or a zone
                lies beside it.
        """
        grid = sites.zones.mark(grid)
        self.spec = spec
        self.sites = sites
        self.is_active = True
        self._keepout_mask: Grid | None = None  # of the operator
        self._faults: list[tuple[ErrorCode, str]] = []  # of plug-ins since the last tick
        self._controller = make_controller(spec, config.controller, self._receive_fault)
        stations = [(p.x, p.y) for p in sites.stations.values()]
        make_planner = planner_maker(config.planner.plugin, spec)
        self._s = s = initial_state(
            config, spec, grid, robot_id, initial_pose_map, tuple(stations), names, make_planner
        )
        self._localiser = make_localiser(
            initial_pose_map, config.localisation, spec, s.terrain, s.neighbors, robot_id,
            config.localiser.plugin, self._receive_fault,
        )  # fmt: skip
        self._priority: PluginPriority | None = None
        if PRIORITY.is_own(config.traffic.priority_plugin):
            self._priority = PluginPriority(
                config.traffic.priority_plugin, spec, self._receive_fault
            )
        self._gate, lease, right = Gate(self._narrow_region()), Lease(), RightOfWay()
        holding = HoldingPattern(sites.circuits, stations)
        self._arbiter = arbiter = Arbiter(s, SingleLanes())
        self._state_machine = StateMachine(s, holding, arbiter)
        self._trip: ChargingTrip | None = None
        if spec.battery is not None:
            self._trip = ChargingTrip(spec.battery, list(sites.chargers.values()))
        self._goal_manager = GoalManager(s, self._state_machine, lease, right, arbiter, self._trip)
        self._lease, self._senses = lease, Senses(s)
        self._parts = Parts(
            s, sites, self._state_machine, self._goal_manager, right, Departure(self._gate, lease),
            lease, self._gate, holding, self._senses, arbiter,
        )  # fmt: skip
        self._rules = rules_of(self._parts, spec, self._receive_fault)
        self._follow_centre: FollowCentre | None = None
        if config.traffic.coordination != Coordination.DECENTRAL:
            self._follow_centre = FollowCentre(self._parts)
            safety = [rule for rule in self._rules if isinstance(rule, SAFETY_RULES)]
            own = [rule for rule in self._rules if rule not in safety]
            takes_over = LeaveOwnRules(self._parts, self._follow_centre.command)
            self._rules = [*safety, takes_over, self._follow_centre, *own]
        self._pilot = pilot
        if pilot is not None:
            self._rules.append(pilot)
        self._speed_limits = SpeedLimits(sites.zones)

    def _narrow_region(self) -> NDArray[np.int16] | None:
        return narrow_region(self._s.terrain, self._s.stations, self._s.usual_radius)

    def _receive_fault(self, code: ErrorCode, message: str) -> None:
        self._faults.append((code, message))

    def _give_up(self) -> None:
        """End the current goal because a plug-in failed."""
        code, message = self._faults[0]
        self._faults.clear()
        if self._task is not None:
            self._goal_manager.fail_target(self._task, code, message)
        else:
            self._goal_manager.end(Outcome.ABORTED, code, message)

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
        """Id of the current or pending goal, None without one."""
        return self._goal_manager.goal_id

    @property
    def is_pausing(self) -> bool:
        """Whether the robot is served where it was sent, until its next goal takes effect."""
        return self._goal_manager.is_pausing

    def variances(self) -> tuple[float, float, float]:
        """Return the variances of the estimated x, y [m²] and yaw [rad²]."""
        return self._localiser.variances()

    def particles(self) -> FloatArray:
        """Return the localiser's hypotheses (k, 3)."""
        return self._localiser.particles()

    def on_odom(self, odom: Odometry) -> None:
        """Receive the odometry of this tick."""
        self._localiser.on_odom(odom)
        self._s.velocity = odom.twist
        self._s.twist = self._controller.course(odom.twist)
        self._s.pose = self._localiser.pose_map

    def on_scan(self, scan: Scan) -> None:
        """Receive a scan."""
        scan = scan.from_above(self.spec.lidar)
        if scan.tick - self._s.listening_since > self._s.config.traffic.listen_ticks // 2:
            self._localiser.on_scan(scan)  # only then are the robots around known by radio
        self._senses.on_scan(scan)

    def on_neighbors(self, beacons: BeaconArray) -> None:
        """Receive the radio's batch of this tick, which may be empty.

        Args:
            beacons: (n,) by ascending id.
        """
        self._senses.on_neighbors(beacons)

    def on_reception(self, reception: Reception) -> None:
        """Receive the radio's batch of this tick where it is, without a copy.

        Args:
            reception: Beacons as words, and the rows that are heard.
        """
        self._senses.on_reception(reception)

    def on_battery(self, reading: BatteryReading) -> None:
        """Receive a reading of the battery, one a second; without any it does not count."""
        if self._trip is not None:
            self._trip.reading = reading

    def on_initial_pose(
        self, pose_map: Pose, deviation: tuple[float, float] = START_DEVIATION
    ) -> None:
        """Set the pose that the operator states, known to within `deviation` [m], [rad].

        Args:
            deviation: Standard deviations of position [m] and heading [rad].
        """
        self._localiser.initialise(pose_map, deviation)
        self._adopt_pose()

    def _adopt_pose(self) -> None:
        """Continue from a pose that is elsewhere; claims made at the old one are dropped."""
        s, pose = self._s, self._localiser.pose_map
        if pose.distance(s.pose) > s.config.traffic.safety_margin:
            self._senses.listen_anew()  # the owner of the space there is not known yet
        s.pose = pose
        self._arbiter.hold_place()

    def load_map(self, grid: Grid) -> None:
        """Replace the map.

        Args:
            grid: Occupancy, in the same map frame.

        Raises:
            MapError: If the map has too many cells when it is divided into finer ones, or a zone
                lies beside it.
        """
        self._mark(grid)
        self._localiser.load_map(self._s.terrain)

    def on_keepout_mask(self, mask: Grid) -> None:
        """Set the filter mask of places where the robot must not be, besides those of the world.

        Args:
            mask: Upright; 100 is forbidden, 1 to 99 costs more.

        Raises:
            MapError: If the mask lies beside the map.
        """
        self._keepout_mask = mask
        self._mark(replace(self._s.terrain.grid, keepout=None))

    def _mark(self, grid: Grid) -> None:
        """Apply a map, with zones and mask."""
        grid = self.sites.zones.mark(grid)
        if self._keepout_mask is not None:
            grid = with_mask(grid, self._keepout_mask)
        self._arbiter.load_map(grid)
        self._gate.leave()
        self._gate.region = self._narrow_region()

    def reconfigure(self, config: NavConfig) -> None:
        """Apply new parameters, effective from the next tick."""
        self._controller.configure(config.controller)
        self._arbiter.configure(config)
        self._localiser.configure(config.localisation)

    def on_speed_limit(self, limit: float, *, is_percentage: bool) -> None:
        """Set the operator's speed limit, which counts beside those of zones.

        Args:
            limit: [m/s], or [%] of the largest speed of the controller; 0 for none.
            is_percentage: Whether it is in percent.
        """
        self._speed_limits.set(limit, is_percentage=is_percentage)

    def activate(self) -> None:
        """Start to navigate; listens first."""
        if not self.is_active:
            self.is_active = True
            self._senses.listen_anew()
            self._arbiter.hold_place()

    def deactivate(self) -> None:
        """Stop, end the current goal, and hold the place."""
        self._goal_manager.end_all("the navigator was deactivated")
        self.is_active = False

    def clear_costmap(self) -> None:
        """Forget what the LiDAR saw."""
        self._s.obstacles.clear()

    def clear_square(self, centre: Pose, half: float, is_except: bool) -> None:
        """Forget what the LiDAR saw in a square, or outside it.

        Args:
            centre: In map; the square's sides are along its axes.
            half: [m] of an edge.
            is_except: Whether it is the rest that is forgotten.
        """
        self._s.obstacles.clear_square(centre.x, centre.y, half, is_except)

    def steer(self, twist: Twist) -> None:
        """Receive the twist that an operator wants in the current assisted teleoperation.

        Args:
            twist: The twist that is asked for; it is limited to what is free.
        """
        if self._goal_manager.behavior is not None:
            self._goal_manager.behavior.steer(twist, self._s.tick)

    def end_teleop(self, reason: str = "") -> None:
        """End the current assisted teleoperation, if any.

        Args:
            reason: Why it failed; empty for a success.
        """
        behavior = self._goal_manager.behavior
        if behavior is not None and behavior.goal.kind is GoalKind.TELEOP:
            code = ErrorCode.TELEOP_TIMEOUT if reason else ErrorCode.NONE
            behavior.finish(BehaviorEnd(code, reason))

    def smooth(self, points: FloatArray) -> FloatArray:
        """Return a polyline (n, 2) smoothed and lifted off walls, as plans are.

        Args:
            points: (n, 2) [m] in map.
        """
        return self._s.planner.smooth(points)

    def is_clear(self, points: FloatArray) -> bool:
        """Whether the robot's body fits everywhere on a polyline (n, 2), by the map.

        Args:
            points: (n, 2) [m] in map.
        """
        terrain, radius = self._s.terrain, self.spec.inscribed_radius
        return all(terrain.clearance(x, y) >= radius for x, y in points.tolist())

    def set_goal(self, goal: Goal) -> None:
        """Accept a goal; the current one ends as canceled (preempted).

        Args:
            goal: With the tick from which it counts.
        """
        self._goal_manager.set_goal(goal)

    def take_order(self, order: TeamOrder) -> None:
        """Receive an order of the centre; without `traffic.coordination` it does not count."""
        if self._follow_centre is not None:
            self._follow_centre.command.take(order, self._s.tick)

    def report(self) -> RobotReport | None:
        """Return the report to the centre after a tick; None where each robot decides alone."""
        return None if self._follow_centre is None else self._follow_centre.report(self._s)

    def cancel_goal(self) -> None:
        """End the current goal, if any."""
        self._goal_manager.end(Outcome.CANCELED, message="canceled")

    def tick(self, tick: int) -> Output:
        """Decide; call once per control tick after the observations of that tick.

        Args:
            tick: Number of the control tick.

        Returns:
            The twist to drive, the beacon to send, and what happened since the last tick.
        """
        *_, output = self.stages(tick)
        assert output is not None
        return output

    def stages(self, tick: int) -> Iterator[Output | None]:
        """Decide stage by stage, as `tick` does at once.

        Many navigators in one process are faster if they take turns after each stage: what runs
        stays in the processor's cache. All have the same number of stages.

        Args:
            tick: Number of the control tick.

        Yields:
            None after each stage, at last what `tick` returns.
        """
        self._begin(tick)
        is_lost = self._localise()
        yield None
        can_drive = self._sense(is_lost) and self.is_active
        yield None
        self._choose_goal()
        yield None
        arbiter = self._arbiter
        if can_drive:
            if self._follow_centre is not None:
                self._follow_centre.update(self._s)
            arbiter.decide(self._rules, self._goal_manager.apply)
        yield None
        arbiter.settle()
        twist = arbiter.guard(self._follow() if can_drive else self._stand(), releases=can_drive)
        if can_drive:
            arbiter.extend()
        yield None
        beacon = self._announce()
        self._count_waiting()
        yield Output(twist, beacon, self._state_machine.pop_events())

    def _begin(self, tick: int) -> None:
        """Set the time; after a gap in it the other robots no longer respect the old space."""
        s = self._s
        is_first, passed = s.tick == 0, tick - s.tick
        s.tick = tick
        if is_first and tick > 1:
            self._senses.listen_anew()  # a navigator that joins late listens first
        elif passed > s.config.traffic.lost_ticks:
            self._senses.listen_anew()
            self._arbiter.hold_place()
            self._goal_manager.replan()

    def _localise(self) -> bool:
        """Announce the margin that the pose needs, and correct it; return whether it is lost."""
        s, localiser = self._s, self._localiser
        is_lost = localiser.is_lost
        self._arbiter.announce_margin(localiser.margin)
        if localiser.wants_leap and s.is_standing:
            localiser.leap()
            s.obstacles.clear()
            self._adopt_pose()
        return is_lost

    def _sense(self, is_lost: bool) -> bool:
        """Update the neighbours; return whether the robot knows enough to drive."""
        s = self._s
        if s.neighbors.refresh(s.tick):
            s.record_bodies()
        s.radio.note(s.neighbors.mean_trip)
        return self._senses.update(is_lost, self._battery_share == 0.0)

    def _choose_goal(self) -> None:
        """Begin a goal that is due; queue for its station and at the gate before it."""
        s, goal_manager = self._s, self._goal_manager
        goal_manager.begin_pending()
        if self._faults:
            self._give_up()
        if self.is_active:
            goal_manager.update_charging()
        self._lease.update(s)
        self._gate.update(
            s,
            has_turn=self._task is not None and self._lease.is_turn(s.config.holding),
            is_driving=self._state is State.DRIVING,
            priority=self._driving_priority,
        )

    @property
    def _battery_share(self) -> float:
        """Return charge by capacity; NaN without a battery, and before its first reading."""
        reading = self._trip.reading if self._trip is not None else None
        return math.nan if reading is None else reading.share

    def _driving_priority(self) -> int:
        own = base_priority(CLASS_DRIVING, self._rank_tick, self._s.robot_id)
        return max(own, self._s.donations.station)

    @property
    def _rank_tick(self) -> int:
        """Tick at which the last target was reached, or what a plug-in ranks the robot by."""
        last = self._goal_manager.last_goal_tick
        if self._priority is None:
            return last
        target = None if self._task is None else self._task.target
        return self._priority.last_goal_tick(
            self._s.robot_id, self._s.tick, last, self._s.pose, target
        )

    def _follow(self) -> Twist:
        """Return the controller's or the pilot's twist, slowed down near people and in zones."""
        s, parts = self._s, self._parts
        # Whoever backed up and is done does not turn about for the rest of that path.
        has_backed_up = self._state is State.IDLE and s.tube.is_reverse
        may_back = self._state is State.YIELDING or has_backed_up or s.is_confined
        if self._pilot is None:
            twist = self._arbiter.follow(self._controller, may_back)
        else:
            twist = self._arbiter.follow_pilot(self._pilot)
        parts.people = people_near(s)
        twist = slow_near_people(twist, parts.people, s.config.controller)
        return self._speed_limits.limited(twist, s)

    def _stand(self) -> Twist:
        self._arbiter.retract()
        self._goal_manager.excuse()
        return self._controller.stop(self._s.twist)

    def _announce(self) -> np.void:
        """Publish priority and reservation; return the beacon."""
        s, goal_manager = self._s, self._goal_manager
        rank = CLASS_HOLDING if self._state_machine.is_waiting else CLASS_DRIVING
        if not goal_manager.has_goal:
            rank = CLASS_DONE
        if rank != CLASS_DRIVING:
            s.donations.lane = 0
        base = base_priority(rank, self._rank_tick, s.robot_id)
        self._arbiter.announce_priorities(s.donations.own(base), s.donations.published(base))
        self._arbiter.publish()
        return compose_beacon(self._parts, self.spec, self.is_active, is_pausing=self.is_pausing)

    def _count_waiting(self) -> None:
        s, state = self._s, self._state_machine.state
        if state is State.HOLDING:
            s.counters.hold_ticks += 1
        elif state is State.DRIVING and s.is_standing and (s.blocked_ticks or s.led_standing):
            s.counters.wait_ticks += 1

    @property
    def _state(self) -> State:
        return self._state_machine.state

    @property
    def _task(self) -> GoalProgress | None:
        return self._goal_manager.task

    def make_plan(self, start: Pose | None, goals: Sequence[Pose]) -> FloatArray:
        """Return a path (n, 2) through the goals from `start` (None: the robot's pose).

        Args:
            start: Start of the path; None for the pose of the robot.

        Raises:
            PlanError: With Nav2's code, if there is none.
        """
        return self._s.planner.plan_through([(p.x, p.y) for p in (start or self._s.pose, *goals)])

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
        """Return the path length [m] to the current goal, 0 without one."""
        return 0.0 if self._task is None else self._task.distance_remaining(self._s)

    def feedback(self) -> Feedback | None:
        """Return the progress of the current or pending goal, None without one."""
        goal_manager = self._goal_manager
        if goal_manager.goal_id is None:
            return None
        return compose_feedback(
            self._s, goal_manager.goal_id, goal_manager.asked, goal_manager.behavior
        )

    def status(self) -> Status:
        """Return the state for the operator."""
        goal_manager = self._goal_manager
        target = goal_manager.asked.target if goal_manager.asked is not None else None
        if target is None and goal_manager.has_goal and not goal_manager.is_on_trip:
            target = self._s.pose  # a behaviour that somebody asked for: the robot is not free
        behavior = goal_manager.behavior
        return compose_status(
            self._parts,
            self.is_active,
            target,
            self.distance_remaining(),
            is_pausing=self.is_pausing,
            failure=goal_manager.failure,
            is_on_trip=goal_manager.is_on_trip,
            battery=self._battery_share,
            reach=math.inf if self._trip is None else self._trip.reach,
            is_by_hand=behavior is not None and behavior.goal.kind is GoalKind.TELEOP,
        )
