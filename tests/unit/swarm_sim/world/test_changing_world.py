"""Robots that come, go and are put elsewhere: the others do not feel it."""

import math

import numpy as np
import pytest

from swarm_common.model.beacon import FLAG_DEAF, FLAG_LEFT, empty_beacons
from swarm_common.model.errors import WorldError
from swarm_common.model.records import Pose, Twist
from swarm_describe.robots.loading import open_robot
from swarm_describe.worlds.reader import load_world
from swarm_sim.sensing.radio import FAREWELL_TICKS, RadioConfig
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.robot_placement import check_robot_place
from swarm_sim.world.world import WorldConfig

WAFFLE, BURGER = open_robot("turtlebot3_waffle"), open_robot("turtlebot3_burger")
HALL = load_world("hall_12")
ENGINES = ("planar", "bullet")


def make_world(engine, *poses, **options):
    config = WorldConfig(engine=engine, **options)
    models = {WAFFLE.spec.model: WAFFLE.model}
    return ChangingWorld(HALL, [WAFFLE.spec] * len(poses), poses, config, 3, None, models)


def turning(world, ticks):
    """Let everybody drive in wiggles; return the poses, and the first two robots' scans."""
    seen = []
    for _ in range(ticks):
        tick, count = world.tick, len(world.specs)
        observed = world.observe()
        seen += [scan.ranges for o in observed[:2] if (scan := o.scan) is not None]
        seen.append(world.poses[:2].copy())
        twists = [Twist(0.2, 0.0, math.sin(tick / 9 + robot)) for robot in range(count)]
        world.step(twists, [None] * count)
    return seen


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("realistic", [False, True])
def test_who_comes_and_goes_far_away_changes_nothing_for_the_others(engine, realistic):
    poses = (Pose(-4.5, 0.0, 1.5), Pose(-4.0, 2.0, 2.0))
    runs = []
    for changes in (False, True):
        world = make_world(engine, *poses, realistic=realistic, actuation_noise=0.02)
        seen = turning(world, 10)
        if changes:
            world.add("Srobot3", 3, BURGER.spec, BURGER.model, Pose(4.5, -4.0, 0.5))
        seen += turning(world, 10)
        if changes:
            world.place(2, Pose(5.0, 4.0, 0.0))
        seen += turning(world, 10)
        if changes:
            world.remove(2, 3)
        seen += turning(world, 10)
        if changes:
            world.readmit(2, 3, Pose(4.5, -4.0, 0.5))
        seen += turning(world, 5)
        runs.append([s for s in seen if s.shape == (2, 3)])
        odom = world.observe()[0].odom
        runs[-1].append(np.array([odom.pose_odom.x, odom.pose_odom.y, odom.pose_odom.yaw]))
        world.close()
    for alone, among in zip(*runs, strict=True):
        np.testing.assert_array_equal(alone, among)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_newcomer_drives_is_seen_and_meets_others(engine):
    world = make_world(engine, Pose(0.0, 0.0, 0.0))
    turning(world, 1)
    robot = world.add("Srobot2", 2, BURGER.spec, BURGER.model, Pose(1.0, 0.0, math.pi))
    first = world.observe()[robot].odom
    assert first.pose_odom == Pose(0.0, 0.0, 0.0)
    while (scan := world.observe()[0].scan) is None:
        world.step([Twist()] * 2, [None] * 2)
    assert scan.ranges[0] < 1.2  # from the waffle's LiDAR to the burger's body
    for _ in range(60):
        world.step([Twist(), Twist(0.2)], [None] * 2)
    verdict = world.verdict
    assert verdict.robot_robot == 1
    assert verdict.robots["Srobot2"].collisions == 1
    assert world.joint_states(robot)[0] == ["wheel_left_joint", "wheel_right_joint"]
    world.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_who_was_taken_out_is_neither_met_nor_seen_nor_driven(engine):
    world = make_world(engine, Pose(0.0, 0.0, 0.0), Pose(1.2, 0.0, 0.0))
    distance = world.verdict.robots["Srobot2"].distance
    world.remove(1, 2)
    for _ in range(60):
        scan = world.observe()[0].scan
        assert scan is None or scan.ranges[0] > 2.0
        world.step([Twist(0.26), Twist(0.26)], [None] * 2)
    assert world.verdict.collisions == ()
    assert world.verdict.robots["Srobot2"].distance == pytest.approx(distance, abs=1e-3)
    assert world.poses[0, 0] > 1.3
    assert world.present == [0]
    world.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_being_put_elsewhere_is_no_way_driven_and_odometry_does_not_notice(engine):
    world = make_world(engine, Pose(0.0, 0.0, 0.3))
    for _ in range(10):
        world.step([Twist(0.2)], [None])
    before, driven = world.observe()[0].odom, world.verdict.robots["Srobot1"].distance
    world.place(0, Pose(-3.0, 2.0, -2.0))
    assert world.observe()[0].odom.pose_odom == before.pose_odom
    for _ in range(20):
        world.step([None], [None])  # it stands, whatever it was told before
    truth, twist = world.ground_truth()[0]
    assert truth.distance(Pose(-3.0, 2.0, 0.0)) < 0.003
    assert truth.yaw == pytest.approx(-2.0, abs=0.003)
    assert abs(twist.vx) < 1e-3
    assert world.verdict.robots["Srobot1"].distance == pytest.approx(driven, abs=0.01)
    after = world.observe()[0].odom.pose_odom
    assert after.distance(before.pose_odom) < 0.005
    world.close()


def test_the_same_changes_give_the_same_run_bit_for_bit():
    hashes = set()
    for _ in range(2):
        world = make_world("bullet", Pose(-2.0, 0.0, 0.0), Pose(2.0, 0.0, 1.0))
        turning(world, 5)
        world.add("Srobot3", 3, BURGER.spec, BURGER.model, Pose(0.0, 0.3, 0.5))
        turning(world, 15)
        world.remove(0, 1)
        turning(world, 15)
        hashes.add(world.verdict.trajectory_sha256)
        world.close()
    assert len(hashes) == 1


def test_everybody_is_told_that_a_robot_was_taken_out():
    radio = RadioConfig(range=2.0, loss=1.0, delay=0.2)
    world = make_world("planar", Pose(-5.0, 0.0, 0.0), Pose(5.0, 0.0, 1.0), radio=radio)
    beacons = empty_beacons(2)
    beacons["id"] = (1, 2)
    world.step([None] * 2, list(beacons))
    world.remove(1, 2)
    told = []
    for _ in range(FAREWELL_TICKS + 10):
        heard = world.observe()[0].neighbors
        told += [int(world.tick) for beacon in heard if beacon["flags"] & FLAG_LEFT]
        assert all(beacon["id"] == 2 for beacon in heard)
        world.step([None] * 2, [beacons[0], None])
    assert told == list(range(told[0], told[0] + FAREWELL_TICKS + 1))
    assert told[0] == 4  # a tick, and the delay of two


def test_all_others_hear_where_a_robot_stands_that_does_not_know_where_it_was_put():
    radio = RadioConfig(range=2.0, loss=1.0)
    world = make_world("planar", Pose(-5.0, 0.0, 0.0), Pose(5.0, 0.0, 1.0), radio=radio)
    beacons = empty_beacons(2)
    beacons["id"], beacons["radius"], beacons["held_size"] = (1, 2), 0.3, 4
    beacons["wanted_size"] = 2
    world.step([None] * 2, list(beacons))
    place = Pose(1.0, 2.0, 0.5)
    world.place(1, place)
    world.speak_for(1, 2, place)
    for _ in range(FAREWELL_TICKS + 10):
        world.step([None] * 2, [beacons[0], None])
        other, itself = (observed.neighbors for observed in world.observe())
        assert (len(other), len(itself)) == (1, 0)
        (heard,) = other
        assert (heard["id"], heard["tick"]) == (2, world.tick - 1)
        assert heard["flags"] & (FLAG_DEAF | FLAG_LEFT) == FLAG_DEAF
        assert heard["pose"].tolist() == [1.0, 2.0, 0.5]
        assert heard["held"][: heard["held_size"]].tolist() == [[1.0, 2.0]]
        assert (heard["wanted_size"], heard["radius"]) == (0, np.float32(0.3))
    world.let_speak(2)
    world.step([None] * 2, list(beacons))
    assert all(len(observed.neighbors) == 0 for observed in world.observe())


def test_room_is_asked_for():
    world = make_world("planar", Pose(0.0, 0.0, 0.0))
    spec = WAFFLE.spec
    check_robot_place(world, spec, Pose(2.0, 0.0, 0.0))
    for pose, words in (
        (Pose(0.3, 0.0, 0.0), r"at \(0.30, 0.00\).* Srobot1 stands at \(0.00, 0.00\), 0.30 m"),
        (Pose(5.9, 0.0, 0.0), "wall_east"),
        (Pose(math.nan, 0.0, 0.0), "no place"),
    ):
        with pytest.raises(WorldError, match=words):
            check_robot_place(world, spec, pose)
    check_robot_place(world, spec, Pose(0.3, 0.0, 0.0), robot=0)


@pytest.mark.parametrize("part", ["held", "wanted"])
def test_space_that_another_robot_may_drive_into_is_not_free(part):
    world = make_world("planar", Pose(0.0, 0.0, 0.0))
    (beacon,) = empty_beacons(1)
    beacon["id"], beacon["radius"] = 1, 0.27
    beacon[part][:2] = ((0.3, 0.0), (2.0, 0.0))
    beacon[f"{part}_size"] = 2
    world.step([None], [beacon])
    with pytest.raises(WorldError, match="Srobot1 is about to drive"):
        check_robot_place(world, WAFFLE.spec, Pose(1.2, 0.4, 0.0))
    check_robot_place(world, WAFFLE.spec, Pose(1.2, 0.9, 0.0))
