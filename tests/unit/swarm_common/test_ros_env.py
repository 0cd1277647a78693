"""Defaults of the ROS environment, and the discovery profile of robots."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from swarm_common import ros_env

PORTS = ".//{http://www.eprosima.com}initialPeersList//{http://www.eprosima.com}port"


@pytest.fixture(autouse=True)
def _no_variables(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (*ros_env.VARIABLES, "FASTDDS_DEFAULT_PROFILES_FILE", "ROS_DISCOVERY_SERVER"):
        monkeypatch.setenv(name, "")  # so that what a test sets is taken back
        monkeypatch.delenv(name)


def test_our_profile_is_the_default() -> None:
    ros_env.set_defaults()
    assert Path(os.environ[ros_env.PROFILES]).name == "fastdds.xml"
    ElementTree.parse(os.environ[ros_env.PROFILES])


@pytest.mark.parametrize(
    ("name", "value"),
    [
        (ros_env.DISCOVERY_RANGE, "SUBNET"),
        ("ROS_DISCOVERY_SERVER", "127.0.0.1:11811"),
        ("FASTDDS_DEFAULT_PROFILES_FILE", "/my/profile.xml"),
    ],
)
def test_the_users_choice_is_respected(
    name: str, value: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(name, value)
    ros_env.set_defaults()
    assert os.environ[name] == value
    assert ros_env.PROFILES not in os.environ


def test_robots_announce_themselves_to_the_world_and_to_newcomers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "3")
    ros_env.set_defaults()
    ros_env.announce_to_few(tmp_path, processes=20)
    found = ElementTree.parse(os.environ[ros_env.PROFILES]).iterfind(PORTS)
    ports = [int(node.text or 0) for node in found]
    first = 7400 + 250 * 3 + 10
    assert ports[0] == first
    assert ports[1:] == [first + 2 * i for i in range(21, 21 + ros_env.NEWCOMERS)]


def test_a_profile_of_the_user_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ros_env.PROFILES, "/my/profile.xml")
    ros_env.announce_to_few(tmp_path, processes=20)
    assert os.environ[ros_env.PROFILES] == "/my/profile.xml"
    assert not list(tmp_path.iterdir())
