"""RViz configurations and Foxglove layouts: whole, and about the right robot."""

import json
from pathlib import Path

import pytest
import yaml

from swarm_commander.cli.main import with_value
from swarm_commander.viewers import rviz
from swarm_commander.viewers.layouts import layouts, write_foxglove, write_rviz
from swarm_common.middleware.topic_table import ORDERS, all_topics, robot_topic
from swarm_common.model.errors import ConfigError
from swarm_run.spec import RunSpec
from tests.fakes.rviz_topics import named_topics

ROBOTS = ["Srobot1", "Srobot2", "Srobot3"]


def test_every_robot_and_the_swarm_have_a_configuration(tmp_path):
    write_rviz(tmp_path, ROBOTS)
    assert sorted(path.stem for path in tmp_path.iterdir()) == [*ROBOTS, "merged", "swarm"]
    known = {topic.name for topic in all_topics(ROBOTS)}
    known |= {robot_topic(robot, topic.name).name for robot in ROBOTS for topic in ORDERS}
    for robot in ROBOTS:
        config = yaml.safe_load((tmp_path / f"{robot}.rviz").read_text())
        manager = config["Visualization Manager"]
        assert manager["Global Options"]["Fixed Frame"] == "map"
        names = {topic.name for topic in named_topics(config)}
        assert names <= known
        assert all(name == "/map" or name.startswith(f"/{robot}/") for name in names)
        for wanted in ("scan", "plan", "robot_description", "goal_pose", "initialpose"):
            assert f"/{robot}/{wanted}" in names
    swarm = yaml.safe_load((tmp_path / "swarm.rviz").read_text())
    assert {f"/{robot}/plan" for robot in ROBOTS} < {topic.name for topic in named_topics(swarm)}


def test_the_merged_window_has_the_model_of_every_robot_in_frames_of_its_name(tmp_path):
    write_rviz(tmp_path, ROBOTS)
    manager = yaml.safe_load((tmp_path / "merged.rviz").read_text())["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == "map"
    groups = [item for item in manager["Displays"] if item["Class"] == "rviz_common/Group"]
    models = {}
    for group in groups:
        (model,) = [
            item for item in group["Displays"] if item["Class"] == "rviz_default_plugins/RobotModel"
        ]
        assert model["Description Source"] == "Topic"
        models[model["TF Prefix"]] = model["Description Topic"]["Value"]
    assert models == {robot: f"/{robot}/robot_description" for robot in ROBOTS}
    command = rviz.rviz_command("/opt/rviz2", Path("/run/merged.rviz"), "merged")
    assert not [word for word in command if word.startswith("/tf")]


def classes(node):
    """Return every class that a configuration names."""
    if isinstance(node, list):
        return {name for item in node for name in classes(item)}
    if not isinstance(node, dict):
        return set()
    found = {node["Class"]} if node.get("Class") else set()
    return found | {name for item in node.values() for name in classes(item)}


def test_every_class_is_one_that_rviz_has(tmp_path):
    """As the plugins_description.xml of rviz_default_plugins 14 and nav2_rviz_plugins 1.3 have."""
    displays = "Grid LaserScan Map MarkerArray Path Polygon PoseWithCovariance RobotModel TF"
    tools = "FocusCamera Interact Measure MoveCamera Select SetGoal SetInitialPose"
    known = {f"rviz_default_plugins/{name}" for name in f"{displays} {tools} TopDownOrtho".split()}
    known |= {
        f"rviz_common/{name}" for name in ("Displays", "Group", "Time", "Tool Properties", "Views")
    }
    known.add("nav2_rviz_plugins/ParticleCloud")
    write_rviz(tmp_path, ROBOTS)
    found = [classes(yaml.safe_load(path.read_text())) for path in tmp_path.iterdir()]
    assert set.union(*found) == known


def test_every_robot_and_the_swarm_have_a_layout(tmp_path):
    write_foxglove(tmp_path, ROBOTS)
    for path in tmp_path.iterdir():
        layout = json.loads(path.read_text())
        assert leaves(layout["layout"]) == set(layout["configById"])
    text = (tmp_path / "Srobot2.json").read_text()
    assert "/Srobot2/plan" in text
    assert "/Srobot1/" not in text


def test_a_topic_has_the_quality_of_its_publisher():
    known = {topic.name: topic for topic in all_topics(ROBOTS)}
    for layout in layouts("rviz", ROBOTS).values():
        for shown in named_topics(layout):
            if topic := known.get(shown.name):
                assert shown.durability == ("Transient Local" if topic.is_latched else "Volatile")
                assert shown.reliability == ("Reliable" if topic.is_reliable else "Best Effort")


def leaves(node):
    if isinstance(node, dict):
        return leaves(node["first"]) | leaves(node["second"])
    return {str(node)}


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("swarm", ["swarm"]),
        ("all", ROBOTS),
        ("Srobot3, Srobot1", ["Srobot3", "Srobot1"]),
        ("Srobot2,swarm", ["Srobot2", "swarm"]),
        ("merged", ["merged"]),
    ],
)
def test_windows(text, names):
    assert RunSpec(swarm_size=3, rviz=text).rviz_windows == names


def test_a_window_sees_the_frames_of_its_robot_and_an_unknown_one_has_none():
    command = " ".join(rviz.rviz_command("/opt/rviz2", Path("/run/Srobot2.rviz"), "Srobot2"))
    assert command.startswith("/opt/rviz2 -d /run/Srobot2.rviz --ros-args -r /tf:=/Srobot2/tf ")
    assert "-r /tf_static:=/Srobot2/tf_static" in command
    assert "-p use_sim_time:=true" in command
    with pytest.raises(ConfigError, match="unknown robot 'Srobot4' in --rviz"):
        _ = RunSpec(swarm_size=3, rviz="Srobot4").rviz_windows


@pytest.mark.parametrize(
    ("words", "result"),
    [
        ("", ""),
        ("--rviz", "--rviz swarm"),
        ("--rviz --seed 3", "--rviz swarm --seed 3"),
        ("--rviz all --seed 3", "--rviz all --seed 3"),
        ("--seed 3 --rviz", "--seed 3 --rviz swarm"),
    ],
)
def test_the_names_after_rviz_may_be_left_out(words, result):
    assert with_value(words.split(), "--rviz", "swarm") == result.split()
