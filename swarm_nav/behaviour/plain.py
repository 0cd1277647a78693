"""A brain without traffic, as baselines and brains of users have in common what they do not decide.

It knows its pose by odometry and the others by their beacons, has one goal at a time, and answers
for its services as well as that allows; see `swarm_nav.interfaces`.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from swarm_common.model.battery import BatteryReading
from swarm_common.model.beacon import (
    FLAG_ACTIVE,
    FOOTPRINT_POINTS,
    MODE_DONE,
    MODE_DRIVE,
    Reception,
    blank_beacon,
    pack_head,
    record_of,
)
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
from swarm_common.model.zones import DirectedZone
from swarm_nav.behaviour.costmap import LETHAL, NO_INFORMATION
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import ErrorCode, Event, Feedback, Goal, GoalEnded, Outcome, Status
from swarm_nav.core.localisation_config import START_DEVIATION
from swarm_nav.interfaces import Costmap
from swarm_nav.localisation.localiser import OdometryLocaliser
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.planning.planner import Planner
from swarm_nav.traffic.robot_state import terrain_of


class PlainBrain:
    """Base of brains that decide in `tick`; commands that they do not know are lost.

    Attributes:
        tick_now: Tick of the last decision.
        twist: Twist that odometry measures.
        neighbors: Beacons of the other robots.
    """

    def __init__(
        self, config: NavConfig, spec: RobotSpec, grid: Grid, robot_id: int, initial_pose_map: Pose
    ) -> None:
        """Stand at a pose without a goal.

        Args:
            config: All parameters, of which a method uses some.
            robot_id: From 1.
            initial_pose_map: Pose of base_footprint in map at the first odometry.
        """
        self.config, self.spec, self.grid, self.robot_id = config, spec, grid, robot_id
        self.tick_now, self.twist = 0, Twist()
        self.is_active = True
        self.replans = self.recoveries = 0
        self.neighbors = NeighborTable(robot_id, config.traffic, remembers_absent=False)
        self._localiser = OdometryLocaliser(initial_pose_map)
        self._charge = math.nan
        self._goal: Goal | None = None
        self._events: list[Event] = []
        self._counts = dict.fromkeys(Outcome, 0)

    @property
    def services(self) -> PlainBrain:
        return self

    def on_odom(self, odom: Odometry) -> None:
        self._localiser.on_odom(odom)
        self.twist = odom.twist

    def on_scan(self, scan: Scan) -> None:
        pass

    def on_battery(self, reading: BatteryReading) -> None:
        self._charge = reading.share

    def on_reception(self, reception: Reception) -> None:
        pose = self._localiser.pose_map
        self.neighbors.take(reception, pose.x, pose.y)

    @property
    def target(self) -> Pose | None:
        """The goal's pose in map; None without a goal."""
        return self._goal.poses_map[0] if self._goal is not None and self._goal.poses_map else None

    def status(self) -> Status:
        return plain_status(
            self.pose_map, self.target, is_driving=self._goal is not None, battery=self._charge,
            number_of_recoveries=self.recoveries, goals_reached=self._counts[Outcome.SUCCEEDED],
            goals_failed=self._counts[Outcome.ABORTED], replans=self.replans,
        )  # fmt: skip

    def _end(self, outcome: Outcome, code: ErrorCode = ErrorCode.NONE, message: str = "") -> None:
        """End the current goal, if any."""
        if self._goal is not None:
            self._counts[outcome] += 1
            end = GoalEnded(self._goal.goal_id, outcome, self.tick_now, code, message)
            self._events.append(end)
        self._goal = None

    def _beacon(self) -> np.void:
        return plain_beacon(
            self.robot_id, self.tick_now, self.spec, self.pose_map, self.twist,
            is_driving=self._goal is not None,
        )  # fmt: skip

    # Commands of an operator

    @property
    def goal_id(self) -> int | None:
        return None if self._goal is None else self._goal.goal_id

    is_pausing = False

    def feedback(self) -> Feedback | None:
        goal, target = self._goal, self.target
        if goal is None or target is None:
            return None
        rest = self.pose_map.distance(target)
        time = rest / self.config.controller.max_vel_x
        figures = (goal.goal_id, self.pose_map, 0.0, time, 0, rest, 1, 0, 0.0, 0.0)
        return Feedback(*figures, speed=self.twist.vx)

    def cancel_goal(self) -> None:
        self._end(Outcome.CANCELED, message="canceled")

    def activate(self) -> None:
        self.is_active = True

    def deactivate(self) -> None:
        self.cancel_goal()
        self.is_active = False

    def reconfigure(self, config: NavConfig) -> None:
        self.config = config

    def steer(self, twist: Twist) -> None:
        pass

    def end_teleop(self, reason: str = "") -> None:
        pass

    def on_speed_limit(self, limit: float, *, is_percentage: bool) -> None:
        pass

    def on_keepout_mask(self, mask: Grid) -> None:
        pass

    def on_directed_zones(self, zones: Iterable[DirectedZone]) -> None:
        pass

    # Where the robot is

    @property
    def pose_map(self) -> Pose:
        return self._localiser.pose_map

    @property
    def map_from_odom(self) -> Pose:
        return self._localiser.map_from_odom

    def on_initial_pose(
        self, pose_map: Pose, deviation: tuple[float, float] = START_DEVIATION
    ) -> None:
        self._localiser.initialise(pose_map, deviation)

    def variances(self) -> tuple[float, float, float]:
        return self._localiser.variances()

    def particles(self) -> FloatArray:
        return self._localiser.particles()

    # The map

    def load_map(self, grid: Grid) -> None:
        self.grid = grid
        self.__dict__.pop("_plain_planner", None)

    def clear_costmap(self) -> None:
        pass

    def clear_square(self, centre: Pose, half: float, is_except: bool) -> None:
        pass

    @functools.cached_property
    def _plain_planner(self) -> Planner:
        return Planner(terrain_of(self.config, self.spec, self.grid), self.config.planner)

    def make_plan(self, start: Pose | None, goals: Sequence[Pose]) -> FloatArray:
        poses = (start or self.pose_map, *goals)
        return self._plain_planner.plan_through([(pose.x, pose.y) for pose in poses])

    def smooth(self, points: FloatArray) -> FloatArray:
        return self._plain_planner.smooth(points)

    def is_clear(self, points: FloatArray) -> bool:
        terrain, radius = self._plain_planner.terrain, self.spec.inscribed_radius
        return all(terrain.clearance(x, y) >= radius for x, y in points.tolist())

    def plan_map(self) -> FloatArray:
        return np.zeros((0, 2))

    def local_plan_map(self) -> FloatArray:
        return np.zeros((0, 2))

    def global_costmap(self) -> Costmap:
        grid = self.grid
        costs = np.zeros(grid.cells.shape, np.uint8)
        costs[grid.cells >= OCCUPIED // 2] = LETHAL
        costs[grid.cells == UNKNOWN] = NO_INFORMATION
        return Costmap(costs, grid.resolution, grid.origin_x, grid.origin_y)

    def local_costmap(self) -> Costmap:
        return self.global_costmap()


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
    x, y = pose_map.x, pose_map.y
    corners = min(len(spec.footprint), FOOTPRINT_POINTS)
    words = blank_beacon(spec.footprint).copy()
    pack_head(words, (
        *stamp_from_tick(tick), robot_id, tick, spec.circumscribed_radius,
        x, y, pose_map.yaw, twist.vx, twist.wz,
        0, 0, 0, 0, 0,  # priority, blocked, and for whom it makes way
        FLAG_ACTIVE, MODE_DRIVE if is_driving else MODE_DONE,
        math.nan, math.nan, math.nan, math.nan, 0, 0,  # target, station and gate
        1, 0, 0, corners,
    ))  # fmt: skip
    beacon = record_of(words)
    beacon["held"][0] = (x, y)
    return beacon
