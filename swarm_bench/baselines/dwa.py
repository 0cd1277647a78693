"""Baseline A: DWA alone, with global replanning around the robots that are seen.

It does what a single Nav2 robot does: A* once a second with all robots in sight as obstacles, a
dynamic window (Fox, Burgard, Thrun 1997) over the data of LiDAR and beacons, a rotation shim, and
recoveries (turn, wait, back up) when it makes no progress. Beacons only say where the others are
now; nothing is reserved, and no robot has the right of way. It never gives up.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_bench.baselines import baseline_kernels as kernels
from swarm_bench.baselines.base import Baseline
from swarm_bench.baselines.planning import PathTrack, robot_costs, waypoint
from swarm_common.model.records import CONTROL_PERIOD, Pose, Twist, wrap_angle
from swarm_nav.control.dwa_kernels import Limits, Velocity
from swarm_nav.core.goals import PlanError
from swarm_nav.planning.distance_kernels import Place

PADDING = 0.03  # [m] around the robot's circle: half a map cell, and 2 % of slip
LATENCY = 0.2  # [s] of a moving robot's way that is added to its circle: beacon and reaction
SEEN = 2.5  # [m] Nav2's obstacle_max_range: robots up to there enter plan and window
REPLAN_TICKS = 10  # Nav2 replans once a second
LOOKAHEAD = 1.0  # [m] to the point of the path that is steered for
HORIZON_STEPS = 15  # of 0.1 s: 1.5 s, about Nav2's 1.7
SHIM_ANGLE = 0.785  # [rad] of Nav2's rotation shim
ALIGNED = 0.2  # [rad] at which it ends
SCALES = kernels.Weights(heading=0.4, progress=1.0, path=0.8, clearance=0.15, enough=0.3)
SAMPLES = kernels.WindowSamples(8, 21)
NEAR = 1.5  # [m] up to which robots and LiDAR hits can matter within the horizon


class DwaDriver(Baseline):
    """DWA with global replanning."""

    def prepare(self) -> None:
        """Begin without a goal."""
        self._is_turning = False
        self._recovery: Recovery | None = None
        self._progress = (self.pose, 0)
        self._tries = 0

    def begin(self, target: Pose) -> None:
        """Plan in the next tick.

        Args:
            target: In map; it is given again with each `drive`.
        """
        self._track = None
        self._recovery = None
        self._is_turning = False
        self._progress = (self.pose, self.tick_now)
        self._tries = 0

    def rest(self) -> Twist:
        """Stand: nobody can ask a robot of this kind to make way."""
        return Twist()

    def drive(self, target: Pose) -> Twist:
        """Return the twist on the way to the target.

        Args:
            target: In map; its position has not been reached.
        """
        self._check_progress()
        if self._recovery is not None:
            return self._recover(self._recovery)
        if self._track is None or (self.tick_now + self.robot_id) % REPLAN_TICKS == 0:
            self._plan(target)
        if self._track is None:
            return Twist()
        self._track.update(self.pose)
        return self._steer(self._track)

    def _plan(self, target: Pose) -> None:
        """Plan around the robots in sight; where that leaves no way, as if they would move."""
        start, goal = (self.pose.x, self.pose.y), (target.x, target.y)
        self.replans += self._track is not None
        is_near = np.hypot(*(self.others.places - start).T) < SEEN
        places, radii = self.others.places[is_near], self.others.radii[is_near]
        hits = self.obstacles.points
        places = np.vstack((places, hits))
        radii = np.concatenate((radii, np.full(len(hits), PADDING)))
        try:
            extra = robot_costs(self._planner, places, radii, self.radius)
            self._track = PathTrack(self._planner.plan(start, goal, extra))
            return
        except PlanError:
            pass
        try:
            self._track = PathTrack(self._planner.plan(start, goal, self._planner.no_extra()))
        except PlanError as error:
            self.fail(error.code, str(error))

    def _steer(self, track: PathTrack) -> Twist:
        pose, config = self.pose, self.config.controller
        clearance = self.radius + PADDING
        place = waypoint(track, self._planner, pose, LOOKAHEAD, clearance)
        error = wrap_angle(math.atan2(place[1] - pose.y, place[0] - pose.x) - pose.yaw)
        self._is_turning = abs(error) > (ALIGNED if self._is_turning else SHIM_ANGLE)
        if self._is_turning:
            return self._turner.turn_to(pose.yaw + error, pose, self.twist)
        v, w, _ = kernels.best_twist(
            Place(pose.x, pose.y, pose.yaw),
            Velocity(self.twist.vx, self.twist.wz),
            place,
            Limits(config.max_vel_x, config.max_vel_theta, config.acc_lim_x, config.acc_lim_theta),
            SAMPLES,
            clearance,
            self._obstacles(),
            np.ascontiguousarray(track.ahead(LOOKAHEAD)[::2]),
            SCALES,
            HORIZON_STEPS,
        )
        return Twist(float(v), 0.0, float(w))

    def _obstacles(self) -> kernels.Obstacles:
        """Return what the window is checked against, as the kernels take it."""
        terrain, others, pose = self._planner.terrain, self.others, self.pose
        speeds = np.hypot(others.velocities[:, 0], others.velocities[:, 1])
        discs = np.column_stack((others.places, others.radii + LATENCY * speeds))
        is_near = np.hypot(discs[:, 0] - pose.x, discs[:, 1] - pose.y) < NEAR
        hits = self.obstacles.points
        hits = hits[np.hypot(hits[:, 0] - pose.x, hits[:, 1] - pose.y) < NEAR]
        reach = self.config.costmap.unknown_body_margin
        return kernels.Obstacles(
            terrain.distance,
            terrain.frame,
            np.ascontiguousarray(discs[is_near]),
            np.ascontiguousarray(hits),
            reach,
        )

    # Recoveries

    def _check_progress(self) -> None:
        checker = self.config.progress_checker
        pose, tick = self._progress
        if self.pose.distance(pose) >= checker.required_movement_radius:
            self._progress = (self.pose, self.tick_now)
            self._tries = 0
        elif (self.tick_now - tick) * CONTROL_PERIOD > checker.movement_time_allowance:
            self._progress = (self.pose, self.tick_now)
            self._recovery = Recovery(RECOVERIES[self._tries % len(RECOVERIES)], self)
            self._tries += 1
            self.recoveries += 1
            self._track = None

    def _recover(self, recovery: Recovery) -> Twist:
        twist = recovery.step(self)
        if twist is None:
            self._recovery = None
            self._progress = (self.pose, self.tick_now)
            return Twist()
        return twist

    def turn_to(self, yaw: float) -> Twist:
        """Return the twist that turns towards `yaw` on the spot.

        Args:
            yaw: [rad] in map.
        """
        return self._turner.turn_to(yaw, self.pose, self.twist)

    def can_back_up(self, way: float) -> bool:
        """Whether there is room to back up.

        Args:
            way: [m], positive.
        """
        pose = self.pose
        place = Place(pose.x, pose.y, pose.yaw)
        return bool(kernels.backing_room(place, way, self.radius + PADDING, self._obstacles()))


RECOVERIES = ("turn", "wait", "back up")  # the order of Nav2's behaviour tree


class Recovery:
    """One of Nav2's recovery behaviours."""

    def __init__(self, kind: str, robot: DwaDriver) -> None:
        """Begin where the robot is now.

        Args:
            kind: One of `RECOVERIES`.
        """
        behavior = robot.config.behavior
        self._kind = kind
        self._start = robot.pose
        self._yaw = robot.pose.yaw + behavior.spin_dist
        self._end_tick = robot.tick_now + round(behavior.wait_duration / CONTROL_PERIOD)

    def step(self, robot: DwaDriver) -> Twist | None:
        """Return the next twist; None when it is over.

        Args:
            robot: The same, in its present tick.
        """
        if robot.tick_now >= self._end_tick:
            return None
        if self._kind == "wait":
            return Twist()
        if self._kind == "turn":
            is_turned = abs(wrap_angle(self._yaw - robot.pose.yaw)) < ALIGNED
            return None if is_turned else robot.turn_to(self._yaw)
        behavior = robot.config.behavior
        rest = behavior.backup_dist - robot.pose.distance(self._start)
        if rest <= 0.0 or not robot.can_back_up(min(rest, 0.1)):
            return None
        return Twist(-behavior.backup_speed)
