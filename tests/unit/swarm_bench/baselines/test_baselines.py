"""The baselines are competent: alone and in the open they reach their goals, and nobody is hit."""

import dataclasses
import math
import sys

import numpy as np
import pytest

from swarm_bench.baselines import baseline_kernels as kernels
from swarm_bench.baselines.orca import OFFSET, OrcaDriver
from swarm_bench.baselines.planning import PathTrack, plain_planner, robot_costs
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import run
from swarm_bench.runs.scenario import load_scenario
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Odometry, Pose, Twist
from swarm_common.model.sites import Sites
from swarm_describe.robots.loading import load_robot
from swarm_nav.control.dwa_kernels import Limits, Velocity
from swarm_nav.core.config import NavConfig
from swarm_nav.planning.distance_kernels import Frame, Place
from swarm_nav.planning.search_kernels import WALL

METHODS = ("dwa", "orca")
HALL = Grid(np.zeros((160, 160), np.int8), 0.05, -4.0, -4.0)
LIMITS = Limits(0.26, 1.82, 1.0, 3.2)
SAMPLES = kernels.WindowSamples(8, 21)
SCALES = kernels.Weights(0.4, 1.0, 0.8, 0.15, 0.3)
START = Place(0.0, 0.0, 0.0)
RADIUS = 0.26


def shortened(name, limit):
    return dataclasses.replace(load_scenario(name), time_limit={200: limit})


@pytest.mark.parametrize("method", METHODS)
def test_in_the_open_and_the_doorway_all_reach_their_goals(method):
    options = RunOptions(scenario=shortened("circle", 200.0), robots=8, seed=1, method=method)
    result = run(options)
    assert result.is_flawless
    assert result.makespan is not None
    assert result.makespan < 110.0
    options = RunOptions(scenario=shortened("doorway", 120.0), robots=1, method=method)
    result = run(options)
    assert result.is_flawless
    assert result.makespan is not None
    assert result.makespan < 60.0


@pytest.mark.parametrize("method", METHODS)
def test_equal_runs_are_equal_and_those_who_are_stuck_do_not_touch(method):
    options = RunOptions(scenario=shortened("circle", 15.0), robots=8, seed=1, method=method)
    first, second = run(options), run(options)
    assert first.trajectory_sha256 == second.trajectory_sha256
    options = RunOptions(scenario=shortened("corridor", 60.0), robots=6, method=method)
    result = run(options)
    assert (result.robot_robot, result.robot_world) == (0, 0)


# DWA


def random_scene(seed):
    rng = np.random.default_rng(seed)
    discs = np.column_stack((rng.uniform(-1.2, 1.2, (6, 2)), np.full(6, 0.24)))
    points = rng.uniform(-1.2, 1.2, (5, 2))
    start = np.hypot(discs[:, 0], discs[:, 1]) > 0.24 + RADIUS
    away = np.hypot(points[:, 0], points[:, 1]) > 0.05 + RADIUS
    return kernels.Obstacles(
        np.full((160, 160), 9.0), Frame(-4.0, -4.0, 0.05), discs[start], points[away], 0.05
    )


@pytest.mark.parametrize("seed", range(60))
def test_a_robot_can_stop_before_it_touches_anything(seed):
    scene = random_scene(seed)
    rng = np.random.default_rng(1000 + seed)
    speed, turn = rng.uniform(0.0, 0.1), rng.uniform(-1.0, 1.0)
    target = tuple(rng.uniform(-1.0, 1.0, 2))
    path = np.array(((0.0, 0.0), target))
    v, w, score = kernels.best_twist(
        START, Velocity(speed, turn), target, LIMITS, SAMPLES, RADIUS, scene, path, SCALES, 15
    )
    if score == -kernels.FAR:
        return
    way, yaw = v * 0.1 + v * v / 2.0, 0.0
    x = y = 0.0
    while way > 0.0 and v > 0.0:
        step = min(0.005, way)
        yaw += w * step / v
        x, y, way = x + step * math.cos(yaw), y + step * math.sin(yaw), way - step
        assert kernels.gap(x, y, RADIUS, scene) > -0.01


def test_the_window_is_what_the_drive_can_reach_in_a_period():
    scene = kernels.Obstacles(
        np.full((160, 160), 9.0), Frame(-4.0, -4.0, 0.05), np.zeros((0, 3)), np.zeros((0, 2)), 0.05
    )
    path = np.array(((0.0, 0.0), (1.0, 0.0)))
    v, w, _ = kernels.best_twist(
        START, Velocity(0.05, 0.3), (1.0, 0.0), LIMITS, SAMPLES, RADIUS, scene, path, SCALES, 15
    )
    assert v == pytest.approx(0.15)
    assert w == pytest.approx(0.0, abs=0.02)


# Paths


def test_paths_know_no_lanes_and_keep_off_robots():
    planner = plain_planner(HALL, NavConfig(), 0.24)
    lattice = planner.lattice
    assert not lattice.lane.any()
    extra = robot_costs(planner, np.array([(0.0, 0.0)]), np.array([0.24]), 0.24)
    assert extra.max() == WALL
    path = planner.plan((-2.0, 0.0), (2.0, 0.0), extra)
    assert np.hypot(path[:, 0], path[:, 1]).min() > 0.45


def test_a_track_follows_a_robot_that_cuts_a_corner():
    corner = np.array([(0.05 * k, 0.0) for k in range(20)] + [(1.0, 0.05 * k) for k in range(20)])
    track = PathTrack(corner)
    track.update(Pose(0.9, 0.2, 0.0))
    assert track.rest == pytest.approx(0.75, abs=0.1)
    assert not track.is_lost(Pose(0.9, 0.2, 0.0))
    assert track.is_lost(Pose(0.2, 0.9, 0.0))


# ORCA


def orca_robot():
    spec = load_robot("turtlebot3_waffle")
    robot = OrcaDriver(NavConfig(), spec, HALL, Sites(), 1, Pose(0.0, 0.0, 0.0))
    robot.on_odom(Odometry(0, Pose(0.0, 0.0, 0.0), Twist()))
    return robot


@pytest.mark.parametrize(("v", "w"), [(0.1, 0.5), (0.5, 1.0), (0.1, -4.0), (-0.4, 3.0)])
def test_a_twist_within_the_limits_moves_the_point_in_the_same_direction(v, w):
    twist = orca_robot().limited(v, w)
    assert abs(twist.vx) <= 0.26 + 1e-9
    assert abs(twist.wz) <= 1.82 + 1e-9
    assert math.atan2(OFFSET * twist.wz, twist.vx) == pytest.approx(math.atan2(OFFSET * w, v))


def test_without_pyrvo_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyrvo", None)
    with pytest.raises(ConfigError, match="pip install pyrvo"):
        orca_robot()
