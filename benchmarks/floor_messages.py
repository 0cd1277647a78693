"""Cost of a message: processes that exchange a robot's messages of a tick and do nothing else.

One process plays the world: it publishes odom, neighbors and, in every other tick, a scan for each
robot. Each robot is a process that waits for them, takes them and answers with beacon and cmd_vel.
The calls are those of the swarm (`ros_poll`, messages as bytes), the computing is left out.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from typing import Any

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.node import Node
from rclpy.serialization import serialize_message
from sensor_msgs.msg import LaserScan
from swarm_interfaces.msg import Beacon, NeighborArray

from swarm_common.middleware import ros_env, ros_io
from swarm_common.middleware.ros_poll import PolledTopic, Waiter
from swarm_common.process.lifetime import die_with

TICKS = 400
WARM_TICKS = 20
WAIT = 0.5  # [s] at most for an answer
MATCH_LIMIT = 60.0  # [s] until everybody has found everybody
SCAN_TICKS = 2  # ticks of a revolution
NEIGHBOURS = 10  # beacons in a batch
RAYS = 360


def measure_messages(robots: int) -> float:
    """Return the CPU time [ms] of one robot's messages in one tick, on both sides together."""
    ros_env.set_defaults()
    command, parent = [sys.executable, "-m", __name__], os.getpid()
    children = [
        subprocess.Popen(
            [*command, str(number)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            preexec_fn=lambda: die_with(parent),
        )
        for number in range(robots)
    ]  # fmt: skip
    try:
        own = _play_world(robots)
    finally:
        answers = [child.communicate(b"end\n")[0] for child in children]
    theirs = [float(json.loads(answer.splitlines()[-1])["cpu"]) for answer in answers]
    return 1000.0 * (own + sum(theirs)) / (robots * TICKS)


def _play_world(robots: int) -> float:
    """Publish and take for all robots; return the CPU seconds of `TICKS` ticks."""
    context, node = _node("floor_world")
    links = [_WorldLink(node, number) for number in range(robots)]
    waiter = Waiter(context)
    limit = time.monotonic() + MATCH_LIMIT
    while not all(link.is_matched for link in links) and time.monotonic() < limit:
        time.sleep(0.05)
    cpu = 0.0
    for tick in range(-WARM_TICKS, TICKS):
        if tick == 0:
            cpu = _cpu()
        for link in links:
            link.publish(tick)
        for link in links:
            link.take(waiter)
    cpu = _cpu() - cpu
    context.try_shutdown()
    return cpu


class _WorldLink:
    """The world's side of one robot."""

    def __init__(self, node: Node, number: int) -> None:
        space = f"/floor{number}"
        self._odom = node.create_publisher(Odometry, f"{space}/odom", ros_io.RELIABLE)
        self._near = node.create_publisher(NeighborArray, f"{space}/neighbors", ros_io.RELIABLE)
        self._scan = node.create_publisher(LaserScan, f"{space}/scan", ros_io.SENSOR)
        self._answers = [
            PolledTopic(node, kind, f"{space}/{name}", ros_io.TICK_INPUT)
            for kind, name in ((TwistStamped, "cmd_vel"), (Beacon, "beacon"))
        ]
        self._data = _messages()

    @property
    def is_matched(self) -> bool:
        return bool(self._near.get_subscription_count())

    def publish(self, tick: int) -> None:
        self._odom.publish(self._data["odom"])
        if tick % SCAN_TICKS == 0:
            self._scan.publish(self._data["scan"])
        self._near.publish(self._data["neighbors"])

    def take(self, waiter: Waiter) -> None:
        for topic in self._answers:
            if topic.take() is None:
                waiter.wait([topic], WAIT)
                topic.take()


def _play_robot(number: int) -> None:
    """Answer until told to end; print the CPU seconds of the counted ticks."""
    context, node = _node(f"floor_robot{number}")
    space = f"/floor{number}"
    heard = PolledTopic(node, NeighborArray, f"{space}/neighbors", ros_io.TICK_INPUT)
    others = [
        PolledTopic(node, kind, f"{space}/{name}", ros_io.TICK_INPUT)
        for kind, name in ((Odometry, "odom"), (LaserScan, "scan"))
    ]
    beacon = node.create_publisher(Beacon, f"{space}/beacon", ros_io.RELIABLE)
    command = node.create_publisher(TwistStamped, f"{space}/cmd_vel", ros_io.RELIABLE)
    data, waiter = _messages(), Waiter(context)
    ticks, cpu = -WARM_TICKS, 0.0
    limit = time.monotonic() + MATCH_LIMIT
    while ticks < TICKS and time.monotonic() < limit:
        waiter.wait([heard], WAIT)
        if heard.take() is None:
            continue
        for topic in others:
            topic.take()
        if ticks == 0:
            cpu = _cpu()
        beacon.publish(data["beacon"])
        command.publish(data["command"])
        ticks += 1
        limit = time.monotonic() + MATCH_LIMIT
    cpu = _cpu() - cpu
    sys.stdin.readline()
    context.try_shutdown()
    sys.stdout.write(json.dumps({"cpu": cpu}) + "\n")


def _messages() -> dict[str, bytes]:
    """Return messages of the sizes that the swarm sends."""
    beacon = Beacon()
    return {
        "odom": serialize_message(Odometry()),
        "scan": serialize_message(LaserScan(ranges=[1.0] * RAYS)),
        "neighbors": serialize_message(NeighborArray(beacons=[beacon] * NEIGHBOURS)),
        "beacon": serialize_message(beacon),
        "command": serialize_message(TwistStamped()),
    }


def _node(name: str) -> tuple[Any, Any]:
    context = Context()
    rclpy.init(context=context)
    node = Node(
        name, context=context, enable_rosout=False, start_parameter_services=False,
        use_global_arguments=False,
    )  # fmt: skip
    return context, node


def _cpu() -> float:
    """Return the CPU seconds of this process, those of DDS's threads included."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    _play_robot(int(sys.argv[1]))
