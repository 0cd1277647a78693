"""Where a robot thinks it is: in a room whose walls its LiDAR sees, and where it cannot know."""

import itertools
import math

import numpy as np
import pytest

from swarm_common.model.beacon import reception_of
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Odometry, Pose, Scan, Twist, wrap_angle
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.localisation_config import START_DEVIATION, LocalisationConfig
from swarm_nav.localisation.amcl import GROWTH, LOOKING_SCANS, STEP, TURN, AmclLocaliser
from swarm_nav.localisation.localiser import OdometryLocaliser, make_localiser
from swarm_nav.traffic.arbiter import MARGIN_STEP
from tests.fakes.navigation import beacon, config, hear, robot_in, room, waffle

WIDTH, HEIGHT = 5.0, 3.4
FACE = 0.0375  # [m] inside the room's outline where walls of one cell are taken to end
ROOM = room(WIDTH, HEIGHT)
CORRIDOR = room(30.0, 2.0)
HERE = Pose(1.4, 1.2, 0.4)
WIDE = (0.5, 0.26)  # [m], [rad] that RViz means by its 2D pose estimate


def scan_at(pose, tick, rng, size=(WIDTH, HEIGHT)):
    """Return what a waffle measures in an empty room, with noise and dropouts."""
    lidar = pose.compose(Pose(-0.064, 0.0, 0.0))
    angles = lidar.yaw + np.arange(360) * math.tau / 360
    with np.errstate(divide="ignore"):
        across = [
            (np.where(d > 0.0, high - FACE, FACE) - at) / d
            for d, high, at in (
                (np.cos(angles), size[0], lidar.x), (np.sin(angles), size[1], lidar.y),
            )
        ]  # fmt: skip
    ranges = np.minimum(*across)
    ranges = ranges * (1.0 + 0.015 * rng.standard_normal(360)) + 0.01 * rng.standard_normal(360)
    ranges[ranges > 3.5] = np.inf
    ranges[rng.random(360) < 0.01] = np.nan
    return Scan(tick, 0.0, math.tau / 360, 0.12, 3.5, ranges.astype(np.float32))


def localiser(start, grid=ROOM, seed=0, **changes):
    s = robot_in(grid, start)
    settings = LocalisationConfig(type="amcl", random_seed=seed, **changes)
    made = make_localiser(start, settings, waffle(), s.terrain, s.neighbors, 1)
    assert isinstance(made, AmclLocaliser)
    return made


def stand(robot, pose, ticks, rng, **size):
    for tick in range(ticks):
        robot.on_odom(Odometry(tick, Pose(0.0, 0.0, 0.0), Twist()))
        if tick % 2 == 0:
            robot.on_scan(scan_at(pose, tick, rng, **size))
        if robot.wants_leap:
            robot.leap()


def wrong(pose, rng):
    angle, side = rng.uniform(0.0, math.tau), rng.choice([-1.0, 1.0])
    turned = pose.yaw + side * math.radians(20.0)
    return Pose(pose.x + 0.5 * math.cos(angle), pose.y + 0.5 * math.sin(angle), turned)


@pytest.mark.parametrize("seed", range(12))
def test_recovers_from_half_a_metre_and_twenty_degrees(seed):
    rng = np.random.default_rng(seed)
    robot = localiser(HERE, seed=seed)
    stand(robot, HERE, 1, rng)
    robot.initialise(wrong(HERE, rng), WIDE)
    assert robot.is_lost  # that is what such a deviation says
    stand(robot, HERE, 30, rng)
    assert robot.pose_map.distance(HERE) < 0.05
    assert abs(wrap_angle(robot.pose_map.yaw - HERE.yaw)) < 0.03
    assert not robot.is_lost


@pytest.mark.parametrize("seed", range(6))
def test_a_pose_that_is_wrong_unknowingly_is_found_out_and_corrected(seed):
    rng = np.random.default_rng(seed)
    robot = localiser(wrong(HERE, rng), seed=seed)
    stand(robot, HERE, 60, rng)
    assert robot.pose_map.distance(HERE) < 0.05
    assert not robot.is_lost


def test_a_corridor_leaves_the_place_along_it_open_and_the_covariance_says_so():
    rng = np.random.default_rng(0)
    pose = Pose(15.0, 1.0, 0.0)
    robot = localiser(pose, CORRIDOR)
    stand(robot, pose, 1, rng, size=(30.0, 2.0))
    robot.initialise(Pose(15.4, 1.2, 0.1), WIDE)
    stand(robot, pose, 60, rng, size=(30.0, 2.0))
    along, across, _ = robot.variances()
    assert math.sqrt(along) > 0.3
    assert math.sqrt(across) < 0.05
    assert abs(robot.pose_map.y - pose.y) < 0.05
    assert robot.is_lost
    stand(robot, pose, 2 * LOOKING_SCANS, rng, size=(30.0, 2.0))
    assert not robot.is_lost  # it would stand for ever


def drive(robot, ticks, seed, scale):
    """Let a robot go in circles with odometry that is off; return errors and the last pose."""
    rng = np.random.default_rng(seed)
    true, odom, errors = HERE, Pose(0.0, 0.0, 0.0), []
    for tick in range(ticks):
        robot.on_odom(Odometry(tick, odom, Twist(0.2, 0.0, 0.3)))
        if tick % 2 == 0:
            robot.on_scan(scan_at(true, tick, rng))
        errors.append(robot.pose_map.distance(true))
        true = true.compose(Pose(0.02, 0.0, 0.03))
        odom = odom.compose(Pose(0.02 * scale, 0.0, 0.03 * scale))
    return errors, true


def test_keeps_track_where_dead_reckoning_drifts_away():
    start = OdometryLocaliser(HERE)
    errors, true = drive(localiser(HERE), 600, 0, 1.02)
    assert np.median(errors) < 0.02
    assert max(errors) < 0.06
    odom = Pose(0.0, 0.0, 0.0)
    for tick in range(600):
        start.on_odom(Odometry(tick, odom, Twist()))
        odom = odom.compose(Pose(0.0204, 0.0, 0.0306))
    assert start.pose_map.distance(true) > 0.2


def test_the_same_seed_gives_the_same_poses_and_robots_do_not_disturb_each_other():
    first, second, other = (localiser(HERE, seed=seed) for seed in (5, 5, 6))
    drive(first, 60, 1, 1.01)
    drive(other, 60, 1, 1.01)
    drive(second, 60, 1, 1.01)
    assert first.particles().tobytes() == second.particles().tobytes()
    assert first.pose_map == second.pose_map
    assert first.particles().tobytes() != other.particles().tobytes()


def test_corrections_enter_bit_by_bit():
    rng = np.random.default_rng(2)
    robot = localiser(Pose(HERE.x + 0.06, HERE.y - 0.03, HERE.yaw + 0.1))
    poses = []
    for tick in range(40):
        robot.on_odom(Odometry(tick, Pose(0.0, 0.0, 0.0), Twist()))
        robot.on_scan(scan_at(HERE, tick, rng))
        poses.append(robot.pose_map)
    for before, after in itertools.pairwise(poses):
        assert before.distance(after) <= STEP + 1e-9
        assert abs(wrap_angle(after.yaw - before.yaw)) <= TURN + 1e-9
    assert poses[-1].distance(HERE) < 0.04


def test_a_robot_in_view_is_no_wall():
    rng = np.random.default_rng(3)
    s = robot_in(ROOM, HERE)
    hear(s, beacon(2, HERE.x + 0.8, HERE.y + 0.4))
    settings = LocalisationConfig(type="amcl")
    robot = AmclLocaliser(HERE, settings, waffle(), s.terrain, s.neighbors, 1)
    for tick in range(0, 40, 2):
        robot.on_odom(Odometry(tick, Pose(0.0, 0.0, 0.0), Twist()))
        scan = scan_at(HERE, tick, rng)
        scan.ranges[350:] = scan.ranges[:25] = 0.75
        robot.on_scan(scan)
    assert robot.pose_map.distance(HERE) < 0.04
    assert not robot.is_lost


def test_the_error_of_the_pose_enters_the_safety_margin_and_never_lowers_it():
    rng = np.random.default_rng(4)
    parameters = config(localisation__type="amcl", costmap__scan_timeout=0.0)
    robot = Navigator(parameters, waffle(), ROOM, Sites(), 1, HERE)
    radii = []
    for tick in range(30):
        robot.on_odom(Odometry(tick, Pose(0.0, 0.0, 0.0), Twist()))
        robot.on_scan(scan_at(HERE, tick, rng))
        robot.on_reception(reception_of(hear_nothing()))
        radii.append(float(robot.tick(tick).beacon["radius"]))
    body, least = waffle().circumscribed_radius, robot.reservation_config.traffic.safety_margin
    sigma = math.sqrt(max(robot.services.variances()[:2]))
    assert min(radii) >= body + least - 1e-6
    needed = body + max(least, 0.03 + 2.0 * sigma + GROWTH)
    assert needed - 0.002 <= radii[-1] < needed + 2.0 * MARGIN_STEP


def hear_nothing():
    from swarm_common.model.beacon import empty_beacons

    return empty_beacons(0)


def test_a_lost_robot_stands_and_says_so_until_a_pose_is_found():
    rng = np.random.default_rng(5)
    parameters = config(localisation__type="amcl", costmap__scan_timeout=0.0)
    robot = Navigator(parameters, waffle(), ROOM, Sites(), 1, HERE)
    robot.on_odom(Odometry(0, Pose(0.0, 0.0, 0.0), Twist()))
    robot.services.on_initial_pose(Pose(HERE.x + 0.4, HERE.y + 0.3, HERE.yaw - 0.35), WIDE)
    details = []
    for tick in range(60):
        robot.on_odom(Odometry(tick, Pose(0.0, 0.0, 0.0), Twist()))
        if tick >= 20:
            robot.on_scan(scan_at(HERE, tick, rng))
        robot.on_reception(reception_of(hear_nothing()))
        output = robot.tick(tick)
        details.append(robot.status().detail)
        assert output.twist == Twist()
    assert set(details[:20]) == {"stands: lost"}
    assert details[-1] == ""
    assert robot.pose_map.distance(HERE) < 0.05


def test_dead_reckoning_is_the_default_and_asks_for_nothing():
    s = robot_in(ROOM, HERE)
    robot = make_localiser(HERE, LocalisationConfig(), waffle(), s.terrain, s.neighbors, 1)
    assert isinstance(robot, OdometryLocaliser)
    robot.on_scan(scan_at(HERE, 0, np.random.default_rng(0)))
    robot.configure(LocalisationConfig())
    robot.load_map(s.terrain)
    robot.leap()
    assert (robot.margin, robot.is_lost, robot.wants_leap) == (0.0, False, False)
    assert robot.variances()[0] == pytest.approx(START_DEVIATION[0] ** 2)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("sigma_hit", 0.0, "sigma_hit is 0.0; it must be more than 0"),
        ("alpha1", -1.0, "alpha1 is -1.0; it must be from 0 to 10000"),
        ("pf_z", 1.0, "pf_z is 1.0; it must be at least 0 and less than 1"),
        ("min_particles", 2000, "min_particles is 2000 and max_particles is 1000"),
        ("max_beams", 2, "max_beams is 2; it must be from 4 to 10000"),
        ("random_seed", -1, "random_seed is -1"),
        ("update_period", math.nan, "localisation.update_period' in the parameters is nan"),
    ],
)
def test_impossible_parameters_are_refused(name, value, message):
    with pytest.raises(ConfigError, match=message):
        config(**{f"localisation__{name}": value})
