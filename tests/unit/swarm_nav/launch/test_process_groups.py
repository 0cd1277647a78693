"""Which robots share a process, and whom that process announces itself to."""

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml

from swarm_common.middleware import ros_env
from swarm_common.model.robot_parameters import robot_parameters
from swarm_describe.robots.loading import load_robot
from swarm_nav.launch.process_groups import Grouping
from tests.unit.swarm_common.middleware.test_ros_env import PORTS


@pytest.fixture(autouse=True)
def _our_profile(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "3")
    monkeypatch.setenv(ros_env.PROFILES, str(Path(ros_env.__file__).parent / "fastdds.xml"))


def grouping(folder, peers, **more):
    robots = []
    model = robot_parameters(load_robot("turtlebot3_waffle"))
    values = {f"robot.{name}": value for name, value in model.items()}
    for number, ports in enumerate(peers, 1):
        name = f"Srobot{number}"
        params = folder / f"{name}.yaml"
        tree = {f"/{name}/navigator": {"ros__parameters": values | {"robot_id": number}}}
        params.write_text(yaml.safe_dump(tree), encoding="utf-8")
        robots.append({"name": name, "params": str(params), "peers": ports})
    path = folder / "navigators.json"
    path.write_text(json.dumps({"robots": robots, **more}), encoding="utf-8")
    return Grouping(path)


def ports_in(profile):
    assert profile is not None
    return [int(node.text or 0) for node in ElementTree.parse(profile).iterfind(PORTS)]


def test_a_pack_meets_whom_any_of_its_robots_needs(tmp_path):
    world = ros_env.world_port()
    peers = [[world, world + 4], [world, world + 4], [world, world + 4], [world, world + 6]]
    first, second = grouping(tmp_path, peers, pack=2).groups
    assert [sorted(first.names), sorted(second.names)] == [
        ["Srobot1", "Srobot2"],
        ["Srobot3", "Srobot4"],
    ]
    assert ports_in(first.profile)[:2] == [world, world + 4]
    assert ports_in(second.profile)[:3] == [world, world + 4, world + 6]
    newcomers = ports_in(first.profile)[2:]
    assert newcomers[0] == world + 2 * (3 + 1 + 2)  # after four that were there and two processes


def test_a_small_swarm_and_who_comes_back_meet_the_world_and_a_newcomer_everybody(tmp_path):
    groups = grouping(tmp_path, [[], []]).groups
    assert [ports_in(group.profile)[0] for group in groups] == [ros_env.world_port()] * 2
    world = ros_env.world_port()
    swarm = grouping(tmp_path, [[world, world + 4], [world, world + 6]])
    params = tmp_path / "Srobot3.yaml"
    text = (tmp_path / "Srobot2.yaml").read_text("utf-8").replace("Srobot2", "Srobot3")
    params.write_text(text, encoding="utf-8")
    newcomer = swarm.newcomer("Srobot3", str(params))
    assert ports_in(newcomer.profile)[:3] == [world, world + 4, world + 6]
    world = ros_env.world_port()
    swarm = grouping(tmp_path, [[world, world + 4], [world, world + 6]])
    again = swarm.newcomer("Srobot2", str(tmp_path / "Srobot2.yaml"))
    assert ports_in(again.profile)[:2] == [world, world + 6]


def test_a_profile_of_the_user_is_left_alone(tmp_path, monkeypatch):
    monkeypatch.setenv(ros_env.PROFILES, "/my/profile.xml")
    (group,) = grouping(tmp_path, [[]]).groups
    assert group.profile is None
