"""A brain that a user brings, with the face that the bench and the ROS node need of a robot."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from swarm_common.model.battery import BatteryReading
from swarm_common.model.beacon import (
    BEACON_DTYPE,
    FLAG_ACTIVE,
    FOOTPRINT_POINTS,
    MODE_DONE,
    MODE_DRIVE,
    BeaconArray,
    Reception,
    reception_of,
)
from swarm_common.model.coordination import Coordination
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import OCCUPIED, UNKNOWN, Grid
from swarm_common.model.records import (
    FloatArray,
    Odometry,
    Pose,
    RobotSpec,
    Scan,
    Twist,
    stamp_from_tick,
)
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.sites import Sites
from swarm_common.process.plugins import PluginError
from swarm_nav.behaviour.costmap import Costmap
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import (
    ErrorCode,
    Event,
    Feedback,
    Goal,
    GoalEnded,
    GoalKind,
    Outcome,
    Output,
    Status,
)
from swarm_nav.core.localisation_config import START_DEVIATION
from swarm_nav.core.plugins import BRAIN
from swarm_nav.localisation.localiser import OdometryLocaliser
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.planning.planner import Planner
from swarm_nav.reservation.tube import padded
from swarm_nav.traffic.robot_state import terrain_of

MAPPED_COST, UNKNOWN_COST = 254, 255  # as Nav2's costmaps have them


def make_brain(
    config: NavConfig,
    spec: RobotSpec,
    grid: Grid,
    sites: Sites,
    robot_id: int,
    initial_pose_map: Pose,
    names: RobotNames | None = None,
) -> RobotBrain:
    """Return the brain of a robot, by `brain.plugin`.

    Args:
        grid: The map, upright.
        sites: Sites of the world, in the same map frame.
        robot_id: From 1.
        initial_pose_map: Pose of base_footprint at the first odometry.
        names: Names of all robots, for people; None for the usual ones.

    Raises:
        ConfigError: If the plug-in is missing.
        MapError: If the map is of no use.
    """
    place = grid, sites, robot_id, initial_pose_map
    if BRAIN.is_own(config.brain.plugin):
        if config.traffic.coordination != Coordination.DECENTRAL:
            raise ConfigError(
                f"traffic.coordination is {config.traffic.coordination}: a centre leads built-in"
                f" navigators, not brain.plugin {config.brain.plugin}"
            )
        return BrainAdapter(config, spec, *place)
    return Navigator(config, spec, *place, names)


class BrainAdapter:
    """Calls the plug-in, and answers for it what it does not answer itself.

    If the plug-in fails, the robot stands and its goal fails. Without a plug-in's own the pose is
    that of the odometry, plans are those of the built-in planner, and costmaps show the map.

    Attributes:
        spec: Model of the robot.
        goal_id: Id of the current or pending goal; None without one.
        is_active: Whether the robot may drive.
    """

    def __init__(
        self,
        config: NavConfig,
        spec: RobotSpec,
        grid: Grid,
        sites: Sites,
        robot_id: int,
        initial_pose_map: Pose,
    ) -> None:
        """Make the plug-in of `brain.plugin`.

        Args:
            robot_id: From 1.
            initial_pose_map: Pose of base_footprint at the first odometry.

        Raises:
            ConfigError: If it is missing.
        """
        self.spec = spec
        self.goal_id: int | None = None
        self.is_active = True
        self._config, self._grid, self._robot_id = config, grid, robot_id
        self._localiser = OdometryLocaliser(initial_pose_map)
        self._neighbors = NeighborTable(robot_id, config.traffic, remembers_absent=False)
        self._twist, self._tick = Twist(), 0
        self._goal: Goal | None = None
        self._events: list[Event] = []
        self._fault: PluginError | None = None
        self._counts = dict.fromkeys(Outcome, 0)
        self._own = BRAIN.guard(
            config.brain.plugin, config, spec, grid, sites, robot_id, initial_pose_map
        )

    def _ask(self, method: str, *arguments: Any, **keywords: Any) -> Any:
        """Return the answer of a plug-in that has a method; None if not, or if it fails."""
        if self._own.has(method):
            try:
                return self._own.call(method, *arguments, **keywords)
            except PluginError as error:
                self._fault = error
        return None

    def _value(self, name: str, default: Any) -> Any:
        if self._own.has(name):
            try:
                return self._own.value(name)
            except PluginError as error:
                self._fault = error
        return default

    # Each tick

    def on_odom(self, odom: Odometry) -> None:
        """Receive the odometry of this tick."""
        self._localiser.on_odom(odom)
        self._twist = odom.twist
        self._ask("on_odom", odom)

    def on_scan(self, scan: Scan) -> None:
        """Receive a scan."""
        self._ask("on_scan", scan)

    def on_battery(self, reading: BatteryReading) -> None:
        """Receive a reading of the battery."""
        self._ask("on_battery", reading)

    def on_reception(self, reception: Reception) -> None:
        """Receive the beacons heard in this tick."""
        pose = self._localiser.pose_map
        self._neighbors.take(reception, pose.x, pose.y)
        self._ask("on_reception", reception)

    def on_neighbors(self, beacons: BeaconArray) -> None:
        """Receive the beacons heard in this tick.

        Args:
            beacons: (n,) by ascending id.
        """
        self.on_reception(reception_of(beacons))

    def tick(self, tick: int) -> Output:
        """Decide; without an answer of the plug-in the robot stands, and its goal fails.

        Args:
            tick: Number of the control tick.

        Returns:
            The twist to drive, the beacon to send, and what happened since the last tick.
        """
        self._tick = tick
        self._neighbors.refresh(tick)
        try:
            output = self._checked(self._own.call("tick", tick))
        except PluginError as error:
            self._fault = error
            output = Output(Twist(), self._beacon(), ())
        ended = [*output.events]
        if self._fault is not None:
            code, message = BRAIN.codes[self._fault.fault], str(self._fault)
            self._fault = None
            output = Output(Twist(), output.beacon, ())
            if self.goal_id is not None:
                ended.append(GoalEnded(self.goal_id, Outcome.ABORTED, tick, code, message))
        events, self._events = self._events, []
        events += [event for event in ended if self._counts_event(event)]
        twist = output.twist if self.is_active else Twist()
        return Output(twist, output.beacon, tuple(events))

    def _checked(self, output: Any) -> Output:
        try:
            twist = output.twist
            numbers = (twist.vx, twist.vy, twist.wz)
            is_usable = all(map(math.isfinite, numbers)) and output.beacon.dtype == BEACON_DTYPE
            if is_usable and isinstance(output, Output):
                return output
        except (AttributeError, TypeError):
            pass
        raise self._own.unusable("tick returned no Output with a finite twist and a beacon")

    def _counts_event(self, event: Event) -> bool:
        """Whether an event is to be passed on; only the current goal can end."""
        if not isinstance(event, GoalEnded):
            return True
        if event.goal_id != self.goal_id:
            return False
        self.goal_id = self._goal = None
        self._counts[event.outcome] += 1
        return True

    def _beacon(self) -> np.void:
        """Return the beacon of a robot that stands: it acknowledges what others ask for."""
        beacon = plain_beacon(
            self._robot_id, self._tick, self.spec, self.pose_map, self._twist,
            is_driving=self.goal_id is not None,
        )  # fmt: skip
        beacon["radius"] += self._config.traffic.safety_margin
        beacon["heard"] = self._neighbors.heard(self._tick)
        return beacon

    # Goals

    def set_goal(self, goal: Goal) -> None:
        """Accept a goal; the current one ends as canceled (preempted)."""
        self._cancel("preempted by a new goal")
        self.goal_id, self._goal = goal.goal_id, goal
        if goal.kind in self._value("goal_kinds", (GoalKind.NAVIGATE,)):
            self._ask("set_goal", goal)
            return
        message = f"{self._own.what} does not know goals of {goal.kind.value}"
        self._end(Outcome.ABORTED, message, ErrorCode.CONTROL_UNKNOWN)

    def cancel_goal(self) -> None:
        """End the current goal, if any; the robot is sent to where it is."""
        if self.goal_id is None:
            return
        self._cancel("canceled")
        if self._own.has("cancel_goal"):
            self._ask("cancel_goal")
        else:
            self._ask("set_goal", Goal(kind=GoalKind.NAVIGATE, poses_map=(self.pose_map,)))

    def _cancel(self, message: str) -> None:
        if self.goal_id is not None:
            self._end(Outcome.CANCELED, message)

    def _end(self, outcome: Outcome, message: str, code: ErrorCode = ErrorCode.NONE) -> None:
        assert self.goal_id is not None
        self._counts[outcome] += 1
        self._events.append(GoalEnded(self.goal_id, outcome, self._tick, code, message))
        self.goal_id = self._goal = None

    def steer(self, twist: Twist) -> None:
        """Receive the twist of an operator."""
        self._ask("steer", twist)

    def end_teleop(self, reason: str = "") -> None:
        """End assisted teleoperation, if any."""
        self._ask("end_teleop", reason)

    def on_speed_limit(self, limit: float, *, is_percentage: bool) -> None:
        """Set a speed limit that comes from the operator.

        Args:
            limit: [m/s] or [%]; 0 for none.
            is_percentage: Whether it is in percent.
        """
        self._ask("on_speed_limit", limit, is_percentage=is_percentage)

    def on_keepout_mask(self, mask: Grid) -> None:
        """Set the mask of places where the robot must not be."""
        self._ask("on_keepout_mask", mask)

    def activate(self) -> None:
        """Start to drive."""
        self.is_active = True
        self._ask("activate")

    def deactivate(self) -> None:
        """Stop, and end the current goal."""
        self.cancel_goal()
        self.is_active = False
        self._ask("deactivate")

    def reconfigure(self, config: NavConfig) -> None:
        """Apply new parameters."""
        self._config = config
        self._ask("reconfigure", config)

    # Where the robot is

    @property
    def pose_map(self) -> Pose:
        """Pose of base_footprint in map."""
        pose: Pose = self._value("pose_map", self._localiser.pose_map)
        return pose

    @property
    def map_from_odom(self) -> Pose:
        """The transform map → odom."""
        pose: Pose = self._value("map_from_odom", self._localiser.map_from_odom)
        return pose

    def on_initial_pose(
        self, pose_map: Pose, deviation: tuple[float, float] = START_DEVIATION
    ) -> None:
        """Set the pose that the operator states.

        Args:
            deviation: Standard deviations of position [m] and heading [rad].
        """
        self._localiser.initialise(pose_map, deviation)
        self._ask("on_initial_pose", pose_map, deviation)

    def variances(self) -> tuple[float, float, float]:
        """Return the variances of x, y [m²] and yaw [rad²]."""
        return self._ask("variances") or self._localiser.variances()

    def particles(self) -> FloatArray:
        """Return hypotheses (k, 3) of the pose."""
        found = self._ask("particles")
        return self._localiser.particles() if found is None else found

    # The map

    def load_map(self, grid: Grid) -> None:
        """Replace the map."""
        self._grid = grid
        self.__dict__.pop("_planner", None)
        self._ask("load_map", grid)

    def clear_costmap(self) -> None:
        """Forget what the LiDAR saw."""
        self._ask("clear_costmap")

    def clear_square(self, centre: Pose, half: float, is_except: bool) -> None:
        """Forget what the LiDAR saw in a square, or outside it.

        Args:
            half: [m] of an edge.
            is_except: Whether it is the rest that is forgotten.
        """
        self._ask("clear_square", centre, half, is_except)

    @functools.cached_property
    def _planner(self) -> Planner:
        terrain = terrain_of(self._config, self.spec, self._grid)
        return Planner(terrain, self._config.planner)

    def make_plan(self, start: Pose | None, goals: Sequence[Pose]) -> FloatArray:
        """Return a path (n, 2) through the goals from `start` (None: the robot's pose).

        Args:
            start: Start of the plan; None for the pose of the robot.

        Raises:
            PlanError: If there is none.
        """
        poses = (start or self.pose_map, *goals)
        return self._planner.plan_through([(pose.x, pose.y) for pose in poses])

    def smooth(self, points: FloatArray) -> FloatArray:
        """Return a polyline (n, 2) smoothed and lifted off walls.

        Args:
            points: (n, 2) [m] in map.
        """
        return self._planner.smooth(points)

    def is_clear(self, points: FloatArray) -> bool:
        """Whether the robot's body fits everywhere on a polyline (n, 2), by the map.

        Args:
            points: (n, 2) [m] in map.
        """
        terrain, radius = self._planner.terrain, self.spec.inscribed_radius
        return all(terrain.clearance(x, y) >= radius for x, y in points.tolist())

    def global_costmap(self) -> Costmap:
        """Return the costmap of the whole map."""
        found: Costmap | None = self._ask("global_costmap")
        return self._map_as_costmap if found is None else found

    def local_costmap(self) -> Costmap:
        """Return the costmap around the robot."""
        found: Costmap | None = self._ask("local_costmap")
        return self._map_as_costmap if found is None else found

    @property
    def _map_as_costmap(self) -> Costmap:
        grid = self._grid
        costs = np.zeros(grid.cells.shape, np.uint8)
        costs[grid.cells >= OCCUPIED // 2] = MAPPED_COST
        costs[grid.cells == UNKNOWN] = UNKNOWN_COST
        return Costmap(costs, grid.resolution, grid.origin_x, grid.origin_y)

    def plan_map(self) -> FloatArray:
        """Return the path ahead (n, 2) in map; empty if the plug-in has none to show."""
        found = self._ask("plan_map")
        return np.zeros((0, 2)) if found is None else found

    def local_plan_map(self) -> FloatArray:
        """Return predicted positions (n, 2) in map, likewise."""
        found = self._ask("local_plan_map")
        return np.zeros((0, 2)) if found is None else found

    # What the operator sees

    @property
    def is_pausing(self) -> bool:
        """Whether the robot is served where it was sent."""
        return bool(self._value("is_pausing", False))

    @property
    def _target(self) -> Pose | None:
        return self._goal.poses_map[0] if self._goal is not None and self._goal.poses_map else None

    def feedback(self) -> Feedback | None:
        """Return the progress of the current goal, None without one."""
        found: Feedback | None = self._ask("feedback")
        if found is not None or self.goal_id is None or self._target is None:
            return found
        rest = self.pose_map.distance(self._target)
        rest_time = rest / self._config.controller.max_vel_x
        figures = (self.goal_id, self.pose_map, 0.0, rest_time, 0, rest, 1, 0, 0.0, 0.0)
        return Feedback(*figures, speed=self._twist.vx)

    def status(self) -> Status:
        """Return the state for the operator."""
        found: Status | None = self._ask("status")
        if isinstance(found, Status):
            return found
        return plain_status(
            self.pose_map,
            self._target,
            is_driving=self.goal_id is not None,
            goals_reached=self._counts[Outcome.SUCCEEDED],
            goals_failed=self._counts[Outcome.ABORTED],
        )


RobotBrain: TypeAlias = Navigator | BrainAdapter


def plain_status(
    pose_map: Pose, target_map: Pose | None, *, is_driving: bool, **figures: Any
) -> Status:
    """Return the status of a robot that drives or idles, and never waits.

    Args:
        target_map: None without one.
        is_driving: Whether it has a goal.
        figures: Other members of the status than these; counters are 0 otherwise.
    """
    counters = (field.name for field in dataclasses.fields(Status) if field.type == "int")
    return Status(
        state="driving" if is_driving else "idle", detail="", pose_map=pose_map,
        goal_map=target_map, station="",
        distance_remaining=0.0 if target_map is None else pose_map.distance(target_map),
        estimated_time_remaining=0.0, hold_time=0.0, wait_time=0.0,
        **{**dict.fromkeys(counters, 0), **figures},
    )  # fmt: skip


def plain_beacon(
    robot_id: int, tick: int, spec: RobotSpec, pose_map: Pose, twist: Twist, *, is_driving: bool
) -> np.void:
    """Return the beacon of a robot that holds its place and asks for nothing.

    Args:
        robot_id: From 1.
        is_driving: Whether it has a goal.
    """
    beacon: np.void = np.zeros(1, BEACON_DTYPE)[0]
    beacon["sec"], beacon["nanosec"] = stamp_from_tick(tick)
    beacon["id"], beacon["tick"] = robot_id, tick
    beacon["radius"] = spec.circumscribed_radius
    beacon["pose"] = (pose_map.x, pose_map.y, pose_map.yaw)
    beacon["twist"] = (twist.vx, twist.wz)
    beacon["flags"] = FLAG_ACTIVE
    beacon["mode"] = MODE_DRIVE if is_driving else MODE_DONE
    beacon["target"] = beacon["station"] = (math.nan, math.nan)
    beacon["held"][0] = (pose_map.x, pose_map.y)
    beacon["held_size"] = 1
    footprint = padded(np.array(spec.footprint), FOOTPRINT_POINTS)
    beacon["footprint"], beacon["footprint_size"] = footprint
    return beacon
