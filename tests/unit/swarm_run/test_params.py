import dataclasses
import runpy
from pathlib import Path
from typing import Any

import pytest
import yaml

from swarm_common.files.params_io import default_parameters, flatten, nest
from swarm_common.model.engines import BULLET
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_common.model.robot_parameters import robot_from_parameters, robot_parameters
from swarm_common.model.sensors import IDEAL
from swarm_describe.robots.fleet import limits_of
from swarm_describe.robots.loading import load_robot
from swarm_run.params import (
    WorldParams,
    default_world_parameters,
    load_overrides,
    robot_parameter_file,
    write_parameter_file,
)
from swarm_sim.ros.settings import Settings, parse_settings
from swarm_sim.sensing.radio import RadioConfig

ROOT = Path(__file__).resolve().parents[3]
ROBOTS = ["Srobot1", "Srobot2", "Srobot12"]
KNOWN: dict[str, Any] = {"max_vel_x": 0.26, "vx_samples": 8, "holding.mode": "auto"}


def overrides_of(tmp_path, text, robot):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return load_overrides(path, ROBOTS, KNOWN).for_robot(robot)


def test_the_parameter_file_is_the_configuration_and_a_robot_survives_its():
    tool = runpy.run_path(str(ROOT / "tools" / "write_params.py"))
    text = (ROOT / "params" / "navigator.yaml").read_text(encoding="utf-8")
    assert text == tool["parameter_file"](), "run python tools/write_params.py"
    from swarm_nav.core.config import NavConfig, parameter_values

    assert default_parameters() == parameter_values(NavConfig())
    assert flatten(nest(KNOWN)) == KNOWN
    spec = load_robot("turtlebot3_waffle")
    told = robot_from_parameters(robot_parameters(spec))
    assert told == dataclasses.replace(spec, sensors=IDEAL)  # how they err is the world's secret


def test_a_robots_file_is_a_ros_parameter_file(tmp_path):
    spec = load_robot("turtlebot3_waffle")
    values = default_parameters() | limits_of(spec)
    tree = robot_parameter_file("Srobot3", 3, spec, Pose(1.0, 2.0, 0.5), values)
    write_parameter_file(tmp_path / "Srobot3.yaml", tree)
    read = yaml.safe_load((tmp_path / "Srobot3.yaml").read_text(encoding="utf-8"))
    flat = flatten(read["/Srobot3/navigator"]["ros__parameters"])
    assert flat["robot_id"] == 3
    assert flat["initial_pose.x"] == 1.0
    assert flat["max_vel_x"] == spec.max_vel_x
    assert values.items() <= flat.items()
    assert {type(value) for value in flat.values()} <= {bool, int, float, str}


@pytest.mark.parametrize(
    ("section", "who"),
    [
        ("/**", ROBOTS),
        ("navigator", ROBOTS),
        ("/Srobot1/navigator", ["Srobot1"]),
        ("/Srobot1*/navigator", ["Srobot1", "Srobot12"]),
    ],
)
def test_a_section_sets_parameters_of_the_robots_that_it_names(tmp_path, section, who):
    text = f"{section}:\n  ros__parameters:\n    max_vel_x: 0.1\n"
    assert [r for r in ROBOTS if overrides_of(tmp_path, text, r)] == who


def test_later_sections_win_and_integers_pass_for_floats(tmp_path):
    text = """
/**:
  ros__parameters: {max_vel_x: 1, holding: {mode: park}}
/Srobot2/navigator:
  ros__parameters: {max_vel_x: 0.1}
"""
    assert overrides_of(tmp_path, text, "Srobot1") == {"max_vel_x": 1.0, "holding.mode": "park"}
    assert overrides_of(tmp_path, text, "Srobot2")["max_vel_x"] == 0.1


def world_of(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return load_overrides(path, ROBOTS, KNOWN).world


def test_the_defaults_of_the_world_are_those_of_its_process():
    robots = [{"name": "Srobot1", "model": "turtlebot3_waffle"}]
    values = WorldParams(default_world_parameters()).settings()
    settings = parse_settings({"world": "hall", "robots": robots, **values}, "here")
    assert settings == Settings(world="hall", robots=settings.robots, engine=BULLET)


def test_a_section_of_the_world_sets_its_radio_and_breaks_robots(tmp_path):
    text = """
/**:
  ros__parameters: {max_vel_x: 0.1}
/world:
  ros__parameters:
    engine: planar
    radio: {loss: 0.2, delay: 1}
    broken:
      Srobot2: [1.0, -2.0, 1.57]
"""
    world = world_of(tmp_path, text)
    assert world.settings() == {"engine": "planar", "radio": {"loss": 0.2, "delay": 1.0}}
    assert world.broken_map == {"Srobot2": Pose(1.0, -2.0, 1.57)}
    robots = [{"name": "Srobot2", "model": "burger", "broken_at": [1.0, -2.0, 1.57]}]
    settings = parse_settings({"world": "w", "robots": robots, **world.settings()}, "here")
    assert settings.robots[0].broken_at == Pose(1.0, -2.0, 1.57)
    assert settings.radio == RadioConfig(loss=0.2, delay=1.0)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("radio: {los: 0.1}", "unknown parameter 'radio.los'.*'radio.loss'"),
        ("radio: {loss: much}", "'radio.loss' is 'much'.*float"),
        ("broken: {Srobot3: [0, 0, 0]}", "unknown robot 'Srobot3'"),
        ("broken: {Srobot2: [0, 0]}", "broken.Srobot2.*expected a list of 3 numbers"),
    ],
)
def test_a_mistake_about_the_world_is_named(tmp_path, body, message):
    text = f"/world:\n  ros__parameters:\n    {body}\n"
    with pytest.raises(ConfigError, match="(?s)" + message) as caught:
        world_of(tmp_path, text)
    assert "mine.yaml" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("/**:\n  ros__parameters:\n    max_vel: 0.1", "unknown parameter 'max_vel'.*max_vel_x"),
        ("/**:\n  ros__parameters:\n    max_vel_x: fast", "'max_vel_x' is 'fast'.*float"),
        ("/**:\n  ros__parameters:\n    holding: {mod: a}", "'holding.mod'.*'holding.mode'"),
        ("/**:\n  ros_parameters:\n    vx_samples: 8", "expected a section 'ros__parameters:'"),
        ("/Srobot9/navigator:\n  ros__parameters: {}", "unknown node '/Srobot9/navigator'"),
    ],
)
def test_a_mistake_is_named_with_file_and_key(tmp_path, text, message):
    with pytest.raises(ConfigError, match="(?s)" + message) as caught:
        overrides_of(tmp_path, text, "Srobot1")
    assert "mine.yaml" in str(caught.value)


@pytest.mark.parametrize(
    ("section", "problem", "is_theirs"),
    [
        ("/**", "vx_samples is 1; it must be from 2 to 100", True),
        ("/Srobot1/navigator", "vx_samples is 1; it must be from 2 to 100", True),
        ("/Srobot2/navigator", "vx_samples is 1; it must be from 2 to 100", False),
        ("/**", "max_vel_x is 5.0; a waffle reaches 0.26", False),  # from the robot's model
    ],
)
def test_a_wrong_value_is_named_where_the_user_can_change_it(tmp_path, section, problem, is_theirs):
    """The message named the copy in the run's folder, which the next run writes anew."""
    path = tmp_path / "mine.yaml"
    path.write_text(f"{section}:\n  ros__parameters: {{vx_samples: 1}}\n", encoding="utf-8")
    overrides = load_overrides(path, ROBOTS, KNOWN)
    copies = tmp_path / "run" / "params"
    told = overrides.source.located(f"{copies / 'Srobot1.yaml'}: {problem}", copies)
    assert told == (
        f"{path}: {section}: {problem}" if is_theirs else f"{copies / 'Srobot1.yaml'}: {problem}"
    )
    assert overrides.source.located("station loader_3 lies inside a wall", copies).startswith(
        "station"
    )
