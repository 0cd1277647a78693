import dataclasses

import pytest
import yaml

from swarm_common.model.errors import SwarmError
from swarm_common.model.robot_parameters import robot_parameters
from swarm_common.model.sensors import IDEAL
from swarm_describe.robots.loading import load_robot
from swarm_nav.ros.settings import parse_node_settings, read_node_settings

SPEC = load_robot("turtlebot3_waffle")
ROBOT = {f"robot.{name}": value for name, value in robot_parameters(SPEC).items()}


def parse(**changes):
    return parse_node_settings("Srobot3", ROBOT | {"robot_id": 3} | changes, "file")


def test_a_nested_file_with_whole_numbers_and_defaults(tmp_path):
    settings = parse()
    assert settings.robot_id == 3
    assert settings.spec == dataclasses.replace(SPEC, sensors=IDEAL)  # the world's secret
    assert settings.fixed["use_sim_time"] is True
    assert settings.config.goal_checker.xy_goal_tolerance == 0.25
    path = tmp_path / "p.yaml"
    tree = {
        "/**": {"ros__parameters": {"goal_checker": {"xy_goal_tolerance": 0.3}, "robot_id": 9}},
        "/Srobot3/navigator": {"ros__parameters": ROBOT | {"robot_id": 3}},
    }
    path.write_text(yaml.safe_dump(tree), encoding="utf-8")
    settings = read_node_settings("Srobot3", path)
    assert (settings.robot_id, settings.config.goal_checker.xy_goal_tolerance) == (3, 0.3)
    assert parse(**{"initial_pose.x": 2}).initial_pose_map.x == 2.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"max_vel_x": -1.0}, "max_vel_x is -1.0"),
        ({"max_vel_x": 3.0}, "reaches 0.26"),
        ({"max_val_x": 0.2}, "did you mean 'max_vel_x'"),
        ({"vx_samples": "many"}, "vx_samples"),
        ({"robot_id": 0}, "robot_id is 0"),
        ({"robot_id": "three"}, "robot_id"),
        ({"autostart": 1}, "autostart"),
        ({"robot.footprint": "[[0, 0"}, "describe no robot"),
    ],
)
def test_bad_values_are_refused_by_name(changes, message):
    with pytest.raises(SwarmError, match=r".*") as caught:
        parse(**changes)
    assert message in str(caught.value)
