"""Plays a bag on the ROS graph, where RViz, Foxglove and any node see it as if the swarm ran."""

from __future__ import annotations

import time
from collections.abc import Callable

import rclpy
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from swarm_common.middleware.topic_table import Topic
from swarm_recording.bag import NANOSECONDS, Bag
from swarm_recording.ros_types import message_class, quality

LOOK_PERIOD = 0.005  # [s] of wall time between two looks at the clock
DEPTH = 100  # messages of a topic that a slow listener may be behind
DISCOVERY_TIME = 1.0  # [s] for listeners to find the topics


class Player:
    """Publishes the messages of a bag, byte by byte as they were recorded."""

    def __init__(self, node: Node, bag: Bag) -> None:
        self._bag = bag
        self._publishers: dict[str, Publisher] = {
            name: node.create_publisher(message_class(topic.type), name, _offered(topic))
            for name, topic in bag.topics.items()
        }

    def play(
        self,
        start: float,
        speed: float | None,
        tell: Callable[[float], None],
        is_stopped: Callable[[], bool],
    ) -> int:
        """Play once to the end; return the number of messages.

        Args:
            start: [s] where to begin; the last message of each topic before that is published
                first.
            speed: Times real time; None for as fast as possible.
            tell: Called with the time in the bag [s] from time to time.
            is_stopped: Asked whether to stop.
        """
        at = round(start * NANOSECONDS)
        count = 0
        for name, _, data in self._bag.latest(self._publishers.keys(), at):
            self._publishers[name].publish(data)
            count += 1
        began = time.monotonic()
        for name, stamp, data in self._bag.messages(self._publishers.keys(), after=at):
            while speed is not None and (stamp - at) / NANOSECONDS > speed * (
                time.monotonic() - began
            ):
                if is_stopped():
                    return count
                time.sleep(LOOK_PERIOD)
            if is_stopped():
                return count
            self._publishers[name].publish(data)
            count += 1
            tell(stamp / NANOSECONDS)
        return count


def _offered(topic: Topic) -> QoSProfile:
    return quality(topic, 1 if topic.is_latched else DEPTH)


def play_on_graph(
    bag: Bag,
    start: float,
    speed: float | None,
    *,
    loops: bool,
    tell: Callable[[float], None],
    is_stopped: Callable[[], bool],
) -> int:
    """Play a bag in this process's ROS domain; return the number of messages."""
    rclpy.init(signal_handler_options=rclpy.SignalHandlerOptions.NO)
    node = rclpy.create_node("replay", enable_rosout=False, start_parameter_services=False)
    player = Player(node, bag)
    time.sleep(DISCOVERY_TIME)
    count = player.play(start, speed, tell, is_stopped)
    while loops and not is_stopped():
        count += player.play(start, speed, tell, is_stopped)
    time.sleep(LOOK_PERIOD)
    node.destroy_node()
    rclpy.try_shutdown()
    return count
