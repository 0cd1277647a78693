"""Who is found in a ROS graph whose processes are discovered one after another."""

import pytest

from swarm_run.robots import discovery
from swarm_run.robots.swarm_watch import SwarmPatience


class LateNode:
    """A node that discovers robots at times [s] of a clock that only waiting moves."""

    def __init__(self, times, monkeypatch):
        self.now = 0.0
        self.times = times
        monkeypatch.setattr(discovery.time, "monotonic", lambda: self.now)
        monkeypatch.setattr(discovery.rclpy, "spin_once", self.wait)

    def wait(self, node, timeout_sec):
        self.now += timeout_sec

    def get_topic_names_and_types(self):
        seen = [name for name, time in self.times.items() if self.now >= time]
        return [(f"/{name}/status", [discovery.STATUS_TYPE]) for name in seen]

    def count_publishers(self, topic):
        return 1


@pytest.mark.parametrize(
    ("wanted", "found", "end"),
    [
        (["agv1"], ["agv1", "agv2"], 4.5),  # two seconds after agv2 it was "not running"
        (["agv2"], ["agv2"], 0.5),
        (["agv3"], ["agv1", "agv2"], 9.6),
        ([], ["agv1", "agv2"], 9.6),  # for --all, agv1 did not exist
    ],
)
def test_a_robot_that_is_discovered_late_is_awaited(wanted, found, end, monkeypatch):
    node = LateNode({"agv2": 0.5, "agv1": 4.5}, monkeypatch)
    patience = SwarmPatience(0, lambda: True, lambda _: None)
    assert discovery.find_robots(node, wanted, patience) == found
    assert node.now == pytest.approx(end, abs=0.11)
