"""Variances of odometry against the scatter of many robots' readings."""

import numpy as np
import pytest

from swarm_common.model.records import CONTROL_PERIOD, Twist
from swarm_common.model.sensors import IDEAL, ImuErrors, OdometryErrors, SensorErrors
from swarm_describe.robots.loading import load_robot
from swarm_sim.sensing.drift import LEAST, Drift
from swarm_sim.sensing.motion_sensors import MotionSensors

SPEC = load_robot("turtlebot3_waffle")
COUNT, TICKS = 400, 300
GYRO = SensorErrors(
    odometry=OdometryErrors(wheel_bias=0.01, slip=0.005),
    imu=ImuErrors(gyro_noise=0.002, gyro_bias=0.0005, gyro_scale=0.01),
)
WHEELS = SensorErrors(
    odometry=OdometryErrors(heading="wheels", wheel_bias=0.002, separation_bias=0.01, slip=0.002)
)


def scatter(errors, twist):
    """Return the variances of way, heading and turning rate that robots report, by simulation."""
    sensors = MotionSensors([SPEC] * COUNT, [errors] * COUNT, seed=3)
    travels, yaws = np.zeros((COUNT, 2)), np.zeros(COUNT)
    twists = np.tile((twist.vx, twist.wz, twist.vy), (COUNT, 1))
    for tick in range(TICKS):
        travels[:, 0] += twist.vx * CONTROL_PERIOD
        yaws += twist.wz * CONTROL_PERIOD
        ways, headings = sensors.update(tick, travels, yaws, twists)
    rates = sensors.twists(twists)[:, 1]
    return float(np.var(ways[:, 0])), float(np.var(headings)), float(np.var(rates))


@pytest.mark.parametrize("errors", [GYRO, WHEELS])
@pytest.mark.parametrize("twist", [Twist(0.2, 0.0, 0.0), Twist(0.15, 0.0, 0.3)])
def test_variances_are_those_of_the_readings(errors, twist):
    drift = Drift(errors, SPEC)
    for _ in range(TICKS):
        drift.add(twist)
    way, heading, rate = scatter(errors, twist)
    x, y, yaw = drift.of_pose
    assert x == y
    assert yaw == pytest.approx(heading, rel=0.35)
    across = yaw * (twist.vx * CONTROL_PERIOD * TICKS) ** 2 / 3.0
    assert x - across == pytest.approx(way, rel=0.35)
    assert drift.of_twist[2] == pytest.approx(rate, rel=0.35)


def test_sensors_that_do_not_err_have_the_least_variance():
    drift = Drift(IDEAL, SPEC)
    drift.add(Twist(0.2, 0.0, 0.5))
    assert drift.of_pose == drift.of_twist == (LEAST, LEAST, LEAST)
