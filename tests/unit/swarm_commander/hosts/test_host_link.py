"""The line between the hosts: reports and tables are whole states, of which the newest counts."""

from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy

from swarm_commander.hosts import host_client, host_server
from swarm_commander.hosts.host_client import HostClient
from swarm_commander.hosts.host_server import HostServer
from swarm_commander.hosts.host_table import HOSTS, TABLE_TOPIC
from swarm_common.process.pipes import EventWriter

SECRET = "a secret of this swarm"


class Node:
    """Stands in for rclpy's: remembers which topics were made, and how."""

    def __init__(self):
        self.qualities: dict[str, list[QoSProfile]] = {}

    def create_publisher(self, _, topic, quality):
        self.qualities.setdefault(topic, []).append(quality)
        return SimpleNamespace(publish=lambda _: None)

    def create_subscription(self, _, topic, __, quality):
        self.qualities.setdefault(topic, []).append(quality)


@pytest.fixture(autouse=True)
def _no_sockets(monkeypatch):
    for module in (host_client, host_server):
        monkeypatch.setattr(module, "ProbeSocket", lambda *_: None)


def test_a_lost_report_holds_back_no_later_one(tmp_path):
    """A reliable topic waits for what was lost: at 1 % loss, "nothing is heard" was said."""
    node: Any = Node()
    place = {"address": "10.0.0.1", "own_address": "10.0.0.2", "world_address": "10.0.0.1"}
    description = {"run": "run", "robots": {"Srobot1": {}}}
    HostServer(node, {**place, "domain": 7, "description": description}, EventWriter(None), SECRET)
    who = {"host": "a", "label": "first", "robots": [1], "edition": "1", "stated": {}}
    paths = {"description_path": str(tmp_path / "description.json")}
    HostClient(node, {**place, **who, **paths, "domain": 7}, EventWriter(None), SECRET)
    for topic in (HOSTS, TABLE_TOPIC):
        ends = [quality.reliability for quality in node.qualities[topic]]
        assert ends == [ReliabilityPolicy.BEST_EFFORT] * 2
