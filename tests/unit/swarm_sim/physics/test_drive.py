"""Commands and odometry."""

import math

import numpy as np
import pytest

from swarm_common.model.records import Twist
from swarm_describe.robots.loading import load_robot
from swarm_sim.physics.drive import CommandBuffer, Odometer

WAFFLE = load_robot("turtlebot3_waffle")


def test_commands_are_kept_within_the_limits_and_end_after_half_a_second():
    buffer = CommandBuffer([WAFFLE, WAFFLE])
    targets = buffer.update([Twist(9.0, 0.0, -9.0), Twist(-9.0, 0.0, 0.5)])
    assert targets.tolist() == [[0.26, -1.82, 0.0], [-0.26, 0.5, 0.0]]
    buffer = CommandBuffer([WAFFLE])
    buffer.update([Twist(0.2)])
    speeds = [buffer.update([None])[0, 0] for _ in range(6)]
    assert speeds == [0.2, 0.2, 0.2, 0.2, 0.0, 0.0]
    assert buffer.update([Twist(0.1)])[0, 0] == 0.1


@pytest.mark.parametrize("twist", [Twist(math.nan), Twist(0.1, 0.0, math.inf)])
def test_a_command_that_is_not_finite_means_stop(twist):
    buffer = CommandBuffer([WAFFLE])
    buffer.update([Twist(0.2)])
    assert buffer.update([twist]).tolist() == [[0.0, 0.0, 0.0]]


@pytest.mark.parametrize("turn", [0.0, 0.3, -1.82])
def test_odometry_of_an_arc_is_exact(turn):
    odometer = Odometer(1)
    for tick in range(1, 101):
        odometer.update(np.array([[0.026 * tick, 0.0]]), np.array([0.1 * turn * tick]))
    (reading,) = odometer.readings(100, np.array([[0.26, turn, 0.0]]))
    if turn == 0.0:
        expected = (2.6, 0.0)
    else:
        radius, angle = 0.26 / turn, 10.0 * turn
        expected = (radius * math.sin(angle), radius * (1.0 - math.cos(angle)))
    assert (reading.pose_odom.x, reading.pose_odom.y) == pytest.approx(expected, abs=1e-9)
    assert -math.pi < reading.pose_odom.yaw <= math.pi
    assert reading.twist == Twist(0.26, 0.0, turn)
