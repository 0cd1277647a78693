"""Publishers on a robot's topics that have no business there: found, named once, ignored."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node

from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.ros_poll import UNKNOWN_NODE, full_name
from swarm_common.process.messages import ForeignPublisher
from swarm_common.process.pipes import EventWriter

MOST_KNOWN = 1000  # that are named; a forger has as many names as he likes
WORLD_SPACE = "/sim/"  # namespace of its nodes, on every host
NAVIGATOR = "navigator"  # node in a robot's namespace that commands it
AT_A_TIME = 5  # robots that are looked at in a turn, as each look costs
OURS = ("odom", "scan", "battery_state", "neighbors")  # what only the world publishes of a robot
ROBOTS = ("cmd_vel", "beacon")  # what only a robot's navigator does


class Foreigners:
    """Reports foreign publishers on topics that belong to the world or to a robot's navigator."""

    def __init__(self, rejections: Rejections, events: EventWriter) -> None:
        self.rejections = rejections
        self._events = events
        self._known: set[tuple[str, str]] = set()
        self._next = 0

    def ignore(self, topic: str, node: str) -> None:
        """Count a message that is ignored, as its sender does not own the topic."""
        self.rejections.reject(topic.rpartition("/")[2], node, f"not its place to publish {topic}")
        self.meet(topic, node)

    def meet(self, topic: str, node: str) -> None:
        """Report a foreign publisher, once."""
        if (topic, node) not in self._known and len(self._known) < MOST_KNOWN:
            self._known.add((topic, node))
            self._events.write(ForeignPublisher(topic, node))

    def look(self, nodes: Sequence[tuple[Node, str]], *, is_free_run: bool) -> None:
        """Check for foreign publishers that have sent nothing yet; each time at a few robots.

        Args:
            nodes: World's node and name of each robot that is there.
            is_free_run: Whether anybody may command robots.
        """
        for _ in range(min(AT_A_TIME, len(nodes))):
            self._next = (self._next + 1) % len(nodes)
            node, robot = nodes[self._next]
            self._look_at(node, f"/{robot}", OURS, WORLD_SPACE)
            if not is_free_run:
                self._look_at(node, f"/{robot}", ROBOTS, f"/{robot}/{NAVIGATOR}")
        if nodes:
            self._look_at(nodes[0][0], "", ("map",), WORLD_SPACE)

    def _look_at(self, node: Node, space: str, topics: Sequence[str], rightful: str) -> None:
        """Check topics of nodes whose names begin like the rightful one's."""
        for name in topics:
            topic = f"{space}/{name}"
            if node.count_publishers(topic) > 1:
                for info in node.get_publishers_info_by_topic(topic):
                    who = full_name(info)
                    if not who.startswith(rightful) and who != UNKNOWN_NODE:
                        self.meet(topic, who)
