"""Plays a bag on the ROS graph, where RViz, Foxglove and any node see it as if the swarm ran."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import rclpy
from rclpy.duration import Duration
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from swarm_common.middleware.rclpy_compat import join_graph
from swarm_common.model.errors import ConfigError
from swarm_recording.bag import NANOSECONDS, Bag, Item
from swarm_recording.filter import CLOCK, PlayOptions, topics_to_play
from swarm_recording.mcap_file import CDR
from swarm_recording.schema import check_definition
from swarm_recording.topic_source import message_class, quality

LOOK_PERIOD = 0.005  # [s] of wall time between two looks at the clock
DEPTH = 100  # messages of a topic that a slow listener may be behind
BURST = DEPTH // 2  # messages in a row after which listeners are waited for
DISCOVERY_TIME = 1.0  # [s] for listeners to find the topics, once one has
MOST_DISCOVERY = 3.0  # [s] the same on a busy machine, or where nobody listens
# [s] for reliable listeners to have everything: DDS asks anew every 3 s what they lack
LAST_WAIT = 7.0


class Player:
    """Publishes the messages of a bag, byte by byte as they were recorded."""

    def __init__(
        self, node: Node, bag: Bag, options: PlayOptions, say: Callable[[str], None]
    ) -> None:
        """Offer the topics.

        Args:
            node: Appears as the publisher in the graph.
            say: Told of each topic that cannot be played.

        Raises:
            ConfigError: If none can.
        """
        self._node, self._bag, self._playback = node, bag, options
        self._publishers: dict[str, Publisher] = {}
        for name in topics_to_play(bag, options, say):
            try:
                self._publishers[name] = _publisher(node, bag, name)
            except ConfigError as error:
                say(f"{name}: {error}; its {bag.counts[name]} messages are not played")
        if not self._publishers:
            raise ConfigError(f"{bag.path}: none of its topics can be played")
        rate = options.clock_rate
        self._clock = None if rate is None else node.create_publisher(Clock, CLOCK, 10)
        self._clock_due = 0.0  # [s] of wall time
        self._say = say
        self._is_waiting = True  # for listeners; not for one that has stopped

    def play(self, tell: Callable[[float], None], is_stopped: Callable[[], bool]) -> int:
        """Play once to the end; return the number of messages.

        Args:
            tell: Called with the time in the bag [s] from time to time.
            is_stopped: Asked whether to stop.
        """
        speed = self._playback.speed
        count = burst = 0
        at, items = self._items()
        began = time.monotonic()
        for name, stamp, data in items:
            while speed is not None:
                now = at + speed * (time.monotonic() - began) * NANOSECONDS
                if stamp <= now or is_stopped():
                    break
                self._publish_clock(round(now))
                time.sleep(LOOK_PERIOD)
                burst = 0
            if is_stopped():
                return count
            self._publish_clock(max(at, stamp))
            self._publishers[name].publish(data)
            count += 1
            burst += 1
            if burst >= BURST and self._is_waiting:
                self.finish()
                burst = 0
            tell(stamp / NANOSECONDS)
        return count

    def _items(self) -> tuple[int, Iterator[Item]]:
        """Return the time [ns] at which playing begins, and what is published from then on."""
        bag, options, names = self._bag, self._playback, self._publishers.keys()
        if options.start is None and not options.offset:
            return bag.first, bag.messages(names)
        if options.start is not None:
            at = round(options.start * NANOSECONDS)
            first = bag.latest(names, at)
        else:
            at = bag.first + round(options.offset * NANOSECONDS) - 1
            first = bag.latest([name for name in names if bag.topics[name].is_latched], at)

        def items() -> Iterator[Item]:
            yield from first
            yield from bag.messages(names, after=at)

        return at, items()

    def _publish_clock(self, stamp: int) -> None:
        """Publish the time in the bag [ns], if it is due."""
        now = time.monotonic()
        if self._clock is None or now < self._clock_due:
            return
        assert self._playback.clock_rate is not None
        self._clock_due = now + 1.0 / self._playback.clock_rate
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(stamp, NANOSECONDS)
        self._clock.publish(message)

    def await_listeners(self, is_stopped: Callable[[], bool]) -> None:
        """Wait until those who listen to the topics have found them.

        Args:
            is_stopped: Asked whether to stop.
        """
        began = time.monotonic()
        while (waited := time.monotonic() - began) < MOST_DISCOVERY and not is_stopped():
            if waited > DISCOVERY_TIME and self._is_heard():
                return
            time.sleep(0.05)

    def _is_heard(self) -> bool:
        publishers = self._publishers.values()
        met = [publisher.get_subscription_count() for publisher in publishers]
        known = [self._node.count_subscribers(publisher.topic_name) for publisher in publishers]
        return any(met) and all(a >= b for a, b in zip(met, known, strict=True))

    def finish(self) -> None:
        """Wait until reliable listeners have everything."""
        end = time.monotonic() + LAST_WAIT
        for name, publisher in self._publishers.items():
            rest = Duration(seconds=max(0.0, end - time.monotonic()))
            if self._bag.topics[name].is_reliable and not publisher.wait_for_all_acked(rest):
                self._say(f"a listener of {name} does not keep up; it may lack messages")
                self._is_waiting = False
                return


def _publisher(node: Node, bag: Bag, name: str) -> Publisher:
    """Return what publishes a topic of a bag.

    Raises:
        ConfigError: If it cannot be published.
    """
    topic = bag.topics[name]
    if bag.encodings[name] != CDR:
        raise ConfigError(f"its messages are encoded as '{bag.encodings[name]}', not as CDR")
    kind = message_class(topic.type)
    if bag.definitions[name]:
        check_definition(bag.definitions[name], topic.type)
    depth = topic.depth if topic.is_latched else DEPTH
    try:
        return node.create_publisher(kind, name, quality(topic, depth))
    except InvalidTopicNameException:
        raise ConfigError("it is no name of a topic in ROS 2") from None


def play_on_graph(
    bag: Bag,
    options: PlayOptions,
    *,
    say: Callable[[str], None],
    tell: Callable[[float], None],
    is_stopped: Callable[[], bool],
) -> int:
    """Play a bag in this process's ROS domain; return the number of messages.

    Args:
        tell: Called with the time in the bag [s] from time to time.
        is_stopped: Asked whether to stop.

    Raises:
        ConfigError: If nothing can be played.
    """
    node = join_graph("replay")
    try:
        player = Player(node, bag, options, say)
        player.await_listeners(is_stopped)
        count = player.play(tell, is_stopped)
        while options.loops and not is_stopped():
            count += player.play(tell, is_stopped)
        if not is_stopped():
            player.finish()
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    return count
