"""Dead reckoning from a known pose."""

import math

import pytest

from swarm_common.model.records import Odometry, Pose, Twist
from swarm_nav.localisation.localiser import OdometryLocaliser


def odometry(x, y, yaw, tick=0):
    return Odometry(tick, Pose(x, y, yaw), Twist())


def close(pose, x, y, yaw):
    return (pose.x, pose.y, pose.yaw) == pytest.approx((x, y, yaw), abs=1e-9)


def test_motion_in_odom_is_turned_into_the_map_from_the_first_on():
    localiser = OdometryLocaliser(Pose(2.0, 3.0, math.pi / 2))
    localiser.on_odom(odometry(10.0, -4.0, 1.0))
    assert close(localiser.pose_map, 2.0, 3.0, math.pi / 2)
    localiser = OdometryLocaliser(Pose(2.0, 3.0, math.pi / 2))
    localiser.on_odom(odometry(0.0, 0.0, 0.0))
    localiser.on_odom(odometry(1.0, 0.5, 0.2, 10))
    assert close(localiser.pose_map, 1.5, 4.0, math.pi / 2 + 0.2)
    assert close(localiser.map_from_odom, 2.0, 3.0, math.pi / 2)
    localiser = OdometryLocaliser(Pose(1.0, 2.0, 0.5))
    assert localiser.particles().tolist() == [[1.0, 2.0, 0.5]]


def test_an_initial_pose_replaces_the_estimate_and_later_motion_adds_to_it():
    localiser = OdometryLocaliser(Pose(0.0, 0.0, 0.0))
    localiser.on_odom(odometry(1.0, 0.0, 0.0))
    localiser.on_odom(odometry(2.0, 0.0, 0.3, 10))
    localiser.initialise(Pose(-5.0, 1.0, -1.0))
    assert close(localiser.pose_map, -5.0, 1.0, -1.0)
    step = Pose(2.0, 0.0, 0.3).compose(Pose(0.4, 0.0, 0.1))
    localiser.on_odom(Odometry(11, step, Twist()))
    expected = Pose(-5.0, 1.0, -1.0).compose(Pose(0.4, 0.0, 0.1))
    assert close(localiser.pose_map, expected.x, expected.y, expected.yaw)


def test_the_pose_gets_less_certain_with_the_way_driven_until_one_is_given():
    localiser = OdometryLocaliser(Pose(0.0, 0.0, 0.0))
    localiser.on_odom(odometry(7.0, 0.0, 0.0))
    assert localiser.variances() == pytest.approx((0.05**2, 0.05**2, 0.05**2))
    localiser.on_odom(odometry(57.0, 0.0, 0.0, 10))
    localiser.on_odom(odometry(7.0, 0.0, 0.0, 20))
    assert localiser.variances() == pytest.approx((0.0425, 0.0425, 0.0125))
    localiser.initialise(Pose(1.0, 1.0, 0.0))
    assert localiser.variances()[0] == pytest.approx(0.05**2)
