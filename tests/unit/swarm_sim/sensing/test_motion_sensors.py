"""Odometry that drifts and IMUs, and LiDARs that miss: how much, and always alike."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from swarm_common.files.convert import updated
from swarm_common.model.records import LidarSpec, Pose, Twist
from swarm_common.model.sensors import IDEAL, LidarErrors
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.scene import Scene
from swarm_sim.physics.drive import Odometer
from swarm_sim.scene.section import Section
from swarm_sim.sensing.lidar import LidarGroup
from swarm_sim.sensing.motion_sensors import GRAVITY, MotionSensors
from swarm_sim.world.world import World, WorldConfig

WAFFLE = load_robot("turtlebot3_waffle")
COUNT = 400
NOTHING = Section((), np.zeros((0, 3)), ())
BOX = Section((np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]),), NOTHING.discs, ())


def errors(**groups):
    return updated(IDEAL, groups, "test")


def drift(error, speed, rate, ticks, seed=0):
    """Return the odometry poses (n, 3) of many robots that drive alike."""
    sensors = MotionSensors([WAFFLE] * COUNT, [error] * COUNT, seed)
    odometer = Odometer(COUNT)
    travels, yaws, twists = np.zeros((COUNT, 2)), np.zeros(COUNT), np.zeros((COUNT, 3))
    twists[:, :2] = speed, rate
    for tick in range(ticks):
        travels[:, 0] += 0.1 * speed
        yaws += 0.1 * rate
        odometer.update(*sensors.update(tick, travels, yaws, twists))
    poses = [reading.pose_odom for reading in odometer.readings(ticks, twists)]
    return np.array([(pose.x, pose.y, pose.yaw) for pose in poses])


def test_errors_of_wheels_grow_with_the_way():
    ends = drift(errors(odometry={"wheel_bias": 0.01}), 0.2, 0.0, 500)
    assert ends[:, 0].mean() == pytest.approx(10.0, abs=0.02)
    assert ends[:, 0].std() == pytest.approx(10.0 * 0.01 / math.sqrt(2.0), rel=0.15)
    short, long = (drift(errors(odometry={"slip": 0.02}), 0.2, 0.0, n) for n in (100, 400))
    assert short[:, 0].std() == pytest.approx(0.02 * math.sqrt(2.0 / 2.0), rel=0.15)
    assert long[:, 0].std() == pytest.approx(2.0 * short[:, 0].std(), rel=0.2)
    error = WAFFLE.sensors
    first, second, other = (drift(error, 0.2, 0.1, 50, seed) for seed in (1, 1, 2))
    assert first.tobytes() == second.tobytes() != other.tobytes()


def test_a_heading_from_wheels_drifts_with_the_way_and_one_from_a_gyro_with_time():
    by_wheels = drift(errors(odometry={"wheel_bias": 0.005, "heading": "wheels"}), 0.2, 0.0, 500)
    expected = 10.0 * 0.005 * math.sqrt(2.0) / WAFFLE.wheel_separation
    assert by_wheels[:, 2].std() == pytest.approx(expected, rel=0.15)
    by_gyro = drift(errors(imu={"gyro_bias": 0.002}), 0.0, 0.0, 500)
    assert by_gyro[:, 2].std() == pytest.approx(50.0 * 0.002, rel=0.15)
    noisy = drift(errors(imu={"gyro_noise": 0.01}), 0.0, 0.0, 500)
    assert noisy[:, 2].std() == pytest.approx(0.01 * math.sqrt(50.0), rel=0.15)


def test_an_imu_at_rest_feels_gravity_and_one_that_drives_a_curve_the_pull_aside():
    sensors = MotionSensors([WAFFLE], [IDEAL], 0)
    twists = np.array([[0.2, 0.5, 0.0]])
    assert sensors.imu(0, 0).acceleration == (0.0, 0.0, GRAVITY)
    sensors.update(0, np.zeros((1, 2)), np.array([0.05]), twists)
    assert sensors.imu(0, 1).acceleration == pytest.approx((2.0, 0.1, GRAVITY))  # it sped up
    sensors.update(1, np.zeros((1, 2)), np.array([0.1]), twists)
    reading = sensors.imu(0, 2)
    assert reading.acceleration == pytest.approx((0.0, 0.1, GRAVITY))
    assert (reading.yaw, reading.yaw_rate) == pytest.approx((0.1, 0.5))


def ranges(error, tick=0, seed=0):
    spec = LidarSpec(0.0, 0.0, 0.1)
    group = LidarGroup(spec, [0], BOX, [NOTHING], 0, error)
    return group.scan(np.array([[0.0, 0.0, 0.0]]), seed, tick)[0]


def test_rays_drop_out_and_noise_grows_with_the_range():
    missing = np.concatenate([np.isnan(ranges(LidarErrors(dropout=0.1), t)) for t in range(60)])
    assert missing.mean() == pytest.approx(0.1, abs=0.01)
    assert np.isnan(ranges(LidarErrors(dropout=0.1), 7)).tolist() == missing[2520:2880].tolist()
    scans = np.array([ranges(LidarErrors(sigma_share=0.02), tick) for tick in range(300)])
    for ray, true in ((0, 2.0), (45, 2.0 * math.sqrt(2.0))):
        assert scans[:, ray].mean() == pytest.approx(true, abs=0.02)
        assert scans[:, ray].std() == pytest.approx(math.hypot(0.01, 0.02 * true), rel=0.15)


def test_each_ray_of_a_turning_lidar_is_taken_at_its_own_time():
    spec = dataclasses.replace(LidarSpec(0.0, 0.0, 0.1), sigma=0.0)
    group = LidarGroup(spec, [0], BOX, [NOTHING], 0, LidarErrors(ray_time=True))
    group.note(np.array([[0.5, 0.0, 3.0]]), 0)
    group.note(np.array([[0.5, 0.0, 3.1]]), 1)
    scan = group.scan(np.array([[0.5, 0.0, 3.2 - math.tau]]), 0, 2)[0]
    for ray in (5, 175, 355):
        pose = np.array([[0.5, 0.0, 3.0 + 0.2 * ray / 360]])
        assert scan[ray] == pytest.approx(group.cast(pose)[0, ray], abs=0.01)


def run(config, ticks, scene):
    """Return odometry and truth of a robot that drives straight ahead."""
    world = World(scene, [WAFFLE], [Pose(0.0, 0.0, 0.0)], config, seed=4)
    for _ in range(ticks):
        world.observe()
        world.step([Twist(0.2, 0.0, 0.0)], [None])
    seen = world.observe()[0]
    assert world.imu(0).tick == ticks
    world.close()
    return seen.odom.pose_odom, world.ground_truth()[0][0]


@pytest.mark.parametrize("engine", ["planar", "bullet"])
def test_a_world_is_ideal_unless_it_is_to_be_realistic(engine):
    scene = Scene("floor", Path("floor.sdf"), ())
    exact, true = run(WorldConfig(engine=engine), 60, scene)
    assert exact.distance(true) < 0.01
    off, true = run(
        WorldConfig(engine=engine, realistic=True, sensors={"odometry": {"wheel_bias": 0.2}}),
        60, scene,
    )  # fmt: skip
    assert off.distance(true) > 0.03
