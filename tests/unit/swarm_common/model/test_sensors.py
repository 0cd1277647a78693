"""Reading of `sensors:`: what is right, what is refused, and what overrides what."""

import pytest

from swarm_common.files.convert import updated
from swarm_common.model.errors import ConfigError, RobotModelError, UnknownNameError
from swarm_common.model.robot_parameters import robot_from_parameters, robot_parameters
from swarm_common.model.sensors import IDEAL
from swarm_describe.robots.loading import load_robot
from swarm_describe.robots.source import robot_names


def test_nothing_said_is_ideal_and_no_navigator_learns_of_errors():
    assert updated(IDEAL, {}, "x") == IDEAL
    base = updated(IDEAL, {"lidar": {"dropout": 0.1}, "imu": {"gyro_bias": 1}}, "x")
    changed = updated(base, {"lidar": {"sigma_share": 0.02}}, "x")
    assert (changed.lidar.dropout, changed.lidar.sigma_share) == (0.1, 0.02)
    assert changed.imu.gyro_bias == 1.0
    spec = load_robot("turtlebot3_waffle")
    assert not any("sensors" in key for key in robot_parameters(spec))
    assert robot_from_parameters(robot_parameters(spec)).sensors == IDEAL


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ([], "robot.yaml: sensors is \\[\\]; expected 'key: value' lines"),
        ({"lidar": {"dropout": 0.7}}, "dropout is 0.7; expected a number from 0 to 0.5"),
        ({"odometry": {"slip": -0.1}}, "slip is -0.1; expected a number, 0 or more"),
        (
            {"odometry": {"heading": "compass"}},
            "unknown heading 'compass' in robot.yaml: sensors.odometry; known: gyro, wheels",
        ),
    ],
)
def test_bad_values_are_refused_with_their_place(data, message):
    with pytest.raises((RobotModelError, UnknownNameError), match=message):
        updated(IDEAL, data, "robot.yaml: sensors", RobotModelError)


@pytest.mark.parametrize("name", robot_names())
def test_every_robot_of_ours_says_how_its_sensors_err(name):
    spec = load_robot(name)
    assert spec.sensors != IDEAL
    assert spec.sensors.lidar.sigma_share > 0.0
    assert spec.sensors.imu.gyro_bias > 0.0


def test_the_world_section_of_a_parameter_file_overrides_all_robots():
    from swarm_run.params import parse_world

    params = parse_world({"sensors": {"lidar": {"dropout": 0.2}}, "wall_limit": 3.0}, [], "p.yaml")
    assert params.settings() == {"wall_limit": 3.0, "sensors": {"lidar": {"dropout": 0.2}}}
    with pytest.raises(ConfigError, match=r"p.yaml: sensors.lidar.dropout is 2; expected a number"):
        parse_world({"sensors": {"lidar": {"dropout": 2}}}, [], "p.yaml")
