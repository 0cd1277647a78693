"""Which messages of a robot count as its answer to the tick in hand, on a node without a graph."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

from swarm_common.middleware.cdr import CommandWriter
from swarm_common.middleware.rejections import Rejections
from swarm_common.model.beacon import BEACON_DTYPE, serialize_beacon
from swarm_common.model.records import Twist
from swarm_common.model.sensors import IDEAL
from swarm_common.process.pipes import EventWriter
from swarm_describe.robots.loading import load_robot
from swarm_sim.ros.robots import links as ros_links
from swarm_sim.ros.robots.foreign import Foreigners
from swarm_sim.ros.robots.links import RobotLink
from swarm_sim.ros.settings import parse_settings

MODEL = "turtlebot3_waffle"
SLOW, FAST = Twist(0.1, 0.0, 0.0), Twist(0.2, 0.0, 0.5)
WRITER = CommandWriter("base_footprint")


class Node:
    """Stands in for rclpy's: hands out publishers that nobody reads."""

    def create_publisher(self, *_, **__):
        return SimpleNamespace(publish=lambda _: None, get_subscription_count=lambda: 0)


class Topic:
    """Stands in for a polled subscription: holds the messages that wait."""

    def __init__(self, _node, _kind, name, *rest, is_shared):
        self.name = name
        self.is_rightful: Callable[[str], bool] = rest[1]
        self.is_shared = is_shared
        self.waiting: list[bytes] = []

    def take(self):
        return self.waiting.pop(0) if self.waiting else None


class Robot:
    """One robot's link, and the messages that its navigator sends to it."""

    def __init__(self, free_run):
        self.answers = 0
        self.rejections = Rejections(EventWriter(None), lambda _: None)
        settings = parse_settings(
            {"world": "any", "robots": [{"name": "Srobot1", "model": MODEL}], "free_run": free_run},
            "test",
        )
        spec = load_robot(MODEL)
        self.link = RobotLink(
            Node(),
            Node(),
            "Srobot1",
            spec,
            "<robot name='none'/>",
            settings,
            1,
            self.count,
            Foreigners(self.rejections, EventWriter(None)),
            IDEAL,
        )
        self.topics: dict[str, Topic] = {
            topic.name: topic for topic in vars(self.link).values() if isinstance(topic, Topic)
        }

    def count(self):
        self.answers += 1

    def command(self, tick, twist):
        self._send("/Srobot1/cmd_vel", WRITER.encode(tick, twist))

    def beacon(self, tick, robot_id=1):
        record = np.zeros(1, BEACON_DTYPE)[0]
        record["id"], record["tick"], record["held_size"] = robot_id, tick, 1
        record["sec"], record["nanosec"] = divmod(tick * 100_000_000, 1_000_000_000)
        self._send("/Srobot1/beacon", serialize_beacon(record))

    def _send(self, topic, message):
        self.topics[topic].waiting.append(message)
        self.link.receive_answers()


@pytest.fixture(autouse=True)
def _no_graph(monkeypatch):
    monkeypatch.setattr(ros_links, "SoleTopic", Topic)


@pytest.mark.parametrize("free_run", [False, True])
def test_command_and_beacon_of_the_tick_in_hand_are_the_answer(free_run):
    robot = Robot(free_run)
    robot.link.open(7)
    robot.command(7, SLOW)
    assert robot.answers == 0
    robot.beacon(7)
    robot.command(7, FAST)
    assert robot.answers == 1
    assert robot.link.fresh_command() == SLOW


def test_in_lockstep_the_late_answer_to_the_last_tick_is_no_command():
    robot = Robot(free_run=False)
    robot.link.open(7)
    robot.link.open(8)
    robot.command(7, FAST)
    robot.beacon(7)
    assert robot.link.fresh_command() is None
    assert robot.link.beacon is None
    robot.command(8, SLOW)
    robot.beacon(8)
    assert robot.link.fresh_command() == SLOW
    assert robot.answers == 1


def test_in_free_run_a_command_of_any_stamp_counts_if_it_is_a_number():
    robot = Robot(free_run=True)
    robot.link.open(8)
    robot.command(3, FAST)
    robot.beacon(3)
    assert robot.link.fresh_command() == FAST
    assert robot.link.beacon is not None
    robot.link.open(9)
    assert robot.link.fresh_command() is None
    robot = Robot(free_run=True)
    robot.link.open(8)
    robot.command(8, Twist(float("nan"), 0.0, 0.0))
    assert robot.link.fresh_command() is None
    assert robot.rejections.counts == {"cmd_vel": 1}


def test_what_is_no_answer_of_the_robot_is_turned_away_and_counted():
    """A future stamp kept a late robot from being waited for again."""
    robot = Robot(free_run=False)
    robot.link.open(8)
    robot.command(2_000_000, FAST)
    assert robot.link.newest_tick == -1
    robot.command(8, SLOW)
    robot.beacon(8, robot_id=2)
    assert not robot.link.has_answered
    robot.beacon(8)
    assert robot.link.has_answered
    assert robot.rejections.counts == {"cmd_vel": 1, "beacon": 1}


@pytest.mark.parametrize("name", ["cmd_vel", "beacon"])
def test_a_robots_navigator_commands_it_in_free_run_any_node_of_the_robot(name):
    lockstep = Robot(free_run=False).topics[f"/Srobot1/{name}"]
    free_run = Robot(free_run=True).topics[f"/Srobot1/{name}"]
    who = ("/Srobot1/navigator", "/Srobot1/velocity_smoother", "/Srobot2/navigator", "/teleop")
    assert [lockstep.is_rightful(node) for node in who] == [True, False, False, False]
    assert [free_run.is_rightful(node) for node in who] == [True, True, False, False]
    assert (lockstep.is_shared, free_run.is_shared) == (False, True)
