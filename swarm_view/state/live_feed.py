"""Where messages come from; in the live graph subscriptions exist while topics are wanted."""

from __future__ import annotations

from collections.abc import Collection
from typing import Protocol

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from swarm_common.middleware.ros_poll import PolledTopic
from swarm_view.state.decode import message_class
from swarm_view.state.topics import STATUS, VERDICT, is_latched, type_of

# No process waits for a slow viewer: messages that it does not take in time are lost.
STREAM = QoSProfile(depth=4, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
EVENTS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
STATUSES = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)  # soon repeated
STATUS_ENDING = f"/{STATUS}"
STATUS_TURN = 5  # calls of `take` from one look at the robots' statuses to the next


class Feed(Protocol):
    """Messages of the topics that are wanted, from the live graph or a recording; never waits."""

    def topics(self) -> dict[str, str]:
        """Return the type of every topic that there is, like `nav_msgs/msg/Path`."""

    def want(self, topics: Collection[str]) -> None:
        """Deliver these topics from now on, and no others.

        The last message of a newly wanted topic that is latched comes at once.
        """

    def take(self) -> list[tuple[str, bytes]]:
        """Return (topic, CDR bytes) of the messages since the last call, oldest first."""

    def close(self) -> None:
        """Release all resources."""


class LiveFeed:
    """Topics of a node."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._topics: dict[str, PolledTopic] = {}
        self._turn = 0

    def topics(self) -> dict[str, str]:
        """Return the type of every topic in the graph."""
        return {name: types[0] for name, types in self._node.get_topic_names_and_types()}

    def want(self, topics: Collection[str]) -> None:
        """Subscribe to these topics, and to no others any more."""
        for topic in self._topics.keys() - topics:
            self._topics.pop(topic).destroy()
        for topic in topics - self._topics.keys():
            kind = message_class(type_of(topic))
            self._topics[topic] = PolledTopic(self._node, kind, topic, _quality(topic))

    def take(self) -> list[tuple[str, bytes]]:
        """Return the messages that have arrived."""
        self._turn = (self._turn + 1) % STATUS_TURN
        taken = []
        for topic, polled in self._topics.items():
            if self._turn and topic.endswith(STATUS_ENDING):
                continue  # of many robots, each rarely says something
            while (data := polled.take()) is not None:
                taken.append((topic, data))
        return taken

    def close(self) -> None:
        """Unsubscribe from everything."""
        self.want(set())


def _quality(topic: str) -> QoSProfile:
    if is_latched(topic):
        return LATCHED
    if topic.endswith(STATUS_ENDING):
        return STATUSES
    return EVENTS if topic == VERDICT else STREAM
