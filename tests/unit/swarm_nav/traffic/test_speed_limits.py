"""Speed limits: kept inside a zone, braked for before it, and given by Nav2's topic."""

import dataclasses
import math

import pytest

from swarm_common.model.records import Pose, Twist
from swarm_common.model.sites import Sites
from swarm_common.model.zones import SpeedZone, Zones
from swarm_describe.robots.loading import load_robot
from swarm_nav.core.goals import GoalKind, Outcome
from swarm_nav.traffic.speed_limits import SpeedLimits
from tests.fakes.navigation import Squad, config, robot_in, room, waffle

HALL = room(10.0, 4.0)
ZONE = (4.0, 0.0, 6.0, 4.0)
START, GOAL = Pose(1.5, 2.0, 0.0), Pose(8.5, 2.0, 0.0)


def zones(limit, *, is_percentage=False):
    a, b, c, d = ZONE
    corners = ((a, b), (c, b), (c, d), (a, d))
    return Zones(speed=(SpeedZone("slow", corners, limit, is_percentage),))


def fast_robot():
    return dataclasses.replace(waffle(), max_vel_x=1.2, acc_lim_x=0.8)


def drive(one, ticks=1500):
    """Drive to the end of the goal; return x and speed tick by tick."""
    track = []
    for _ in range(ticks):
        one.run(1)
        body = one.bodies[0]
        track.append((body.pose.x, math.hypot(body.twist.vx, body.twist.vy)))
        if one.ended(0):
            break
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    return track


@pytest.mark.parametrize(
    ("limit", "is_percentage", "allowed"), [(0.1, False, 0.1), (50, True, 0.13)]
)
def test_a_robot_is_no_faster_than_a_zone_allows(limit, is_percentage, allowed):
    sites = Sites(zones=zones(limit, is_percentage=is_percentage))
    one = Squad(HALL, [START], config(), sites)
    one.send(0, GOAL)
    track = drive(one)
    inside = [speed for x, speed in track if ZONE[0] <= x <= ZONE[2]]
    assert max(inside) <= allowed + 1e-6
    assert max(inside) > 0.9 * allowed
    assert max(speed for x, speed in track if x < 3.8) > 0.25
    assert max(speed for x, speed in track if x > 6.3) > 0.25


@pytest.mark.parametrize("limit", [0.1, 0.5])
def test_a_fast_robot_brakes_before_a_zone(limit):
    spec = fast_robot()
    parameters = config(max_vel_x=1.2, acc_lim_x=0.8)
    one = Squad(room(14.0, 4.0), [START], parameters, Sites(zones=zones(limit)), spec=spec)
    one.send(0, Pose(12.5, 2.0, 0.0))
    track = drive(one)
    assert max(speed for x, speed in track if ZONE[0] <= x <= ZONE[2]) <= limit + 1e-6
    assert max(speed for x, speed in track if x < 3.5) > 0.6


@pytest.mark.parametrize(
    ("limit", "is_percentage", "allowed"),
    [(0.1, False, 0.1), (50.0, True, 0.13), (0.0, True, 0.26)],
)
def test_the_topics_limit_counts_everywhere(limit, is_percentage, allowed):
    one = Squad(HALL, [START], config())
    one.robots[0].services.on_speed_limit(0.05, is_percentage=False)
    one.robots[0].services.on_speed_limit(limit, is_percentage=is_percentage)
    one.send(0, GOAL)
    fastest = max(speed for _, speed in drive(one))
    assert 0.9 * allowed < fastest <= allowed + 1e-6


def test_the_lower_of_topic_and_zone_counts():
    s = robot_in(HALL, Pose(5.0, 2.0, 0.0))
    limits = SpeedLimits(zones(0.1))
    wish = Twist(0.26, 0.0, 0.52)
    assert limits.limited(wish, s).vx == pytest.approx(0.1)
    assert limits.limited(wish, s).wz == pytest.approx(0.2)  # on the same course
    limits.set(0.05, is_percentage=False)
    assert limits.limited(wish, s).vx == pytest.approx(0.05)
    limits.set(0.0, is_percentage=False)
    assert limits.limited(wish, s).vx == pytest.approx(0.1)
    assert limits.limited(Twist(0.0, 0.0, 1.0), s) == Twist(0.0, 0.0, 1.0)


def test_a_robot_that_drives_sideways_brakes_for_what_is_beside_it():
    assert load_robot("linorobot2_mecanum").max_vel_y > 0.0
    s = robot_in(HALL, Pose(3.93, 2.0, -math.pi / 2))  # the zone is on its left
    limits = SpeedLimits(zones(0.1))
    assert limits.limited(Twist(0.0, 0.2, 0.0), s).vy < 0.2
    assert limits.limited(Twist(0.0, -0.2, 0.0), robot_in(HALL, Pose(3.7, 2.0, -1.57))).vy == -0.2


def test_without_limits_the_twist_is_left_alone_and_behaviours_keep_them():
    wish = Twist(0.26, 0.0, 0.5)
    assert SpeedLimits(Zones()).limited(wish, robot_in(HALL, START)) is wish
    one = Squad(HALL, [Pose(3.5, 2.0, 0.0)], config(), Sites(zones=zones(0.1)))
    one.send(0, kind=GoalKind.DRIVE_ON_HEADING, distance=2.0, speed=0.25)
    track = drive(one)
    assert max(speed for x, speed in track if x >= ZONE[0]) <= 0.1 + 1e-6
    back = Squad(HALL, [Pose(6.5, 2.0, 0.0)], config(), Sites(zones=zones(0.1)))
    back.send(0, kind=GoalKind.BACKUP, distance=1.5, speed=0.25)
    track = drive(back)
    assert max(speed for x, speed in track if x <= ZONE[2]) <= 0.1 + 1e-6
