"""A robot that is gone is not waited for."""

import time
from types import SimpleNamespace

import pytest

from swarm_run.robots.robot_watch import GONE_TIME, RobotWatch

DOMAIN = 17
STATUS = ["swarm_interfaces/msg/RobotStatus"]


class Graph:
    """What a node sees of the robots of a swarm."""

    def __init__(self, *robots):
        self.robots = list(robots)
        self.context = SimpleNamespace(get_domain_id=lambda: DOMAIN)

    def count_publishers(self, topic):
        return int(topic.split("/")[1] in self.robots)

    def get_topic_names_and_types(self):
        return [(f"/{name}/status", STATUS) for name in self.robots]


@pytest.fixture
def swarm(monkeypatch):
    """Whether a swarm has the domain; the test may change it."""
    state = SimpleNamespace(runs=True)
    for module in ("swarm_watch", "robot_watch"):
        name = f"swarm_run.robots.{module}.has_swarm"
        monkeypatch.setattr(name, lambda _: state.runs)
    return state


def reasons(watch, begin, end):
    return [watch.look(begin + step) for step in range(int(end - begin) + 1)]


def test_who_was_removed_is_gone_and_who_is_restarted_comes_back(swarm):
    graph = Graph("Srobot1", "Srobot2")
    watch = RobotWatch(graph, "Srobot1")
    assert not any(reasons(watch, 100.0, 160.0))
    graph.robots.remove("Srobot1")
    heard = reasons(watch, 161.0, 161.0 + GONE_TIME)
    assert not any(heard[:-1])
    assert heard[-1] == "Srobot1 is gone: it was removed, or its navigator has ended"
    graph = Graph("Srobot1")
    watch = RobotWatch(graph, "Srobot1")
    watch.look(100.0)
    graph.robots.clear()
    reasons(watch, 101.0, 104.0)
    graph.robots.append("Srobot1")
    assert not any(reasons(watch, 105.0, 120.0))


def test_who_was_never_there_is_named_apart_from_a_swarm_that_starts(swarm):
    watch = RobotWatch(Graph("Srobot2"), "Srobot9")
    assert reasons(watch, 100.0, 110.0)[-1] == ("no robot 'Srobot9' is running; there are Srobot2")
    watch = RobotWatch(Graph(), "Srobot1")
    assert not any(reasons(watch, 100.0, 200.0))
    swarm.runs = False
    watch = RobotWatch(Graph(), "Srobot1")
    assert "no swarm is running in ROS domain 17" in reasons(watch, 100.0, 110.0)[-1]


def test_the_swarm_ends_with_its_robots(swarm):
    graph = Graph("Srobot1")
    watch = RobotWatch(graph, "Srobot1")
    now = time.monotonic()
    watch.look(now + 2.0)
    swarm.runs = False
    assert watch.look(now + 4.0) == "the swarm has ended"
