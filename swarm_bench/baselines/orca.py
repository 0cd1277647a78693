"""Baseline B: ORCA (van den Berg, Guy, Lin, Manocha 2011; library RVO2 by pyrvo).

Each robot computes its own velocity from the beacons that it hears, as ORCA is meant to. A
differential drive is made holonomic by steering a point `OFFSET` ahead of its axle (the effective
centre: Snape, van den Berg, Guy, Manocha 2010): the circle around that point is larger by the
offset and covers the robot. The preferred velocity leads along the A* path of the map; walls are
the polygons of the map; a small random part breaks symmetries, as in RVO2's examples. A robot
without a goal has the preferred velocity zero and so makes way.
"""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np

from swarm_bench.baselines import baseline_kernels as kernels
from swarm_bench.baselines.base import Baseline
from swarm_bench.baselines.outlines import wall_outlines
from swarm_bench.baselines.planning import PathTrack, robot_costs, waypoint
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import CONTROL_PERIOD, Pose, Twist
from swarm_nav.core.goals import PlanError
from swarm_nav.planning.distance_kernels import Place

OFFSET = 0.1  # [m] of the steered point ahead of the axle
HORIZON = 3.0  # [s] for which robots keep clear of each other (tau)
WALL_HORIZON = 1.0  # [s] likewise of walls
NEIGHBOR_DISTANCE = 6.0  # [m] the radio's range
MAX_NEIGHBORS = 12
LOOKAHEAD = 1.0  # [m] to the point of the path that the preferred velocity leads to
SLOW_DOWN = 0.3  # [m] from the goal at which the preferred speed begins to fall
JITTER = 0.01  # of the speed: random part of the preferred velocity
REPLAN_TICKS = 10  # between two looks at whether the path is still of use
WALL_PADDING = 0.01  # [m]
NO_DISCS, NO_POINTS = np.zeros((0, 3)), np.zeros((0, 2))
NOWHERE = 1e4  # [m] where agents are that stand for nobody


class OrcaDriver(Baseline):
    """Optimal reciprocal collision avoidance along a global path."""

    def prepare(self) -> None:
        """Begin without a goal."""
        self._random = random.Random(f"orca/{self.robot_id}")
        self._simulator = _simulator(
            self.grid, self.radius + OFFSET, self.config.controller.max_vel_x
        )

    def begin(self, target: Pose) -> None:
        """Plan in the next tick.

        Args:
            target: In map; it is given again with each `drive`.
        """
        self._track = None

    def rest(self) -> Twist:
        """Make way where others come near."""
        return self._avoid((0.0, 0.0))

    def drive(self, target: Pose) -> Twist:
        """Return the twist on the way to the target.

        Args:
            target: In map; its position has not been reached.
        """
        is_due = (self.tick_now + self.robot_id) % REPLAN_TICKS == 0
        if self._track is not None and is_due and self._track.is_lost(self.pose):
            self._track = None
            self.replans += 1
        if self._track is None or (is_due and len(self.obstacles.points)):
            self._plan(target)
        if self._track is None:
            return Twist()
        self._track.update(self.pose)
        clearance = self.radius + OFFSET
        place = waypoint(self._track, self._planner, self.pose, LOOKAHEAD, clearance)
        return self._avoid(self._preferred(place, self._track.rest))

    def _plan(self, target: Pose) -> None:
        """Plan on the map and around what the LiDAR sees beside robots."""
        hits = self.obstacles.points
        margins = np.full(len(hits), self.config.costmap.unknown_body_margin)
        start, goal = (self.pose.x, self.pose.y), (target.x, target.y)
        try:
            extra = robot_costs(self._planner, hits, margins, self.radius)
            self._track = PathTrack(self._planner.plan(start, goal, extra))
        except PlanError as error:
            if not len(hits):
                self.fail(error.code, str(error))

    def _preferred(self, place: tuple[float, float], rest: float) -> tuple[float, float]:
        x, y = self._steered_point()
        dx, dy = place[0] - x, place[1] - y
        distance = max(1e-6, math.hypot(dx, dy))
        top = self.config.controller.max_vel_x
        speed = top * min(1.0, max(rest, distance) / SLOW_DOWN)
        angle = self._random.uniform(0.0, 2.0 * math.pi)
        jitter = JITTER * top * self._random.random()
        return (
            speed * dx / distance + jitter * math.cos(angle),
            speed * dy / distance + jitter * math.sin(angle),
        )

    def _steered_point(self) -> tuple[float, float]:
        pose = self.pose
        return pose.x + OFFSET * math.cos(pose.yaw), pose.y + OFFSET * math.sin(pose.yaw)

    def _avoid(self, preferred: tuple[float, float]) -> Twist:
        """Return the twist whose point moves as ORCA says."""
        pose, twist, simulator = self.pose, self.twist, self._simulator
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        side = OFFSET * twist.wz
        simulator.set_agent_position(0, self._steered_point())
        simulator.set_agent_velocity(0, (twist.vx * cos - side * sin, twist.vx * sin + side * cos))
        simulator.set_agent_pref_velocity(0, preferred)
        self._place_others()
        simulator.do_step()
        x, y = simulator.get_agent_velocity(0).to_tuple()
        return self._stopped_by_walls(self.limited(x * cos + y * sin, (y * cos - x * sin) / OFFSET))

    def _stopped_by_walls(self, twist: Twist) -> Twist:
        """Return the twist without its speed if the robot could not stop before a wall.

        ORCA's constraints hold for velocities that are there at once; this drive ramps.
        """
        pose, terrain = self.pose, self._planner.terrain
        obstacles = kernels.Obstacles(terrain.distance, terrain.frame, NO_DISCS, NO_POINTS, 0.0)
        place = Place(pose.x, pose.y, pose.yaw)
        acc = self.config.controller.acc_lim_x
        if kernels.can_stop(place, twist.vx, twist.wz, acc, self.radius + WALL_PADDING, obstacles):
            return twist
        return Twist(0.0, 0.0, twist.wz)

    def limited(self, v: float, w: float) -> Twist:
        """Return a twist within the limits that moves the point in the same direction.

        Args:
            v: [m/s] ahead.
            w: [rad/s], counter-clockwise.
        """
        config = self.config.controller
        excess = max(1.0, abs(v) / config.max_vel_x, abs(w) / config.max_vel_theta)
        return Twist(v / excess, 0.0, w / excess)

    def _place_others(self) -> None:
        others, simulator, pose = self.others, self._simulator, self.pose
        gaps = np.hypot(others.places[:, 0] - pose.x, others.places[:, 1] - pose.y)
        nearest = np.argsort(gaps, kind="stable")[:MAX_NEIGHBORS]
        heading = np.column_stack((np.cos(others.yaws), np.sin(others.yaws)))
        points = others.places + OFFSET * heading
        across = np.column_stack((-heading[:, 1], heading[:, 0]))
        velocities = others.velocities + OFFSET * others.turns[:, None] * across
        for agent, row in enumerate(nearest, 1):
            simulator.set_agent_position(agent, points[row].tolist())
            simulator.set_agent_velocity(agent, velocities[row].tolist())
            simulator.set_agent_radius(agent, float(others.radii[row]) + OFFSET)
        for agent in range(len(nearest) + 1, MAX_NEIGHBORS + 1):
            simulator.set_agent_position(agent, (NOWHERE, NOWHERE + agent))


def _simulator(grid: Grid, radius: float, max_speed: float) -> Any:
    """Return an RVO2 simulator: agent 0 is the robot, the others stand for neighbours.

    Agents are kept and moved: the library has no safe way to remove them.
    """
    try:
        import pyrvo
    except ImportError:
        raise ConfigError(
            "method orca needs the package pyrvo; install it: pip install pyrvo"
        ) from None
    simulator = pyrvo.RVOSimulator(
        CONTROL_PERIOD, NEIGHBOR_DISTANCE, MAX_NEIGHBORS, HORIZON, WALL_HORIZON, radius, max_speed
    )
    for outline in wall_outlines(grid):
        simulator.add_obstacle(outline.tolist())
    simulator.process_obstacles()
    for agent in range(MAX_NEIGHBORS + 1):
        simulator.add_agent((NOWHERE, NOWHERE + agent))
        if agent > 0:  # nobody asks what the neighbours would do
            simulator.set_agent_max_neighbors(agent, 0)
            simulator.set_agent_time_horizon_obst(agent, 1e-3)
    return simulator
