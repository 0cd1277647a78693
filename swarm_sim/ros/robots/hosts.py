"""Robots whose navigators are on other hosts: the radio's beacons go there in batches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rclpy.node import Node
from std_msgs.msg import UInt8MultiArray

from swarm_common.middleware import ros_io
from swarm_common.middleware.beacon_batch import BatchWriter, topic_of
from swarm_common.model.beacon import Reception
from swarm_common.model.records import stamp_from_tick


class Hosts:
    """Knows which robots are on which host, and sends each host its batch."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._batches: dict[str, tuple[Any, BatchWriter]] = {}  # publisher and writer, by host
        self._place_of: dict[int, tuple[str, int]] = {}  # host and robot's number, by index

    def assign(self, host: str, robots: Mapping[int, int], run: str, secret: str) -> None:
        """Send the beacons of some robots to a host from now on."""
        publisher = self._node.create_publisher(UInt8MultiArray, topic_of(host), ros_io.RELIABLE)
        self._batches[host] = publisher, BatchWriter(secret, run, host)
        self._place_of |= {robot: (host, number) for robot, number in robots.items()}

    def has(self, robot: int) -> bool:
        """Whether a robot is on another host."""
        return robot in self._place_of

    def publish(self, tick: int, receptions: Mapping[int, Reception]) -> None:
        """Send to other hosts what their robots hear.

        Args:
            receptions: By index of the robot; only of robots on other hosts.
        """
        by_host: dict[str, dict[int, Reception]] = {}
        for robot, reception in receptions.items():
            host, number = self._place_of[robot]
            by_host.setdefault(host, {})[number] = reception
        for host, heard in by_host.items():
            publisher, writer = self._batches[host]
            publisher.publish(writer.encode(*stamp_from_tick(tick), heard))
