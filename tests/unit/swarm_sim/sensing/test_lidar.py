"""The LiDAR against its slow twin, its noise, and what it can see."""

import math
from dataclasses import replace

import numpy as np
import pytest

from swarm_common.model.records import LidarSpec, Pose
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.reader import load_world
from swarm_sim.scene.section import Section
from swarm_sim.sensing.lidar import LidarGroup
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.scenes import section_at
from tests.oracles import lidar as oracle

NOTHING = Section((), np.zeros((0, 3)), ())


def make_section(rng, boxes, discs):
    polygons = []
    for _ in range(boxes):
        center, size = rng.uniform(-4, 4, 2), rng.uniform(0.05, 2.0, 2) / 2
        turn = rng.uniform(0, math.pi)
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size
        cos, sin = math.cos(turn), math.sin(turn)
        polygons.append(center + corners @ np.array([[cos, sin], [-sin, cos]]))
    rounds = np.column_stack([rng.uniform(-4, 4, (discs, 2)), rng.uniform(0.02, 0.5, discs)])
    return Section(tuple(polygons), rounds, ())


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize(
    "spec",
    [
        LidarSpec(0.0, 0.0, 0.1),
        LidarSpec(-0.064, 0.02, 0.1, yaw=0.7),
        LidarSpec(0.1, 0.0, 0.1, angle_min=-math.pi, rays=360, range_max=12.0),
        LidarSpec(0.1, 0.0, 0.1, angle_min=-1.2, angle_increment=0.01, rays=241),
        LidarSpec(0.0, 0.0, 0.1, rays=1),
        LidarSpec(0.0, 0.0, 0.1, rays=720, angle_increment=0.0087, range_max=0.8),
    ],
)
def test_ranges_equal_those_of_the_slow_twin(seed, spec):
    rng = np.random.default_rng(seed)
    world = make_section(rng, 4, 3)
    group = LidarGroup(spec, [0, 1], world, [NOTHING, NOTHING])
    poses = np.column_stack([rng.uniform(-4, 4, (2, 2)), rng.uniform(-7, 7, 2)])
    ranges = group.cast(poses)
    for row, pose in enumerate(poses):
        sensor = Pose(*pose).compose(Pose(spec.x, spec.y, spec.yaw))
        expected = oracle.ranges(
            (sensor.x, sensor.y, sensor.yaw),
            world.segments(),
            world.discs,
            spec.angle_min,
            spec.angle_increment,
            spec.rays,
            spec.range_max,
        )
        np.testing.assert_allclose(ranges[row], expected, atol=1e-11, rtol=1e-11)


@pytest.mark.parametrize("yaw", [0.0, math.pi / 2, math.pi, -math.pi / 2, 2 * math.pi, 1.0])
def test_rays_along_the_axes_hit_the_walls_of_a_room(yaw):
    room = load_world("hall_12")
    spec = LidarSpec(0.0, 0.0, 0.1, range_max=20.0)
    group = LidarGroup(spec, [0], section_at(room, 0.1), [NOTHING])
    ranges = group.cast(np.array([[1.0, 2.0, yaw]]))[0]
    walls = [5.0, 4.0, 7.0, 8.0]  # east, north, west, south
    angle = np.arange(360) * spec.angle_increment + yaw
    with np.errstate(divide="ignore"):
        east, north = np.cos(angle), np.sin(angle)
        expected = np.minimum(
            np.where(east > 0, walls[0], walls[2]) / np.abs(east),
            np.where(north > 0, walls[1], walls[3]) / np.abs(north),
        )
    np.testing.assert_allclose(ranges, expected, rtol=1e-9)


def test_a_waffle_sees_only_the_puck_of_another_waffle():
    spec = load_robot("turtlebot3_waffle")
    spec = replace(spec, lidar=replace(spec.lidar, sigma=0.0))
    poses = [Pose(0.0, 0.0, 0.0), Pose(1.5, 0.0, math.pi)]
    config = WorldConfig(engine="planar")
    ranges = World(load_world("hall_12"), [spec, spec], poses, config).observe()[0].scan
    hits = np.flatnonzero(np.isfinite(ranges.ranges))
    # Puck to puck 1.5 + 2 * 0.064, radius 0.055; half angle asin(0.055 / 1.628) = 1.9 degrees.
    assert ranges.ranges[0] == pytest.approx(1.5 + 2 * 0.064 - 0.055, abs=1e-6)
    assert set(hits) == {359, 0, 1}


def test_noise_depends_on_seed_robot_and_tick_and_is_normal():
    scene, spec = load_world("hall_12"), load_robot("turtlebot3_waffle")
    poses = [Pose(4.0, 0.0, 0.0), Pose(-4.0, 0.0, 0.0)]

    def first_scan(seed, robots):
        config = WorldConfig(engine="planar")
        world = World(scene, [spec] * robots, poses[:robots], config, seed)
        scan = world.observe()[0].scan
        return scan.ranges

    assert np.array_equal(first_scan(1, 1), first_scan(1, 2))
    assert not np.array_equal(first_scan(1, 1), first_scan(2, 1))
    world = Section(
        (np.array([[2.0, -50.0], [3.0, -50.0], [3.0, 50.0], [2.0, 50.0]]),), np.zeros((0, 3)), ()
    )
    spec = LidarSpec(0.0, 0.0, 0.1, rays=1000, angle_min=-0.5, angle_increment=0.001, sigma=0.01)
    group = LidarGroup(spec, [0], world, [NOTHING])
    pose = np.zeros((1, 3))
    errors = np.concatenate([(group.scan(pose, 3, t) - group.cast(pose))[0] for t in range(100)])
    assert abs(errors.mean()) < 2e-4
    assert errors.std() == pytest.approx(0.01, rel=0.02)
    assert np.mean(np.abs(errors) > 0.02) == pytest.approx(0.0455, abs=0.004)


def test_out_of_range_follows_rep_117_and_scans_come_at_their_rate():
    wall = np.array([[0.05, -1.0], [0.06, -1.0], [0.06, 1.0], [0.05, 1.0]])
    spec = LidarSpec(0.0, 0.0, 0.1, rays=4, angle_increment=math.pi / 2, sigma=0.0)
    group = LidarGroup(spec, [0], Section((wall,), np.zeros((0, 3)), ()), [NOTHING])
    ranges = group.scan(np.zeros((1, 3)), 0, 0)[0]
    assert ranges[0] == -np.inf
    assert ranges[2] == np.inf
    scene, spec = load_world("hall_12"), load_robot("turtlebot3_waffle")
    world = World(scene, [spec], [Pose(0.0, 0.0, 0.0)], WorldConfig(engine="planar"))
    due = []
    for _ in range(6):
        due.append(world.observe()[0].scan is not None)
        world.step([None], [None])
    assert due == [True, False, True, False, True, False]
