"""Which robots run, and what they know: asked over ROS, as any other terminal would."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import rclpy
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from swarm_interfaces.msg import Mission

from swarm_common.errors import ConfigError
from swarm_common.records import Pose
from swarm_common.ros_io import LATCHED
from swarm_common.sites import Sites
from swarm_common.sites_io import load_sites

STATUS_TYPE = "swarm_interfaces/msg/RobotStatus"
LOOK_LIMIT = 4.0  # [s] of wall time to see a swarm
CALM_TIME = 1.0  # [s] without a new robot after which all have been seen


def find_robots(node: Node, domain: int, wanted: Sequence[str]) -> list[str]:
    """Return the names of the robots that run, in order of their numbers.

    Args:
        node: Node that looks.
        domain: For the message.
        wanted: Return as soon as these are seen; empty to look for all.

    Raises:
        ConfigError: If there are none.
    """
    start = changed = time.monotonic()
    seen: set[str] = set()
    while True:
        now = time.monotonic()
        found = _robots_in_graph(node)
        if found != seen:
            seen, changed = found, now
        complete = bool(wanted) and seen.issuperset(wanted)
        if complete or (seen and now - changed > CALM_TIME):
            return sorted(seen, key=lambda name: (len(name), name))
        if not seen and now - start > LOOK_LIMIT:
            raise ConfigError(
                f"no swarm is running in ROS domain {domain} on this machine;"
                " start one with swarm-up, or source the env.sh in its run folder"
            )
        rclpy.spin_once(node, timeout_sec=0.1)


def _robots_in_graph(node: Node) -> set[str]:
    return {
        name.split("/")[1]
        for name, types in node.get_topic_names_and_types()
        if name.endswith("/status") and name.count("/") == 2 and STATUS_TYPE in types
    }


def read_sites(node: Node, robot: str) -> tuple[Sites, str]:
    """Return the sites that a robot was started with, and their file for messages.

    Raises:
        ConfigError: If the navigator does not answer.
    """
    values = _read_parameters(node, robot, ["sites"])
    path = values[0].string_value if values else ""
    return (load_sites(Path(path)), path) if path else (Sites(), f"the world of {robot}")


def read_home(node: Node, robot: str) -> Pose | None:
    """Return where a robot was started [map frame]; None if its navigator does not know.

    Raises:
        ConfigError: If the navigator does not answer.
    """
    values = _read_parameters(node, robot, [f"initial_pose.{name}" for name in ("x", "y", "yaw")])
    if len(values) != 3 or any(v.type != ParameterType.PARAMETER_DOUBLE for v in values):
        return None
    return Pose(*(value.double_value for value in values))


def is_on_mission(node: Node, robot: str) -> bool:
    """Return whether somebody drives a robot through a mission, or is about to.

    Who drives a robot keeps its topic `mission` until the end of the process, so that latecomers
    learn how things are; what counts is what was said there last.
    """
    topic = f"/{robot}/mission"
    said: list[bool] = []
    subscription = node.create_subscription(
        Mission, topic, lambda message: said.append(message.active), LATCHED
    )
    try:
        deadline = time.monotonic() + CALM_TIME
        while len(said) < node.count_publishers(topic) and time.monotonic() < deadline:
            rclpy.spin_once(node, timeout_sec=0.1)
        return any(said) or len(said) < node.count_publishers(topic)
    finally:
        node.destroy_subscription(subscription)


def _read_parameters(node: Node, robot: str, names: list[str]) -> list[ParameterValue]:
    """Return parameters of a navigator; empty if one of them is not declared."""
    service = f"/{robot}/navigator/get_parameters"
    silent = f"{service} does not answer; is the navigator of {robot} alive?"
    client = node.create_client(GetParameters, service)
    try:
        if not _wait_for(node, client):
            raise ConfigError(silent)
        future = client.call_async(GetParameters.Request(names=names))
        rclpy.spin_until_future_complete(node, future, timeout_sec=10.0)
        if not future.done():
            raise ConfigError(silent)
        return list(future.result().values)
    finally:
        node.destroy_client(client)


def _wait_for(node: Node, client: object) -> bool:
    deadline = time.monotonic() + LOOK_LIMIT
    while not client.service_is_ready():  # type: ignore[attr-defined]
        if time.monotonic() > deadline:
            return False
        rclpy.spin_once(node, timeout_sec=0.1)
    return True
