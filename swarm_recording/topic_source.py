"""Which topics a recorder subscribes to: those of a swarm's table, or any of the ROS graph."""

from __future__ import annotations

import fnmatch
import importlib
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from swarm_common.middleware.cdr import TransformsReader
from swarm_common.middleware.topic_table import Topic, all_topics
from swarm_common.model.errors import ConfigError
from swarm_recording.filter import CLOCK
from swarm_recording.schema import schema_text
from swarm_recording.selection import select, select_of

LOOK_PERIOD = 0.5  # [s] of wall time between two looks at the graph
STATUS_TYPE = "swarm_interfaces/msg/RobotStatus"
MOST = 1000  # messages of a topic that stay for latecomers


class Changes(NamedTuple):
    """Topics that a recorder is to add, and namespaces that it leaves."""

    topics: Sequence[Topic] = ()
    gone: Collection[str] = ()  # like `/Srobot3/`


class TopicSource(Protocol):
    """Says what to record, again and again."""

    def begin(self) -> list[Topic]:
        """Return the topics to begin with.

        Raises:
            ConfigError: If what is asked for cannot be.
        """

    def changes(self, places: bytes) -> Changes:
        """Return what has changed; `places` is the newest message of `/sim/tf`, if any came."""


class SwarmTopics:
    """Topics of a swarm's table; robots that come later are those that `/sim/tf` shows."""

    def __init__(self, patterns: str, robots: Sequence[str]) -> None:
        """Select topics.

        Args:
            patterns: See `select`.
        """
        self._patterns, self._robots = patterns, set(robots)
        self._names = list(robots)
        self._reader = TransformsReader()

    def begin(self) -> list[Topic]:
        """Return the topics of the robots that are there."""
        return select(self._patterns, self._names)

    def changes(self, places: bytes) -> Changes:
        """Begin with robots that have come, and end with those that are gone."""
        if not places:
            return Changes()
        try:
            _, frames, _ = self._reader.read(places)
        except ValueError:  # from a foreign publisher; it is recorded all the same
            return Changes()
        robots = {frame.partition("/")[0] for frame in frames}
        new = [
            topic
            for robot in sorted(robots - self._robots)
            for topic in select_of(self._patterns, robot)
        ]
        gone = [f"/{robot}/" for robot in self._robots - robots]
        self._robots = robots
        return Changes(new, gone)


class GraphTopics:
    """Topics of the ROS graph by their names, from the moment at which somebody publishes them."""

    def __init__(
        self, node: Node, words: Collection[str], say: Callable[[str], None], *, hidden: bool
    ) -> None:
        """Look for topics.

        Args:
            words: Names like `/lights`, or patterns (`/Srobot1/*`); without a slash also relative
                to each robot of a swarm (`odom`). `*` is all.
            say: Told of each topic that cannot be recorded.
            hidden: Whether `*` means topics with a leading underscore in their name, too.
        """
        self._node, self._words, self._say, self._hidden = node, words, say, hidden
        self._known: set[str] = set()
        self._due = 0.0

    def begin(self) -> list[Topic]:
        """Return the topics that are published now."""
        return list(self.changes(b"").topics)

    @property
    def robots(self) -> list[str]:
        """Names of the swarm's robots, as far as the graph shows them."""
        return sorted(
            name.split("/")[1]
            for name, kinds in self._node.get_topic_names_and_types()
            if kinds == [STATUS_TYPE] and name.count("/") == 2 and name.endswith("/status")
        )

    def missing(self) -> list[str]:
        """Return the words that no topic matches so far."""
        robots = self.robots
        return [
            word
            for word in self._words
            if not any(_matches(name, word, robots) for name in self._known)
        ]

    def changes(self, places: bytes) -> Changes:
        """Return topics that are published for the first time; robots that leave change nothing."""
        now = time.monotonic()
        if now < self._due:
            return Changes()
        self._due = now + LOOK_PERIOD
        fresh = {
            name: kinds
            for name, kinds in self._node.get_topic_names_and_types()
            if name not in self._known
        }
        if not fresh:
            return Changes()
        robots = self.robots
        table = {topic.name: topic for topic in all_topics(robots)}
        found = []
        for name, kinds in sorted(fresh.items()):
            if not self._is_wanted(name, robots) or not self._node.count_publishers(name):
                continue
            self._known.add(name)
            try:
                found.append(self._topic(name, kinds, table.get(name)))
            except ConfigError as error:
                self._say(f"{name} is not recorded: {error}")
        return Changes(found)

    def _is_wanted(self, name: str, robots: Collection[str]) -> bool:
        is_hidden = any(part.startswith("_") for part in name.split("/"))
        return name in self._words or (
            (self._hidden or not is_hidden)
            and any(_matches(name, word, robots) for word in self._words)
        )

    def _topic(self, name: str, kinds: Sequence[str], listed: Topic | None) -> Topic:
        """Return a topic with what all its publishers offer.

        Raises:
            ConfigError: If it has several types, or one that is not installed.
        """
        if len(kinds) != 1:
            raise ConfigError(f"it has several types: {', '.join(kinds)}")
        message_class(kinds[0])
        schema_text(kinds[0])
        offers = [info.qos_profile for info in self._node.get_publishers_info_by_topic(name)]
        kept = [offer.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers]
        topic = Topic(
            name,
            kinds[0],
            all(offer.reliability == ReliabilityPolicy.RELIABLE for offer in offers),
            bool(kept) and all(kept),
            stamp_at=None,
            many=len(offers) > 1,
            depth=min(MOST, max(1, sum(offer.depth for offer in offers))),
        )
        if listed is None or listed.type != kinds[0]:
            return topic
        return replace(listed, is_reliable=topic.is_reliable, is_latched=topic.is_latched)

    def has_clock(self) -> bool:
        """Whether somebody publishes simulated time."""
        return bool(self._node.count_publishers(CLOCK))


def _matches(name: str, word: str, robots: Collection[str]) -> bool:
    if word == "*" or fnmatch.fnmatchcase(name, word if word.startswith("/") else f"/{word}"):
        return True
    _, first, *rest = name.split("/")
    return first in robots and fnmatch.fnmatchcase("/".join(rest), word)


def message_class(name: str) -> Any:
    """Return the class of a message type like ``nav_msgs/msg/Path``.

    Raises:
        ConfigError: If it is not installed.
    """
    try:
        package, kind, short = name.split("/")
        return getattr(importlib.import_module(f"{package}.{kind}"), short)
    except (ImportError, AttributeError, ValueError):
        raise ConfigError(f"the type {name or 'without a name'} is not installed") from None


def quality(topic: Topic, depth: int) -> QoSProfile:
    """Return the quality of a topic of the table or of a bag."""
    reliable, effort = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
    latched, volatile = DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE
    return QoSProfile(
        depth=depth,
        reliability=reliable if topic.is_reliable else effort,
        durability=latched if topic.is_latched else volatile,
    )
