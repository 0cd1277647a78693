"""Skid-steer and omnidirectional drives in both engines."""

from pathlib import Path

import numpy as np
import pytest

from swarm_common.model.records import Pose, Twist, wrap_angle
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Scene
from swarm_sim.physics.drive import Wheels
from swarm_sim.world.world import World, WorldConfig

TWO, FOUR, MECANUM = (load_robot(f"linorobot2_{name}") for name in ("2wd", "4wd", "mecanum"))
FIELD = Scene("field", Path("."), ())
ENGINES = ("planar", "bullet")


def make_world(engine, spec, scene=FIELD):
    return World(scene, [spec], [Pose(0.0, 0.0, 0.3)], WorldConfig(engine=engine, with_lidar=False))


def drive(world, seconds, twist):
    for _ in range(round(10 * seconds)):
        world.step([twist], [None])


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("spec", "twist"),
    [
        (TWO, Twist(0.4)),
        (TWO, Twist(-0.2, 0.0, 0.5)),
        (FOUR, Twist(0.4)),
        (FOUR, Twist(0.0, 0.0, 0.75)),
        (FOUR, Twist(0.3, 0.0, -0.5)),
        (MECANUM, Twist(0.0, 0.3, 0.0)),
        (MECANUM, Twist(0.2, -0.2, 0.4)),
        (MECANUM, Twist(0.0, 0.0, -0.75)),
    ],
    ids=str,
)
def test_robots_move_as_commanded_and_their_odometry_says_so(engine, spec, twist):
    world = make_world(engine, spec)
    drive(world, 1.0, twist)
    before = world.ground_truth()[0][0]
    turned, path = 0.0, 0.0
    for _ in range(30):
        world.step([twist], [None])
        pose = world.ground_truth()[0][0]
        turned += wrap_angle(pose.yaw - before.yaw)
        path += pose.distance(before)
        before = pose
    assert path / 3.0 == pytest.approx(np.hypot(twist.vx, twist.vy), rel=0.01, abs=2e-3)
    assert turned / 3.0 == pytest.approx(twist.wz, rel=0.01, abs=2e-3)
    odom = world.observe()[0].odom
    assert odom.twist.vy == pytest.approx(twist.vy, abs=5e-3)
    estimate = Pose(0.0, 0.0, 0.3).compose(odom.pose_odom)
    assert estimate.distance(before) < 0.01
    world.close()


@pytest.mark.parametrize("model", ["turtlebot3_waffle", "turtlebot3_burger", "linorobot2_4wd"])
def test_wheels_and_planar_drive_the_same_path(model):
    spec = load_robot(model)
    worlds = [make_world(engine, spec) for engine in ENGINES]
    ways, before = [0.0, 0.0], [world.ground_truth()[0][0] for world in worlds]
    for seconds, speed, rate in (
        (4.0, 0.22, 0.0), (4.0, 0.2, 0.4), (3.0, 0.0, -0.9), (4.0, 0.22, -0.25), (2.0, -0.1, 0.0)
    ):  # fmt: skip
        for _ in range(round(10 * seconds)):
            for k, world in enumerate(worlds):
                world.step([Twist(speed, 0.0, rate)], [None])
                pose = world.ground_truth()[0][0]
                ways[k] += pose.distance(before[k])
                before[k] = pose
            assert before[0].distance(before[1]) < 0.01
            assert abs(wrap_angle(before[0].yaw - before[1].yaw)) < 0.01
    assert ways[0] > 2.5
    assert ways[1] == pytest.approx(ways[0], rel=2e-3)
    for world in worlds:
        world.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_only_omnidirectional_robots_go_sideways_into_walls(engine):
    for spec in (TWO, FOUR):
        world = make_world(engine, spec)
        drive(world, 1.0, Twist(0.0, 0.4, 0.0))
        assert world.ground_truth()[0][0].distance(Pose(0.0, 0.0, 0.0)) < 1e-3
        world.close()
    world = World(
        load_world("hall_12"),
        [MECANUM],
        [Pose(0.0, 5.4, 0.0)],
        WorldConfig(engine=engine, with_lidar=False),
    )
    drive(world, 4.0, Twist(0.0, 0.3, 0.0))
    assert world.verdict.robot_world == 1
    assert world.ground_truth()[0][0].y < 5.95
    world.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_the_wheels_turn_as_the_robot_moves(engine):
    for spec, twist in ((FOUR, Twist(0.3, 0.0, 0.2)), (MECANUM, Twist(0.1, 0.2, 0.3))):
        world = make_world(engine, spec)
        drive(world, 2.0, twist)
        names, positions, velocities = world.joint_states(0)
        assert names == [*spec.wheels_left, *spec.wheels_right]
        expected = Wheels(spec).rates(twist.vx, twist.wz, twist.vy)
        np.testing.assert_allclose(velocities, expected, rtol=0.02, atol=0.02)
        assert np.isfinite(positions).all()
        world.close()


def test_wheels_and_motion_say_the_same():
    for spec, way in ((TWO, (0.7, 0.0)), (FOUR, (0.7, 0.0)), (MECANUM, (0.7, -0.4))):
        wheels = Wheels(spec)
        assert wheels.travel(wheels.rates(way[0], 0.5, way[1])) == pytest.approx(way)
