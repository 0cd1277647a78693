"""Compile, or load from numba's disk cache, every kernel before robots are forked."""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.beacon import FOOTPRINT_POINTS
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import LidarSpec, Odometry, Pose, RobotSpec, Scan, Twist
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.control import tube_kernels
from swarm_nav.control.omni import OmniController
from swarm_nav.control.tube import Tube
from swarm_nav.core.config import ControllerConfig, NavConfig, TrafficConfig
from swarm_nav.core.goals import Goal, GoalKind
from swarm_nav.core.localisation_config import AMCL, LocalisationConfig
from swarm_nav.perception.absence import JUDGED_EVERY
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.perception.obstacle_kernels import Beam
from swarm_nav.planning import path_cost_kernels
from swarm_nav.planning.distance_kernels import Place
from swarm_nav.traffic import gate_kernels, traffic_costs
from swarm_nav.traffic.gate import Gate
from swarm_nav.traffic.holding import parking_path
from swarm_nav.traffic.right_of_way import GAIN, SLACK, refuge_path, way_of
from swarm_nav.traffic.single_lane_kernels import (
    barrier,
    entry_of,
    flood,
    half_width,
    label,
    places,
)
from swarm_nav.traffic.single_lanes import SingleLanes
from swarm_nav.traffic.situation import Situation

TICKS = 60


def warm_up() -> None:
    """Let two robots meet in a small room, so that each kernel runs once with its real types."""
    cells = np.zeros((80, 80), np.int8)
    cells[0, :] = cells[-1, :] = cells[:, 0] = cells[:, -1] = OCCUPIED
    grid = Grid(cells, 0.05, 0.0, 0.0)
    side = 0.15
    spec = RobotSpec(
        model="warm_up",
        drive="differential",
        max_vel_x=0.26,
        max_vel_theta=1.82,
        acc_lim_x=1.0,
        acc_lim_theta=3.2,
        wheel_radius=0.033,
        wheel_separation=0.287,
        footprint=((-side, -side), (side, -side), (side, side), (-side, side)),
        lidar=LidarSpec(0.0, 0.0, 0.1),
        height=0.1,
    )
    poses = [Pose(1.0, 2.0, 0.0), Pose(3.0, 2.0, math.pi)]
    sites = Sites(stations={"a": poses[0], "b": poses[1]})
    robots = [
        Navigator(NavConfig(), spec, grid, sites, index + 1, pose)
        for index, pose in enumerate(poses)
    ]
    for index, robot in enumerate(robots):
        robot.set_goal(Goal(kind=GoalKind.NAVIGATE, poses_map=(poses[1 - index],)))
    _drive(robots)
    config = NavConfig(localisation=LocalisationConfig(type=AMCL))
    _localise(Navigator(config, spec, grid, sites, 3, poses[0]))
    situation = robots[0]._s
    situation.neighbors.refresh(TICKS)
    refuge_path(situation, way_of(situation, 0), situation.reach(0), situation.priority + 1)
    parking_path(situation, [(1.0, 1.0)])
    extra = traffic_costs.congestion(situation)
    situation.planner.cost_of(np.zeros((2, 2)), extra)
    way = np.zeros((2, 2), np.float32)
    path_cost_kernels.clears(np.zeros((3, 2)), way, situation.radius, SLACK, GAIN)
    situation.neighbors.queue(np.ones((1, 2)), 1, 1.0)
    _pass_gate(situation)
    _pass_door(situation)
    _drive_sideways()
    _fall_silent(robots[1])
    robots[0].global_costmap()
    robots[0].local_costmap()


def _localise(robot: Navigator) -> None:
    for tick in range(20, 26, 2):  # once the robots around are known
        robot.on_odom(Odometry(tick, Pose(0.0, 0.0, 0.0), Twist()))
        robot.on_scan(Scan(tick, 0.0, math.tau / 360, 0.12, 3.5, np.full(360, 1.0, np.float32)))
    robot.particles()
    s = robot._s
    tube_kernels.first_overlap(s.tube.points, 0, 0, s.radius, 0.0, s.neighbors.columns())


def _fall_silent(robot: Navigator) -> None:
    """Let a robot fall silent far away, and be looked for near its place."""
    beacon = robot.tick(TICKS).beacon
    neighbors = NeighborTable(9, TrafficConfig())
    neighbors.receive(np.array([beacon]), 0.0, 9.0)
    looks = [TICKS + wait + k for wait in (40, 200) for k in range(JUDGED_EVERY)]
    for tick in (TICKS, *looks):
        neighbors.refresh(tick)
        neighbors.receive(np.zeros(0, beacon.dtype), 2.0, 2.0)
    neighbors.receive(np.array([beacon]), 2.0, 2.0)
    for tick in (TICKS + 300, TICKS + 400):
        neighbors.refresh(tick)
    neighbors.passed_by()
    neighbors.row(2)
    ranges = np.full(360, 1.0, np.float32)
    footprint = np.zeros(2 * FOOTPRINT_POINTS, np.uint32)
    beam = Beam(0.0, math.tau / 360, 0.12)
    neighbors.look(ranges, beam, Place(2.0, 2.0, 0.0), 3.0, (footprint, 0.1))


def _drive_sideways() -> None:
    controller = OmniController(ControllerConfig(max_vel_y=0.2, acc_lim_y=1.0))
    start = Pose(0.0, 0.0, 0.0)
    tube = Tube(start, 1, 0.35, 0.35)
    tube.adopt(np.array([(0.0, 0.05 * k) for k in range(8)]))
    tube.stop = 4
    controller.follow(tube, start, controller.course(Twist()))


def _pass_gate(situation: Situation) -> None:
    region = np.ones(situation.planner.lattice.base.shape, np.int16)
    gate = Gate(region)
    gate.update(situation, has_turn=True, is_driving=True, priority=lambda: 1)
    for cells in (region, region > 0):
        gate_kernels.entry(cells, situation.planner.lattice.frame, situation.tube.points)
    gate._ahead(situation, 1)
    gate._look_at(situation)
    gate._seen_inside(situation)


def _pass_door(situation: Situation) -> None:
    shape = situation.planner.lattice.base.shape
    half_width(situation.planner.lattice.clearance, 0.1, np.empty(shape))
    labels = np.zeros(shape, np.int16)
    floor = np.ones(shape, np.bool_)
    label(floor, labels)
    flood(floor, labels, 0, 0)
    places(floor, 6.0, 1)
    narrows = SingleLanes()
    narrows.barrier(situation, situation.tube.stop)
    frame, claims = situation.planner.lattice.frame, situation.neighbors.columns()
    entry_of(labels, frame, np.zeros((2, 2)), 1)
    barrier(labels, frame, np.zeros((2, 2)), 1, (0, 1, 0), 0, claims)


def _drive(robots: list[Navigator]) -> None:
    beacons = None
    places = [Pose(0.0, 0.0, 0.0) for _ in robots]
    twists = [Twist() for _ in robots]
    for tick in range(TICKS):
        published = []
        for index, robot in enumerate(robots):
            robot.on_odom(Odometry(tick, places[index], twists[index]))
            if beacons is not None:
                robot.on_neighbors(beacons[1 - index : 2 - index])
            ranges = np.full(360, 1.0 if tick % 4 else np.inf, np.float32)
            robot.on_scan(Scan(tick, 0.0, math.tau / 360, 0.12, 3.5, ranges))
            output = robot.tick(tick)
            twists[index] = output.twist
            step = Pose(0.1 * output.twist.vx, 0.0, 0.1 * output.twist.wz)
            places[index] = places[index].compose(step)
            published.append(output.beacon)
        beacons = np.array(published)
