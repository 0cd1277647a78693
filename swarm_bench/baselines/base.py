"""Common part of all baselines: goals, arrival, the others' poses, and the beacon to send."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np

from swarm_bench.baselines.planning import PathTrack, plain_planner
from swarm_common.model.grid import Grid
from swarm_common.model.records import (
    CONTROL_PERIOD,
    FloatArray,
    Odometry,
    Pose,
    RobotSpec,
    Scan,
    Twist,
    wrap_angle,
)
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.plain import PlainBrain
from swarm_nav.control.controller import Controller
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import ErrorCode, Goal, Outcome, Output
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.perception.obstacles import ObstacleLayer

STOP_SHARE = 0.8  # of the goal tolerance at which a robot stops, as our navigator does
STANDING_SPEED = 0.02  # [m/s]
MOST_EXTRAPOLATION = 3  # [ticks] for which a neighbour is assumed to go on as its beacon said


@dataclass(frozen=True, slots=True)
class Others:
    """The other robots heard, at the present tick; arrays have one row per robot."""

    # (k, 2) [m] in map, moved on since the beacons were sent
    places: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    # (k, 2) [m/s] of base_footprint in map
    velocities: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    yaws: FloatArray = field(default_factory=lambda: np.zeros(0))  # (k,) [rad] in map
    turns: FloatArray = field(default_factory=lambda: np.zeros(0))  # (k,) [rad/s]
    radii: FloatArray = field(default_factory=lambda: np.zeros(0))  # (k,) [m]


class Baseline(PlainBrain, ABC):
    """A robot driven by some method."""

    def __init__(
        self,
        config: NavConfig,
        spec: RobotSpec,
        grid: Grid,
        sites: Sites,
        robot_id: int,
        initial_pose_map: Pose,
    ) -> None:
        """Stand at a pose without a goal; arguments as of `Brain`."""
        super().__init__(config, spec, grid, robot_id, initial_pose_map)
        self.radius = spec.circumscribed_radius
        self._others: Others | None = None  # of this tick, once somebody asked
        self._pose = initial_pose_map
        self.obstacles = ObstacleLayer(config.costmap, spec.lidar)
        self._turner = Controller(config.controller)
        self._pending: Goal | None = None
        self._has_arrived = False
        self._planner = plain_planner(grid, config, self.radius)
        self._track: PathTrack | None = None
        self.prepare()

    @property
    def pose(self) -> Pose:
        """Estimated pose in map."""
        return self._pose

    @property
    def others(self) -> Others:
        """The other robots heard."""
        if self._others is None:
            self._others = _others(self.neighbors)
        return self._others

    @property
    def is_standing(self) -> bool:
        """Whether the robot has stopped."""
        return abs(self.twist.vx) < STANDING_SPEED and abs(self.twist.wz) < 0.1

    # What a method decides

    @abstractmethod
    def prepare(self) -> None:
        """Set up what only this method needs; called once, at the end of the construction."""

    @abstractmethod
    def begin(self, target: Pose) -> None:
        """Prepare for a new target.

        Args:
            target: In map; only its position is planned to.
        """

    @abstractmethod
    def drive(self, target: Pose) -> Twist:
        """Return the twist on the way to the target.

        Args:
            target: In map; its position has not been reached.
        """

    @abstractmethod
    def rest(self) -> Twist:
        """Return the twist without a goal."""

    def on_odom(self, odom: Odometry) -> None:
        """Receive the odometry of this tick."""
        super().on_odom(odom)
        self._pose = self.pose_map

    def on_scan(self, scan: Scan) -> None:
        """Receive a scan: mark hits that are neither walls nor known robots.

        Args:
            scan: Ranges of one revolution, also of a LiDAR that is mounted upside down.
        """
        scan = scan.from_above(self.spec.lidar)
        margin = self.config.traffic.safety_margin
        self.obstacles.update(scan, self.pose, self._planner.terrain, self.neighbors, margin)

    def set_goal(self, goal: Goal) -> None:
        """Receive a goal of kind NAVIGATE, for its start tick.

        Args:
            goal: Goal; only the first of its poses is used.
        """
        self._pending = goal

    def cancel_goal(self) -> None:
        """End the current or pending goal, if any."""
        self._goal, self._pending = self._goal or self._pending, None
        super().cancel_goal()

    def tick(self, tick: int) -> Output:
        """Decide.

        Returns:
            The twist to drive, the beacon to send, and what happened since the last tick.
        """
        self.tick_now = tick
        self.overhear(tick)
        self._others = None
        self._begin_pending()
        twist = self._decide()
        events, self._events = tuple(self._events), []
        return Output(twist, self._beacon(), events)

    def overhear(self, tick: int) -> None:
        """Take in what was received of the others up to a tick."""
        self.neighbors.refresh(tick)

    def fail(self, code: ErrorCode, message: str) -> None:
        """Give the current goal up."""
        self._end(Outcome.ABORTED, code, message)

    def _begin_pending(self) -> None:
        goal = self._pending
        if goal is None or goal.start_tick > self.tick_now:
            return
        self._pending = None
        self._goal = goal
        self._has_arrived = False
        self.begin(goal.poses_map[0])

    def _decide(self) -> Twist:
        target = self.target
        if target is None:
            return self.rest()
        if not self._is_at(target):
            return self.drive(target)
        if abs(self.twist.vx) >= STANDING_SPEED:
            return Twist()
        error = wrap_angle(target.yaw - self.pose.yaw)
        if abs(error) > self.config.goal_checker.yaw_goal_tolerance or not self.is_standing:
            return self._turner.turn_to(target.yaw, self.pose, self.twist)
        self._end(Outcome.SUCCEEDED)
        return Twist()

    def _is_at(self, target: Pose) -> bool:
        """Whether the position is reached; once it is, until the tolerance is left again."""
        distance = self.pose.distance(target)
        tolerance = self.config.goal_checker.xy_goal_tolerance
        if distance > tolerance:
            self._has_arrived = False
        elif distance <= STOP_SHARE * tolerance or self.is_standing:
            self._has_arrived = True
        return self._has_arrived


def _others(neighbors: NeighborTable) -> Others:
    """Return where the neighbours are now, if they went on as they did."""
    beacons = neighbors.beacons
    if len(beacons) == 0:
        return Others()
    poses = beacons["pose"].astype(np.float64)
    twists = beacons["twist"].astype(np.float64)
    age = np.minimum(neighbors.ages, MOST_EXTRAPOLATION) * CONTROL_PERIOD
    age = np.where(
        neighbors.ages > MOST_EXTRAPOLATION, 0.0, age
    )  # silent for long: it may have stopped
    yaws = poses[:, 2] + twists[:, 1] * age
    velocities = twists[:, :1] * np.column_stack((np.cos(yaws), np.sin(yaws)))
    places = poses[:, :2] + velocities * age[:, None]
    return Others(places, velocities, yaws, twists[:, 1], beacons["radius"].astype(np.float64))
