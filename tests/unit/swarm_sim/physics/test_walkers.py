"""People among robots: they stop for nobody, but do not step into a robot that stands."""

import dataclasses
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from swarm_common.model.records import Pose, Twist
from swarm_describe.robots.loading import load_robot
from swarm_describe.worlds.actors import WalkerSpec
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.scene import Scene
from swarm_sim.world.world import World, WorldConfig

WAFFLE = load_robot("turtlebot3_waffle")
FIELD = Scene("field", Path("."), ())
ENGINES = ("planar", "bullet")
ANN = WalkerSpec(name="Ann", path=((-2.0, 0.0), (2.0, 0.0)), start=0.0, pause=0.0)


def make_world(engine, robots, *walkers, seed=0):
    config = WorldConfig(engine=engine, with_lidar=False)
    return World(
        dataclasses.replace(FIELD, walkers=walkers), [WAFFLE] * len(robots), robots, config, seed
    )


def run(world, seconds, *twists):
    places = []
    for _ in range(round(10 * seconds)):
        world.step(twists, [None] * len(twists))
        places.append(world.walkers())
    return places


@pytest.mark.parametrize("engine", ENGINES)
def test_a_walker_goes_round_its_loop_at_its_speed(engine):
    square = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
    walker = WalkerSpec(name="Ann", path=square, speed=1.0, start=1.0, pause=0.0)
    world = make_world(engine, [Pose(9.0, 9.0, 0.0)], walker)
    assert world.walkers()[0].tolist() == [1.0, 0.0, 0.25]
    places = run(world, 8.0, Twist())
    np.testing.assert_allclose(places[9][0, :2], [2.0, 0.0], atol=0.02)
    np.testing.assert_allclose(places[29][0, :2], [2.0, 2.0], atol=0.06)  # corners are exact,
    np.testing.assert_allclose(places[-1][0, :2], [1.0, 0.0], atol=0.06)  # so time is lost there
    steps = np.hypot(*np.diff([place[0, :2] for place in places], axis=0).T)
    assert steps.max() <= 0.1 + 1e-9
    world.close()


def test_pauses_and_starts_follow_the_seed():
    walker = msgspec.structs.replace(ANN, start=None, pause=2.0)
    tracks = []
    for seed in (1, 1, 2):
        world = make_world("planar", [Pose(9.0, 9.0, 0.0)], walker, seed=seed)
        tracks.append(np.array(run(world, 20.0, Twist()))[:, 0, :2])
    assert np.array_equal(tracks[0], tracks[1])
    assert not np.array_equal(tracks[0][0], tracks[2][0])
    still = np.hypot(*np.diff(tracks[0], axis=0).T) == 0.0
    assert 9 <= still.sum() <= 130  # pauses of 1 s to 3 s at each end


@pytest.mark.parametrize("engine", ENGINES)
def test_a_walker_waits_for_a_robot_that_stands_in_its_way_only(engine):
    world = make_world(engine, [Pose(0.5, 0.0, 0.0)], ANN)
    places = np.array(run(world, 7.0, Twist()))[:, 0, 0]
    gap = 0.5 - WAFFLE.circumscribed_radius - 0.25 - places.max()
    assert 0.05 < gap < 0.06 + ANN.step_length
    assert places[-1] < places.max() - 0.5
    assert world.verdict.collisions == ()
    world.close()
    # One that came near before the walker got there does not hold it up from leaving.
    world = make_world(engine, [Pose(-2.0, 0.46, 0.0)], msgspec.structs.replace(ANN, start=1.0))
    places = np.array(run(world, 9.0, Twist()))[:, 0, 0]
    assert places.max() > 1.9
    assert world.verdict.collisions == ()
    world.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_that_drives_is_not_stopped_for_and_collides(engine):
    world = make_world(engine, [Pose(0.0, -0.85, math.pi / 2)], ANN)
    run(world, 6.0, Twist(0.26))
    verdict = world.verdict
    assert (verdict.robot_robot, verdict.robot_world) == (0, 1)
    (collision,) = verdict.collisions
    assert (collision.robots, collision.obstacle) == (("Srobot1",), "Ann")
    assert verdict.min_clearance == 0.0
    world.close()
    walker = msgspec.structs.replace(ANN, pause=100.0, start=3.9)
    world = make_world(engine, [Pose(2.0, -1.5, math.pi / 2)], walker)
    run(world, 8.0, Twist(0.26))
    (collision,) = world.verdict.collisions
    assert collision.obstacle == "Ann"
    assert 3.5 < collision.sim_time < 5.5
    world.close()


def test_lidars_see_walkers_where_they_are():
    quiet = dataclasses.replace(WAFFLE.lidar, sigma=0.0)
    spec = dataclasses.replace(WAFFLE, lidar=quiet)
    walker = WalkerSpec(name="Ann", path=((2.0, -1.0), (2.0, 1.0)), start=1.0, pause=0.0)
    scene = dataclasses.replace(load_world("hall_12"), walkers=(walker,))
    config = WorldConfig(engine="planar")
    world = World(scene, [spec] * 2, [Pose(0, 0, 0), Pose(0, 3, 0)], config)
    for tick in range(10):
        scan = world.observe()[0].scan
        if scan is not None:
            x, y, radius = world.walkers()[0]
            gap = math.hypot(x + 0.064, y) - radius
            assert np.min(scan.ranges) == pytest.approx(gap, abs=2e-3), tick
        world.step([None, None], [None, None])


def test_walkers_make_no_difference_between_runs_of_a_seed():
    hashes = []
    for _ in range(2):
        world = make_world("planar", [Pose(0.0, -0.6, math.pi / 2)], ANN, seed=5)
        run(world, 10.0, Twist(0.1, 0.0, 0.3))
        hashes.append(world.verdict.trajectory_sha256)
    assert hashes[0] == hashes[1]
