"""A bag as a feed of messages at any speed, for the viewer and for playing it on the ROS graph."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator
from pathlib import Path

from swarm_common.model.errors import ConfigError
from swarm_recording.bag import NANOSECONDS, Bag, Item
from swarm_recording.filter import FRAME_AT
from swarm_recording.mcap_file import CDR

TRANSFORMS = "tf2_msgs/msg/TFMessage"


class BagFeed:
    """Plays a bag: each wanted message is returned once its time has come.

    A late call gets only the newest message of each topic (of each sender, for transforms), so
    that any speed can be watched.

    Attributes:
        bag: The recording.
        span: Its first and last time [s].
        is_playing: Whether time goes on.
    """

    def __init__(
        self,
        path: Path,
        clock: Callable[[], float] = time.monotonic,
        tell: Callable[[str], None] = lambda words: None,
    ) -> None:
        """Open a bag at its start, paused.

        Args:
            path: Path of the bag, as for `Bag`.
            clock: [s] that the speed refers to.
            tell: Receives remarks on the bag, as for `Bag`.

        Raises:
            ConfigError: If it cannot be read.
        """
        self._path = path
        self.bag = Bag(path, tell)
        self.span = (self.bag.start, self.bag.end)
        self.is_playing = False
        self._clock = clock
        self._read_at = clock()
        self._now = self.bag.start
        self._speed = 1.0
        self._wanted: frozenset[str] = frozenset()
        self._due: list[Item] = []  # outside the order of the stream: last words before now
        self._stream: Iterator[Item] = iter(())
        self._next: Item | None = None

    def topics(self) -> dict[str, str]:
        """Return topic → type."""
        return {
            name: topic.type
            for name, topic in self.bag.topics.items()
            if self.bag.encodings[name] == CDR
        }

    @property
    def now(self) -> float:
        """Time in the bag [s]."""
        self._go_on()
        return self._now

    @property
    def speed(self) -> float:
        """Times real time."""
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        if not value > 0.0:
            raise ConfigError(f"the speed is {value}; it must be positive")
        self._go_on()
        self._speed = value

    def play(self) -> None:
        """Continue playing; from the end, start again at the beginning."""
        self._go_on()
        if self._now >= self.span[1]:
            self.seek(self.span[0])
        self.is_playing = True

    def pause(self) -> None:
        """Stop time."""
        self._go_on()
        self.is_playing = False

    def seek(self, t: float) -> None:
        """Jump to a time [s]: the state at that time comes with the next `take`."""
        self._go_on()
        self._now = min(max(t, self.span[0]), self.span[1])
        self._due = self.bag.latest(self._wanted, self._now_ns)
        self._begin_stream()

    def want(self, topics: Collection[str]) -> None:
        """Deliver only these topics from now on; the last message of a new one comes at once."""
        wanted = frozenset(topics) & self.topics().keys()
        if wanted == self._wanted:
            return
        self._go_on()
        fresh = wanted - self._wanted
        self._wanted = wanted
        self._due = [item for item in self._due if item[0] in wanted]
        self._due += self.bag.latest(fresh, self._now_ns)
        self._begin_stream()

    def take(self) -> list[tuple[str, bytes]]:
        """Return (topic, serialized message) of each message since the last call."""
        return [(topic, data) for topic, _, data in self.receive_stamped()]

    def receive_stamped(self) -> list[Item]:
        """Return the messages due as `take` does, each with its time [ns]."""
        self._go_on()
        newest: dict[tuple[str, bytes], Item] = {}
        for item in self._due:
            newest[self._key(item)] = item
        self._due = []
        while self._next is not None and self._next[1] <= self._now_ns:
            newest.pop(self._key(self._next), None)  # to the end of the order
            newest[self._key(self._next)] = self._next
            self._next = next(self._stream, None)
        return list(newest.values())

    def scan(self, topics: Collection[str]) -> Iterator[tuple[str, bytes]]:
        """Yield (topic, serialized message) of all messages of topics; on any thread."""
        bag = Bag(self._path)
        try:
            for topic, _, data in bag.messages(topics):
                yield topic, data
        finally:
            bag.close()

    def close(self) -> None:
        """Close the bag."""
        self.bag.close()

    @property
    def _now_ns(self) -> int:
        return round(self._now * NANOSECONDS)

    def _go_on(self) -> None:
        now = self._clock()
        if self.is_playing:
            self._now = min(self._now + self._speed * (now - self._read_at), self.span[1])
            self.is_playing = self._now < self.span[1]
        self._read_at = now

    def _begin_stream(self) -> None:
        self._stream = self.bag.messages(self._wanted, after=self._now_ns)
        self._next = next(self._stream, None)

    def _key(self, item: Item) -> tuple[str, bytes]:
        is_tf = self.bag.topics[item[0]].type == TRANSFORMS
        return item[0], item[2][FRAME_AT] if is_tf else b""
