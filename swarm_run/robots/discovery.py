"""Finds the running robots and asks for their parameters over ROS, as any other terminal would."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import rclpy
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from swarm_interfaces.msg import Mission

from swarm_common.files.sites_io import load_sites
from swarm_common.middleware.ros_io import LATCHED
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_common.model.robot_names import RobotNames, natural
from swarm_common.model.sites import Sites
from swarm_run.robots.swarm_watch import SwarmPatience

STATUS_TYPE = "swarm_interfaces/msg/RobotStatus"
# Every process announces itself once a second (fastdds.xml); on a busy machine that takes longer.
NEWS_LIMIT = 5.0  # [s] of wall time without news after which no robot or mission is looked for
CALM_TIME = 2.0  # [s] likewise for missions of which no process is known
ANSWER_LIMIT = 20.0  # [s] of wall time for a navigator to answer, on a busy machine
ASK_PERIOD = 2.0  # [s] after which a question is repeated: discovery may have lost the answer


def find_robots(node: Node, wanted: Sequence[str], patience: SwarmPatience) -> list[str]:
    """Return the names of the robots that run, sorted, agv2 before agv10.

    Args:
        wanted: Return as soon as these are seen; empty to look for all.

    Raises:
        ConfigError: If there are none.
    """
    start = changed = time.monotonic()
    seen: set[str] = set()
    while True:
        now = time.monotonic()
        found = robots_in_graph(node)
        if found != seen:
            seen, changed = found, now
        complete = bool(wanted) and seen.issuperset(wanted)
        if complete or (seen and now - changed > NEWS_LIMIT):
            return sorted(seen, key=natural)
        if not seen:
            patience.check(now - start)
        rclpy.spin_once(node, timeout_sec=0.1)


def robots_in_graph(node: Node) -> set[str]:
    """Return the names of the robots that are seen now.

    Args:
        node: Node whose view of the ROS graph counts; it is not spun.
    """
    return {
        name.split("/")[1]
        for name, types in node.get_topic_names_and_types()
        if name.endswith("/status")
        and name.count("/") == 2
        and STATUS_TYPE in types
        and node.count_publishers(name)  # of a robot that was taken out, only listeners are left
    }


def read_sites(node: Node, robot: str) -> tuple[Sites, str]:
    """Return the sites that a robot was started with, and their file for messages.

    Args:
        node: Node that asks; it is spun here.

    Raises:
        ConfigError: If the navigator does not answer, or the file is unusable.
    """
    values = read_parameters(node, robot, ["sites"])
    path = values[0].string_value if values else ""
    return (load_sites(Path(path)), path) if path else (Sites(), f"the world of {robot}")


def read_number(node: Node, robot: str) -> int:
    """Return a robot's number; if its navigator is another's, that of the usual name.

    Raises:
        ConfigError: If the navigator does not answer.
    """
    values = read_parameters(node, robot, ["robot_id"])
    return (values[0].integer_value if values else 0) or RobotNames().number_of(robot)


def read_home(node: Node, robot: str) -> Pose | None:
    """Return where a robot was started [map frame]; None if its navigator does not know.

    Raises:
        ConfigError: If the navigator does not answer.
    """
    values = read_parameters(node, robot, [f"initial_pose.{name}" for name in ("x", "y", "yaw")])
    if len(values) != 3 or any(v.type != ParameterType.PARAMETER_DOUBLE for v in values):
        return None
    return Pose(*(value.double_value for value in values))


def robot_on_mission(node: Node, robots: Sequence[str]) -> str | None:
    """Return the first of some robots that a process drives through a mission, or is about to.

    A process that drives a robot keeps its topic `mission` until it ends, so that latecomers learn
    the state; the latest message counts. Before the answer is "none", such a process gets the time
    to be discovered: it may be later than the robot itself.

    Args:
        robots: Names of the robots to ask about.

    Returns:
        Name of the robot; None if none of them is on a mission.
    """
    said: dict[str, list[bool]] = {robot: [] for robot in robots}
    topics = {robot: f"/{robot}/mission" for robot in robots}
    subscriptions = [
        node.create_subscription(
            Mission, topic, lambda message, said=said[robot]: said.append(message.active), LATCHED
        )
        for robot, topic in topics.items()
    ]
    try:
        start = changed = time.monotonic()
        known = -1
        while not any(map(any, said.values())):
            now = time.monotonic()
            counts = {robot: node.count_publishers(topic) for robot, topic in topics.items()}
            if (news := sum(counts.values()) + len(node.get_node_names())) != known:
                known, changed = news, now
            silent = [robot for robot in robots if len(said[robot]) < counts[robot]]
            if now - changed > CALM_TIME and (not silent or now - start > NEWS_LIMIT):
                return silent[0] if silent else None
            rclpy.spin_once(node, timeout_sec=0.1)
        return next(robot for robot in robots if any(said[robot]))
    finally:
        for subscription in subscriptions:
            node.destroy_subscription(subscription)


def read_parameters(node: Node, robot: str, names: list[str]) -> list[ParameterValue]:
    """Return parameters of a navigator; empty if one of them is not declared.

    Args:
        names: Names of the parameters, like `initial_pose.x`.

    Returns:
        One value per name, in their order.

    Raises:
        ConfigError: If the navigator does not answer.
    """
    service = f"/{robot}/navigator/get_parameters"
    client = node.create_client(GetParameters, service)
    request = GetParameters.Request(names=names)
    try:
        deadline = time.monotonic() + ANSWER_LIMIT
        while time.monotonic() < deadline:
            if not client.service_is_ready():
                rclpy.spin_once(node, timeout_sec=0.1)
                continue
            future = client.call_async(request)
            rclpy.spin_until_future_complete(node, future, timeout_sec=ASK_PERIOD)
            if future.done():
                return list(future.result().values)
        raise ConfigError(f"{service} does not answer; is the navigator of {robot} alive?")
    finally:
        node.destroy_client(client)
