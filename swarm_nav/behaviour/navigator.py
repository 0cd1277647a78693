"""The brain of one robot: observations in, one twist and one beacon per tick out. No I/O."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from swarm_common.model.battery import BatteryReading
from swarm_common.model.beacon import Reception
from swarm_common.model.central import Coordination, RobotReport, TeamOrder
from swarm_common.model.grid import Grid
from swarm_common.model.records import Odometry, Pose, RobotSpec, Scan, Twist
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.announcement import compose_beacon, compose_status
from swarm_nav.behaviour.charging import ChargingTrip
from swarm_nav.behaviour.follow_centre import FollowCentre, LeaveOwnRules
from swarm_nav.behaviour.goal_manager import GoalManager
from swarm_nav.behaviour.goal_progress import GoalProgress
from swarm_nav.behaviour.parts import Parts
from swarm_nav.behaviour.plugin_priority import PluginPriority
from swarm_nav.behaviour.rules import rules_of
from swarm_nav.behaviour.services import NavigatorServices
from swarm_nav.behaviour.state_machine import StateMachine
from swarm_nav.control.omni import make_controller
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import ErrorCode, Goal, GoalKind, Outcome, Output, Status
from swarm_nav.core.plugins import PRIORITY
from swarm_nav.core.rank import CLASS_DONE, CLASS_DRIVING, CLASS_HOLDING, base_priority
from swarm_nav.core.states import State
from swarm_nav.interfaces import Services
from swarm_nav.localisation.localiser import make_localiser
from swarm_nav.planning.plugin_planner import planner_maker
from swarm_nav.traffic.arbiter import Arbiter, TwistPilot
from swarm_nav.traffic.departure import Departure
from swarm_nav.traffic.gate import Gate, narrow_region
from swarm_nav.traffic.held_space_rules import KeepApart, StopBeforeObstacle
from swarm_nav.traffic.holding import HoldingPattern
from swarm_nav.traffic.lease import Lease
from swarm_nav.traffic.right_of_way import RightOfWay
from swarm_nav.traffic.robot_state import initial_state
from swarm_nav.traffic.senses import Senses
from swarm_nav.traffic.single_lanes import SingleLanes
from swarm_nav.traffic.speed_limits import SpeedLimits
from swarm_nav.traffic.speed_near_people import people_near, slow_near_people

SAFETY_RULES = (KeepApart, StopBeforeObstacle)  # above what a centre wants


class Navigator:
    """Nav2-like navigator of one robot with reservation-based traffic. See ARCHITECTURE.md.

    Observations go to the parts, `tick` lets them decide in order, and beacon and status are
    composed from them. The parts share one `RobotState`.

    Attributes:
        services: Commands of an operator, and what Nav2 offers beside goals.
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
        self._spec = spec
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
        region = narrow_region(s.terrain, s.stations, s.usual_radius)
        self._gate, lease, right = Gate(region), Lease(), RightOfWay()
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
        self.services: Services = NavigatorServices(
            self._parts, spec, self._localiser, self._controller, self._speed_limits
        )

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
    def reservation_config(self) -> NavConfig:
        """All parameters in force; those of its reservations are among them."""
        return self._s.config

    @property
    def pose_map(self) -> Pose:
        """Estimated pose of base_footprint in map."""
        return self._localiser.pose_map

    def on_odom(self, odom: Odometry) -> None:
        """Receive the odometry of this tick."""
        self._localiser.on_odom(odom)
        self._s.velocity = odom.twist
        self._s.twist = self._controller.course(odom.twist)
        self._s.pose = self._localiser.pose_map

    def on_scan(self, scan: Scan) -> None:
        """Receive a scan."""
        scan = scan.from_above(self._spec.lidar)
        if scan.tick - self._s.listening_since > self._s.config.traffic.listen_ticks // 2:
            self._localiser.on_scan(scan)  # only then are the robots around known by radio
        self._senses.on_scan(scan)

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
        can_drive = self._sense(is_lost) and self._parts.is_active
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
            self._parts.adopt_pose(localiser.pose_map)
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
        if self._parts.is_active:
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
        return compose_beacon(self._parts, self._spec)

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

    def status(self) -> Status:
        """Return the state for the operator."""
        reach = math.inf if self._trip is None else self._trip.reach
        return compose_status(self._parts, battery=self._battery_share, reach=reach)
