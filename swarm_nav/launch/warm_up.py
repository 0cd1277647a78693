"""Compile, or load from numba's disk cache, every kernel before robots are forked."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from swarm_common.middleware.radio_check import read_neighbors
from swarm_common.model.beacon import FOOTPRINT_POINTS, reception_of, serialize_neighbors
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import LidarSpec, Odometry, Pose, RobotSpec, Scan, Twist
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.control.omni import OmniController
from swarm_nav.core.config import ControllerConfig, NavConfig, TrafficConfig
from swarm_nav.core.goals import Goal, GoalKind
from swarm_nav.core.localisation_config import AMCL, LocalisationConfig
from swarm_nav.core.rank import passed_on
from swarm_nav.perception.absence import JUDGED_EVERY
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.perception.obstacle_kernels import Beam
from swarm_nav.planning import path_cost_kernels
from swarm_nav.planning.distance_kernels import Place
from swarm_nav.reservation import tube_kernels
from swarm_nav.reservation.tube import Tube
from swarm_nav.traffic import gate_kernels, traffic_costs
from swarm_nav.traffic.departure import highest_asking
from swarm_nav.traffic.gate import Gate
from swarm_nav.traffic.holding import parking_path
from swarm_nav.traffic.right_of_way import GAIN, SLACK, refuge_path, way_of
from swarm_nav.traffic.robot_state import RobotState
from swarm_nav.traffic.single_lane_kernels import barrier, entry_of, flood, half_width, places
from swarm_nav.traffic.single_lanes import SingleLanes

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
    navigators = [
        Navigator(NavConfig(), spec, grid, sites, index + 1, pose)
        for index, pose in enumerate(poses)
    ]
    for index, navigator in enumerate(navigators):
        navigator.set_goal(Goal(kind=GoalKind.NAVIGATE, poses_map=(poses[1 - index],)))
    _drive(navigators)
    _drive_long(grid, spec)
    config = NavConfig(localisation=LocalisationConfig(type=AMCL))
    _localise(Navigator(config, spec, grid, sites, 3, poses[0]))
    robot = navigators[0]._s
    robot.neighbors.refresh(TICKS)
    way = way_of(robot, 0)
    refuge_path(robot, robot.stop_point, way, robot.reach(0), robot.priority + 1)
    parking_path(robot, [(1.0, 1.0)])
    extra = traffic_costs.congestion(robot)
    robot.planner.cost_of(np.zeros((2, 2)), extra)
    way = np.zeros((2, 2), np.float32)
    path_cost_kernels.clears(np.zeros((3, 2)), way, robot.radius, SLACK, GAIN)
    robot.neighbors.queue(np.ones((1, 2)), 1, 1.0)
    _be_pushed(navigators)
    _pass_gate(robot)
    _pass_door(robot)
    _drive_sideways()
    _fall_silent(navigators[1])
    navigators[0].services.global_costmap()
    navigators[0].services.local_costmap()


def _localise(navigator: Navigator) -> None:
    for tick in range(20, 26, 2):  # once the robots around are known
        navigator.on_odom(Odometry(tick, Pose(0.0, 0.0, 0.0), Twist()))
        navigator.on_scan(Scan(tick, 0.0, math.tau / 360, 0.12, 3.5, np.full(360, 1.0, np.float32)))
    navigator.services.particles()
    s = navigator._s
    tube_kernels.first_overlap(s.tube.points, 0, 0, s.radius, 0.0, s.neighbors.claims())


def _fall_silent(navigator: Navigator) -> None:
    """Let a robot fall silent far away, and be looked for near its place."""
    beacon = navigator.tick(TICKS).beacon
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
    neighbors.clear_empty_places(ranges, beam, Place(2.0, 2.0, 0.0), 3.0, (footprint, 0.1))


def _drive_sideways() -> None:
    controller = OmniController(ControllerConfig(max_vel_y=0.2, acc_lim_y=1.0))
    start = Pose(0.0, 0.0, 0.0)
    tube = Tube(start, 1, 0.35, 0.35)
    tube.adopt(np.array([(0.0, 0.05 * k) for k in range(8)]))
    tube.stop = 4
    tube.track(start)
    controller.follow(tube, start, controller.course(Twist()))


def _drive_long(grid: Grid, spec: RobotSpec) -> None:
    """Let a long robot drive through a passage that is too narrow for its circle."""
    cells = grid.cells.copy()
    cells[:33, 32:52] = cells[47:, 32:52] = OCCUPIED
    footprint = ((-0.4, -0.2), (0.4, -0.2), (0.4, 0.2), (-0.4, 0.2))
    start = Pose(1.0, 2.0, 0.0)
    narrow = Grid(cells, grid.resolution, 0.0, 0.0)
    robot = Navigator(NavConfig(), replace(spec, footprint=footprint), narrow, Sites(), 1, start)
    robot.set_goal(Goal(kind=GoalKind.NAVIGATE, poses_map=(Pose(3.2, 2.0, 0.0),)))
    _drive([robot])


def _be_pushed(navigators: list[Navigator]) -> None:
    """Let a robot hear of another one that it blocks, and make way for it by the shortest path."""
    beacon = navigators[1].tick(TICKS).beacon
    beacon["blocked_by"], beacon["blocked_ticks"] = 1, 1000
    robot = navigators[0]._s
    neighbors = robot.neighbors
    neighbors.receive(np.array([beacon]), 1.0, 2.0)
    neighbors.refresh(TICKS)
    neighbors.heard(TICKS + 1)
    neighbors.highest_pusher(0, 1)
    passed_on(1)
    planner = robot.planner
    everywhere = np.ones(planner.lattice.base.shape, np.uint8)
    planner.nearest((1.0, 2.0), planner.no_extra(), everywhere, math.inf, smooth=False)


def _pass_gate(robot: RobotState) -> None:
    region = np.ones(robot.planner.lattice.base.shape, np.int16)
    gate = Gate(region)
    gate.update(robot, has_turn=True, is_driving=True, priority=lambda: 1)
    for cells in (region, region > 0):
        gate_kernels.entry(cells, robot.planner.lattice.frame, robot.tube.points)
        highest_asking(robot, cells)
    gate._ahead(robot, 1)
    gate._look_at(robot)
    gate._seen_inside(robot)


def _pass_door(robot: RobotState) -> None:
    shape = robot.planner.lattice.base.shape
    half_width(robot.planner.lattice.clearance, 0.1, np.empty(shape))
    labels = np.zeros(shape, np.int16)
    floor = np.ones(shape, np.bool_)
    flood(floor, labels, 0, 0)
    places(floor, 6.0, 1)
    single_lanes = SingleLanes()
    single_lanes.barrier(robot, robot.tube.stop)
    frame, claims = robot.planner.lattice.frame, robot.neighbors.columns()
    entry_of(labels, frame, np.zeros((2, 2)), 1)
    barrier(labels, frame, np.zeros((2, 2)), 1, (0, 1, 0), 0, claims)


def _drive(navigators: list[Navigator]) -> None:
    beacons = None
    places = [Pose(0.0, 0.0, 0.0) for _ in navigators]
    twists = [Twist() for _ in navigators]
    for tick in range(TICKS):
        published = []
        for index, navigator in enumerate(navigators):
            navigator.on_odom(Odometry(tick, places[index], twists[index]))
            if beacons is not None:
                data = serialize_neighbors(TICKS, 0, np.delete(beacons, index))
                navigator.on_reception(reception_of(read_neighbors(data, index + 1)[1]))
            ranges = np.full(360, 1.0 if tick % 4 else np.inf, np.float32)
            navigator.on_scan(Scan(tick, 0.0, math.tau / 360, 0.12, 3.5, ranges))
            output = navigator.tick(tick)
            twists[index] = output.twist
            step = Pose(0.1 * output.twist.vx, 0.0, 0.1 * output.twist.wz)
            places[index] = places[index].compose(step)
            published.append(output.beacon)
        beacons = np.array(published)
