"""State of the robot at the present tick, which all parts of one navigator share."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from swarm_common.model.grid import Grid
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, RobotSpec, Twist
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.zones import DirectedZone
from swarm_nav.core.config import NavConfig, PlannerConfig
from swarm_nav.core.rank import Donations
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.perception.obstacles import ObstacleLayer
from swarm_nav.planning.oblong import Oblong
from swarm_nav.planning.planner import SPACING, Planner
from swarm_nav.planning.terrain import Terrain, as_large_as, terrain_for
from swarm_nav.reservation import tube_kernels
from swarm_nav.reservation.stop_filter_kernels import last_to_keep
from swarm_nav.reservation.tube import TOLERANCE, Tube
from swarm_nav.traffic.patience import Patience
from swarm_nav.traffic.robot_view import Counters

PlannerMaker = Callable[[Terrain, PlannerConfig], Planner]
WAITING_TICKS = 10  # ticks of being blocked after which a robot says that it waits
FEWEST_BRAKE_POINTS = 2  # path points kept ahead of a robot that gives up its claim


@functools.lru_cache(maxsize=256)
def ticks_of(seconds: float) -> int:
    """Return a duration in control ticks.

    Args:
        seconds: [s]
    """
    return max(1, round(seconds / CONTROL_PERIOD))


@dataclass(slots=True)
class RobotState:
    """State of one robot that the parts of its navigator share; each field has one writer."""

    robot_id: int  # from 1
    names: RobotNames  # of all robots, for people
    config: NavConfig  # parameters, by `Arbiter`
    body_radius: float  # [m] circumscribed radius
    terrain: Terrain  # the map as this robot sees it, by `Arbiter`
    planner: Planner  # on this terrain
    neighbors: NeighborTable  # what is known of the neighbours
    obstacles: ObstacleLayer  # what the LiDAR sees beyond map and neighbours
    tube: Tube  # path, held and requested space
    pose: Pose  # in map, by the navigator
    radius: float  # [m] safety radius: `body_radius` plus the margin, by `Arbiter`
    # map and safety radius that tell where two robots pass each other, by `record_bodies`
    passing: tuple[Terrain, float]
    make_planner: PlannerMaker = Planner  # of a terrain, by the parameters
    directed: tuple[DirectedZone, ...] = ()  # zones in which ways to goals have a direction
    is_led: bool = False  # whether a centre decides for it now, by the rule that obeys it
    led_standing: int = (
        0  # ticks for which it has stood then, and no robot was in its way; likewise
    )
    oblong: Oblong | None = None  # outline of a long robot, which plans with it; None for others
    stations: tuple[tuple[float, float], ...] = ()  # (x, y) in map that many robots go to
    radio: Patience = field(default_factory=Patience)  # how slow the radio is
    counters: Counters = field(default_factory=Counters)  # for the report; each part its own
    donations: Donations = field(default_factory=Donations)  # ranks that it inherits
    tick: int = 0  # now, by the navigator
    velocity: Twist = field(default_factory=Twist)  # as odometry measures it
    twist: Twist = field(default_factory=Twist)  # in base_footprint, vx along the course
    # as in the last beacon, without what pushing robots pass on; by `Arbiter`
    own_priority: int = 0
    priority: int = 0  # as in the last beacon
    listening_since: int = 0  # tick since which the radio is heard without a gap, by `Senses`
    # By `Arbiter`: ticks for which the tube could not grow because of a robot, its id
    # (0 for none), and what it does, for people.
    blocked_ticks: int = 0
    blocked_by: int = 0
    blocked_why: str = ""
    is_unconfirmed: bool = False  # the tube did not grow because a request is not acknowledged yet
    obstacle_ticks: int = 0  # for which it could not grow because of something else in the way
    has_grown: bool = False  # in the last tick

    ticks = staticmethod(ticks_of)

    @property
    def retry_ticks(self) -> int:
        """`traffic.retry_time` in ticks: as all these, longer over a slow radio."""
        return ticks_of(self.config.traffic.retry_time) + self.radio.extra

    @property
    def wait_ticks(self) -> int:
        """`traffic.wait_time` in ticks."""
        return ticks_of(self.config.traffic.wait_time) + self.radio.extra

    @property
    def stuck_ticks(self) -> int:
        """`traffic.stuck_time` in ticks."""
        return ticks_of(self.config.traffic.stuck_time) + self.radio.extra

    @property
    def waited_ticks(self) -> int:
        """Ticks for which the tube could not grow, because of a robot or of anything else."""
        return max(self.blocked_ticks, self.obstacle_ticks)

    @property
    def awaited(self) -> str:
        """Description of what the robot has stood before for a while; empty for nothing."""
        if self.blocked_ticks > WAITING_TICKS:
            return f"for {self.names.name_of(self.blocked_by)}, which {self.blocked_why}"
        if self.obstacle_ticks > WAITING_TICKS:
            return "before an obstacle"
        return "for the centre" if self.led_standing > WAITING_TICKS else ""

    @property
    def unproductive_ticks(self) -> int:
        """Ticks of waiting for what makes no way: a silent robot, a served one, or an obstacle."""
        row = self.neighbors.row(self.blocked_by) if self.blocked_ticks else None
        neighbors = self.neighbors
        is_immovable = row is not None and bool(neighbors.immovable[row] | neighbors.served[row])
        return max(self.obstacle_ticks, self.blocked_ticks if is_immovable else 0)

    def record_bodies(self) -> None:
        """Set where two robots pass each other, by the largest robot heard so far.

        Where robots of one swarm do not agree, small ones wait in a queue on what large ones take
        for a single lane.
        """
        terrain = as_large_as(self.terrain, self.neighbors.largest_body)
        self.passing = terrain, terrain.radius + self.config.traffic.safety_margin

    @property
    def usual_radius(self) -> float:
        """Safety radius [m] of a robot that knows where it is."""
        return self.body_radius + self.config.traffic.safety_margin

    def reach(self, row: int) -> float:
        """Return the distance [m] that the own tube and a neighbour's keep."""
        return self.radius + self.neighbors.radius(row)

    @property
    def braking_way(self) -> float:
        """[m] that the robot needs to stop, a control period of delay included."""
        return self.way_to_stop(self.speed)

    @property
    def speed(self) -> float:
        """[m/s] of the robot, in whatever direction."""
        return math.hypot(self.twist.vx, self.twist.vy)

    @property
    def acceleration(self) -> float:
        """[m/s²] with which the robot brakes, in whatever direction."""
        limits = self.config.controller
        return min(limits.acc_lim_x, limits.acc_lim_y) if limits.acc_lim_y else limits.acc_lim_x

    def way_to_stop(self, speed: float) -> float:
        """Return the way [m] from a speed [m/s] to standstill, with a control period of delay."""
        return speed * CONTROL_PERIOD + speed * speed / (2.0 * self.acceleration)

    @property
    def brake_points(self) -> int:
        """Path points kept ahead of a robot that gives up its claim."""
        return max(FEWEST_BRAKE_POINTS, math.ceil(self.braking_way / SPACING))

    def last_needed(self, near: int, last: int) -> int:
        """Return the first point from `last` on up to which the robot can stop, or the held end.

        Args:
            near: Index of the path point nearest to it.
            last: Index of the path point from which the space is to be given up.
        """
        tube, pose, limits = self.tube, self.pose, self.config.controller
        if last >= tube.stop:
            return tube.stop
        at, way = (pose.x, pose.y), 0.0 if self.is_standing else self.braking_way
        ahead = tube_kernels.point_beyond(tube.points, near, tube.stop, at, way)
        now = self.velocity
        return int(
            last_to_keep(
                (pose.x, pose.y, pose.yaw),
                (now.vx, now.vy, now.wz),
                (limits.acc_lim_x, limits.acc_lim_y, limits.acc_lim_theta, CONTROL_PERIOD),
                (tube.points, tube.tail, tube.stop, TOLERANCE),
                max(last, ahead),
            )
        )

    def points_kept_for(self, path: FloatArray) -> int | None:
        """Return how many points ahead stay held when the robot turns back; None if it does not.

        Args:
            path: (n, 2) [m] in map, from the stop point.
        """
        tube = self.tube
        if tube.stop - tube.near <= self.brake_points or len(path) < 3:
            return None
        arriving = tube.points[tube.stop] - tube.points[tube.stop - 2]
        if (arriving * (path[2] - path[0])).sum() >= 0.0:
            return None
        keep = self.brake_points if abs(self.twist.vx) > 0.05 else 0
        return keep if self._stop_after_release(keep) < tube.stop else None

    def stop_point_after(self, keep: int) -> tuple[float, float]:
        """Return where plans start once only `keep` points ahead of the robot are held."""
        x, y = self.tube.points[self._stop_after_release(keep)].tolist()
        return x, y

    def _stop_after_release(self, keep: int) -> int:
        tube = self.tube
        near = tube.nearest(self.pose, min(tube.next_corner(), tube.stop))
        return self.last_needed(near, near + keep)

    @property
    def stop_point(self) -> tuple[float, float]:
        """Committed stop point, from which plans start."""
        return self.tube.stop_point

    @property
    def is_standing(self) -> bool:
        """Whether the robot has stopped."""
        return abs(self.twist.vx) < 0.02 and abs(self.twist.wz) < 0.1

    def distance_to(self, x: float, y: float) -> float:
        """Return the distance [m] from the robot to a point in map.

        Args:
            x: [m] in map.
            y: [m] in map.
        """
        return math.hypot(self.pose.x - x, self.pose.y - y)

    @property
    def obstacle_clearance(self) -> float:
        """Distance [m] that the robot's centre keeps from unexplained LiDAR hits."""
        costmap = self.config.costmap
        return self.body_radius + costmap.footprint_padding + costmap.unknown_body_margin

    @property
    def is_confined(self) -> bool:
        """Whether a long robot stands where it cannot turn."""
        if self.oblong is None:
            return False
        x, y = self.pose.x, self.pose.y
        is_near = self.terrain.clearance(x, y) < self.body_radius
        return is_near and not self.terrain.is_in_keepout(x, y, self.body_radius)

    def obstacle_clearances(self, points: FloatArray) -> FloatArray:
        """Return the `obstacle_clearance` (n,) of path points; less where a long robot is straight.

        Args:
            points: (n, 2) [m] in map.
        """
        clearance = np.full(len(points), self.obstacle_clearance)
        if self.oblong is not None and self.tube.slots is not None:
            is_slot = self.tube.slots.is_slot(points)
            clearance[is_slot] += self.oblong.half_width - self.body_radius
        return clearance

    def obstacle_points(self) -> FloatArray:
        """Return the unexplained points (k, 2) in map."""
        return self.obstacles.points


COMPILED = False  # see `TubeView` in `swarm_nav.reservation.tube`
if TYPE_CHECKING and not COMPILED:
    from swarm_nav.traffic.robot_view import RobotView as RobotView
else:
    RobotView = RobotState


def terrain_of(config: NavConfig, spec: RobotSpec, grid: Grid) -> Terrain:
    """Return the terrain that a robot derives from a map; equal ones in one process share it.

    Raises:
        MapError: If the map has too many cells when it is divided into finer ones.
    """
    body = spec.circumscribed_radius
    return terrain_for(grid, config.planner, config.costmap, body, Oblong.of(spec))


def initial_state(
    config: NavConfig,
    spec: RobotSpec,
    grid: Grid,
    robot_id: int,
    pose_map: Pose,
    stations: tuple[tuple[float, float], ...] = (),
    names: RobotNames | None = None,
    make_planner: PlannerMaker = Planner,
) -> RobotState:
    """Return the state of a robot that stands at a pose and knows of no other robot yet.

    Args:
        robot_id: From 1.
        stations: (x, y) [m] in map that many robots go to.
        names: Names of all robots, for people; None for the usual ones.

    Raises:
        MapError: If the map has too many cells when it is divided into finer ones.
    """
    body = spec.circumscribed_radius
    terrain = terrain_of(config, spec, grid)
    traffic = config.traffic
    tube = Tube(pose_map, traffic.confirmations, traffic.held_length, traffic.wanted_length)
    tube.corner_angle = config.controller.corner_angle
    tube.slots = terrain.lattice.slots
    return RobotState(
        robot_id=robot_id,
        names=names or RobotNames(),
        config=config,
        body_radius=body,
        radius=body + traffic.safety_margin,
        passing=(terrain, body + traffic.safety_margin),
        terrain=terrain,
        planner=make_planner(terrain, config.planner),
        make_planner=make_planner,
        neighbors=NeighborTable(robot_id, traffic),
        obstacles=ObstacleLayer(config.costmap, spec.lidar, spec.footprint),
        tube=tube,
        pose=pose_map,
        oblong=Oblong.of(spec),
        stations=stations,
    )
