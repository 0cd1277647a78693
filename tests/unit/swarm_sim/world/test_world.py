"""The world as a whole: driving, contacts, sensing and determinism in both engines."""

import math
from pathlib import Path

import numpy as np
import psutil
import pytest

from swarm_common.model.beacon import empty_beacons
from swarm_common.model.errors import ConfigError, RobotModelError, UnknownNameError
from swarm_common.model.records import Pose, Twist, wrap_angle
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Scene
from swarm_sim.maps.spawn import spawn_poses
from swarm_sim.sensing.radio import RadioConfig
from swarm_sim.world.world import World, WorldConfig

WAFFLE = load_robot("turtlebot3_waffle")
BURGER = load_robot("turtlebot3_burger")
FIELD = Scene("field", Path("."), ())
HALL = load_world("hall_12")
ENGINES = ("planar", "bullet")


def make_world(engine, scene, *poses, seed=0, spec=WAFFLE):
    config = WorldConfig(engine=engine, with_lidar=False)
    return World(scene, [spec] * len(poses), poses, config, seed)


def drive(world, seconds, *twists):
    for _ in range(round(10 * seconds)):
        world.step(twists, [None] * len(twists))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("spec", [WAFFLE, BURGER], ids=["waffle", "burger"])
@pytest.mark.parametrize(
    ("v", "w"), [(0.26, 0.0), (0.05, 0.0), (-0.15, 0.0), (0.0, 1.0), (0.0, -1.82), (0.2, 0.5)]
)
def test_speed_and_turn_are_within_one_percent(engine, v, w, spec):
    v, w = v * spec.max_vel_x / 0.26, w * spec.max_vel_theta / 1.82
    world = make_world(engine, FIELD, Pose(0.0, 0.0, 0.3), spec=spec)
    command = Twist(v, 0.0, w)
    drive(world, 1.0, command)
    yaw, turned, length = world.ground_truth()[0][0].yaw, 0.0, world.verdict.robots["Srobot1"]
    for _ in range(60):
        world.step([command], [None])
        turned += wrap_angle(world.ground_truth()[0][0].yaw - yaw)
        yaw = world.ground_truth()[0][0].yaw
    path = world.verdict.robots["Srobot1"].distance - length.distance
    chord = abs(v) * np.sinc(0.1 * w / (2.0 * math.pi))  # of the arc driven in one tick
    assert path / 6.0 == pytest.approx(chord, rel=0.01, abs=2e-3)
    assert turned / 6.0 == pytest.approx(w, rel=0.01, abs=2e-3)
    world.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_speeds_change_no_faster_than_the_acceleration_limits(engine):
    world = make_world(engine, FIELD, Pose(0.0, 0.0, 0.0))
    speeds = []
    for twist in [Twist(0.26)] * 4 + [Twist()] * 4:
        drive(world, 0.1, twist)
        speeds.append(world.ground_truth()[0][1].vx)
    assert speeds == pytest.approx([0.1, 0.2, 0.26, 0.26, 0.16, 0.06, 0.0, 0.0], abs=3e-3)
    world.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_odometry_stays_true_over_a_long_drive(engine):
    start = Pose(1.0, -2.0, 0.7)
    world = make_world(engine, FIELD, start)
    rng = np.random.default_rng(4)
    for _ in range(60):
        drive(world, 1.5, Twist(rng.uniform(-0.1, 0.26), 0.0, rng.uniform(-1.5, 1.5)))
    drive(world, 1.0, Twist())
    odom = world.observe()[0].odom
    estimate, truth = start.compose(odom.pose_odom), world.ground_truth()[0][0]
    assert estimate.distance(truth) < 0.01
    assert abs(wrap_angle(estimate.yaw - truth.yaw)) < 1e-3
    names, positions, velocities = world.joint_states(0)
    assert names == ["wheel_left_joint", "wheel_right_joint"]
    assert np.isfinite(positions).all()
    assert velocities == pytest.approx([0.0, 0.0], abs=0.02)
    world.close()


def test_planar_and_bullet_drive_the_same_path():
    """Within 2 cm and 0.02 rad over 40 s of changing commands."""
    rng = np.random.default_rng(1)
    commands = [Twist(rng.uniform(0, 0.26), 0.0, rng.uniform(-1, 1)) for _ in range(20)]
    ends = []
    for engine in ENGINES:
        world = make_world(engine, FIELD, Pose(0.0, 0.0, 0.0))
        for command in commands:
            drive(world, 2.0, command)
        ends.append(world.ground_truth()[0][0])
        world.close()
    assert ends[0].distance(ends[1]) < 0.02
    assert abs(wrap_angle(ends[0].yaw - ends[1].yaw)) < 0.02


@pytest.mark.parametrize("engine", ENGINES)
def test_a_blind_robot_is_one_collision_with_wall_or_robot(engine):
    world = make_world(engine, HALL, Pose(5.4, 0.0, 0.1))
    drive(world, 6.0, Twist(0.26))
    verdict = world.verdict
    assert (verdict.robot_robot, verdict.robot_world) == (0, 1)
    (collision,) = verdict.collisions
    assert collision.robots == ("Srobot1",)
    assert collision.obstacle == "hall_12::wall_east"
    assert 1.9 < collision.sim_time < 2.6  # 0.52 m of way, and 0.13 s to get going
    assert verdict.min_clearance == 0.0
    assert world.ground_truth()[0][0].x < 5.95
    world.close()
    world = make_world(engine, HALL, Pose(0.0, 0.0, 0.0), Pose(0.8, 0.05, 1.0))
    drive(world, 6.0, Twist(0.26), Twist())
    verdict = world.verdict
    assert (verdict.robot_robot, verdict.robot_world) == (1, 0)
    (collision,) = verdict.collisions
    assert collision.robots == ("Srobot1", "Srobot2")
    assert verdict.robots["Srobot2"].collisions == 1
    assert 0.0 < collision.x < 0.9
    world.close()


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("specs", [(WAFFLE, BURGER), (BURGER, WAFFLE)], ids=["wb", "bw"])
def test_a_burger_and_a_waffle_pass_and_meet_with_their_own_bodies(engine, specs):
    config = WorldConfig(engine=engine, with_lidar=False)
    aside = 0.153 + 0.089 + 0.02  # half widths, and 2 cm
    for offset, expected in ((aside, 0), (0.2, 1)):
        poses = [Pose(-0.8, 0.0, 0.0), Pose(0.8, offset, math.pi)]
        world = World(HALL, specs, poses, config)
        drive(world, 6.0, Twist(0.22), Twist(0.22))
        verdict = world.verdict
        assert verdict.robot_robot == expected
        if not expected:
            assert verdict.min_clearance == pytest.approx(0.02, abs=0.006)
            assert verdict.near_misses == 1
            assert verdict.close_calls[0].robots == ("Srobot1", "Srobot2")
        world.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_two_collisions_with_a_pause_between_count_twice(engine):
    world = make_world(engine, HALL, Pose(5.7, 0.0, 0.0))
    for _ in range(2):
        drive(world, 2.5, Twist(0.26))
        drive(world, 2.0, Twist(-0.2))
    assert world.verdict.robot_world == 2
    world.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_passing_closely_and_standing_still_are_no_collisions(engine):
    world = make_world(engine, HALL, Pose(-1.0, 0.0, 0.0), Pose(1.0, 0.34, math.pi))
    drive(world, 7.0, Twist(0.26), Twist(0.26))
    verdict = world.verdict
    assert verdict.collisions == ()
    assert verdict.min_clearance == pytest.approx(0.34 - 0.306, abs=0.006)  # width over wheels
    world.close()
    world = make_world(engine, HALL, Pose(0.0, 0.0, 0.0), Pose(5.7, 0.0, 0.0))
    drive(world, 3.0, Twist(), Twist())
    assert world.verdict.collisions == ()
    pose = world.ground_truth()[0][0]
    assert math.hypot(pose.x, pose.y) < 1e-3
    assert world.verdict.robots["Srobot1"].min_clearance == math.inf
    assert world.verdict.min_clearance == pytest.approx(6.0 - 5.7 - 0.069, abs=2e-3)
    world.close()


def run(engine, seed):
    scene = load_world("slim_blockage")
    config = WorldConfig(engine=engine, radio=RadioConfig(loss=0.3))
    world = World(scene, [WAFFLE] * 6, spawn_poses(scene, WAFFLE, 6), config, seed)
    beacons = empty_beacons(6)
    beacons["id"] = np.arange(1, 7)
    sensed = 0.0
    for tick in range(60):
        commands = []
        for i, seen in enumerate(world.observe()):
            sensed += float(len(seen.neighbors) * (i + 1) * (tick + 1))
            if seen.scan is not None:
                sensed += float(seen.scan.ranges[np.isfinite(seen.scan.ranges)].sum())
            commands.append(Twist(0.2, 0.0, math.sin(tick / 9.0 + i)))
        world.step(commands, list(beacons))
    world.close()
    return world.verdict.trajectory_sha256, sensed


@pytest.mark.parametrize("engine", ENGINES)
def test_the_same_seed_gives_the_same_run_bit_for_bit(engine):
    first = run(engine, 3)
    assert run(engine, 3) == first
    assert run(engine, 4)[1] != first[1]


@pytest.mark.parametrize("engine", ENGINES)
def test_actuation_noise_follows_the_seed_and_odometry_tells_it(engine):
    start, ends = Pose(0.0, 0.0, 0.0), []
    for seed in (1, 1, 2):
        config = WorldConfig(engine=engine, with_lidar=False, actuation_noise=0.02)
        world = World(FIELD, [WAFFLE], [start], config, seed)
        drive(world, 20.0, Twist(0.2, 0.0, 0.2))
        truth = world.ground_truth()[0][0]
        assert truth.distance(start.compose(world.observe()[0].odom.pose_odom)) < 0.01
        ends.append(truth)
        world.close()
    assert ends[0] == ends[1]
    assert 1e-4 < ends[0].distance(ends[2]) < 0.2


def test_worlds_of_one_process_do_not_disturb_each_other():
    alone = make_world("bullet", FIELD, Pose(0.0, 0.0, 0.0))
    drive(alone, 2.0, Twist(0.2, 0.0, 0.3))
    pair = [make_world("bullet", FIELD, Pose(0.0, 0.0, 0.0)) for _ in range(2)]
    for _ in range(20):
        for world in pair:
            world.step([Twist(0.2, 0.0, 0.3)], [None])
    assert {w.verdict.trajectory_sha256 for w in pair} == {alone.verdict.trajectory_sha256}
    for world in [alone, *pair]:
        world.close()


def test_closed_worlds_leave_nothing_behind():
    process = psutil.Process()

    def cycle(count):
        for _ in range(count):
            world = make_world("bullet", HALL, Pose(0.0, 0.0, 0.0))
            world.close()
            world.close()

    cycle(3)
    threads, memory = process.num_threads(), process.memory_info().rss
    cycle(12)
    assert process.num_threads() == threads
    assert process.memory_info().rss - memory < 30e6


def test_impossible_settings_and_wheels_are_refused():
    with pytest.raises(UnknownNameError, match="did you mean 'bullet'"):
        WorldConfig(engine="bulet")
    with pytest.raises(ConfigError, match="actuation_noise"):
        WorldConfig(actuation_noise=0.5)
    with pytest.raises(ConfigError, match="physics_period"):
        WorldConfig(physics_period=0.03)
    with pytest.raises(ConfigError, match="physics_period"):
        WorldConfig(physics_period=0.0)
    with pytest.raises(ValueError, match="1 robot models but 2 poses"):
        World(FIELD, [WAFFLE], [Pose(0, 0, 0)] * 2)
    from dataclasses import replace

    lame = replace(WAFFLE, wheels_left=("front_left", "rear_left"))
    with pytest.raises(RobotModelError, match="'front_left', 'rear_left'"):
        World(FIELD, [lame], [Pose(0, 0, 0)], WorldConfig(engine="bullet"))
