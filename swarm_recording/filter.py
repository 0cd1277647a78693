"""Messages of a bag that are recorded (by time and rate), and those that are played."""

from __future__ import annotations

import math
import struct
from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass

from swarm_common.middleware.rcl_take import Sender
from swarm_common.middleware.topic_table import Topic
from swarm_common.model.errors import ConfigError
from swarm_recording.bag import Bag

NANOSECONDS = 1_000_000_000
TOLERANCE = 0.01  # of a period: 10 Hz of a 10 Hz topic keeps all of them
CLOCK = "/clock"
MOST_SENDERS = 100_000  # whose numbers are remembered, over all topics
FRAME_AT = slice(16, 40)  # of a tf message: its first frame, by which its senders differ

_STAMP = struct.Struct("<iI")


class RateFilter:
    """Knows the time of each message, and thins topics out.

    Attributes:
        latest: [ns] of simulated time, the largest stamp seen.
        begin: [ns] of the first `/clock`, None before it. What was sent earlier and stays for
            latecomers is of this time: a player would wait from the map's stamp, 0, on.
    """

    def __init__(self, rate: float | None) -> None:
        """Keep at most `rate` messages per simulated second of a topic; all for None."""
        self.latest = 0
        self.begin: int | None = None
        self._period = 0.0 if rate is None else (1.0 - TOLERANCE) * NANOSECONDS / rate
        self._kept: dict[tuple[str, bytes], int] = {}
        self._last: dict[str, bytes] = {}

    def stamp(self, topic: Topic, data: bytes, received: int = 0) -> int | None:
        """Return the time [ns] of a serialized message; None if it is not to be recorded.

        A message without a stamp counts as sent now. Events, and what stays for latecomers, are
        always kept. A tick that nobody answered is published again, unchanged: once is enough.
        """
        stamp = self._read(topic, data)
        if stamp is None:
            return self.latest
        self.latest = max(self.latest, stamp)
        if self.begin is None and topic.name == CLOCK:
            self.begin = stamp
        if topic.is_latched:
            return max(stamp, self.begin or 0)
        if not (topic.many or topic.is_event):
            if self._last.get(topic.name) == data:
                return None
            self._last[topic.name] = data
        if self._period <= 0.0 or topic.is_event:
            return stamp
        key = (topic.name, data[FRAME_AT] if topic.many else b"")
        if stamp - self._kept.get(key, -NANOSECONDS * 10**6) < self._period:
            return None
        self._kept[key] = stamp
        return stamp

    def is_after_begin(self, topic: Topic, data: bytes) -> bool:
        """Whether a message was sent after the recording began, by its own stamp."""
        stamp = self._read(topic, data)
        return self.begin is not None and stamp is not None and stamp > self.begin

    def _read(self, topic: Topic, data: bytes) -> int | None:
        if topic.stamp_at is None or len(data) < topic.stamp_at + _STAMP.size:
            return None
        seconds, nanoseconds = _STAMP.unpack_from(data, topic.stamp_at)
        return seconds * NANOSECONDS + nanoseconds if seconds >= 0 else None


class WallStamps:
    """Times of receipt, where nobody publishes simulated time; every message is recorded."""

    begin = 0

    def stamp(self, topic: Topic, data: bytes, received: int) -> int | None:
        """Return the wall time [ns] at which a message came."""
        return received


class Losses:
    """Counts the messages that were sent and did not arrive, by gaps in their numbers.

    Attributes:
        counts: Number of lost messages by topic, without topics that are kept for latecomers.
    """

    def __init__(self, is_late: Callable[[Topic, bytes], bool] | None = None) -> None:
        """Begin to count.

        Args:
            is_late: Whether all that the sender of a message sent before it should be there;
                None where senders may have begun before the recording.
        """
        self.counts: Counter[str] = Counter()
        self._is_late = is_late
        self._met: set[tuple[str, Sender]] = set()
        self._latest: dict[tuple[str, Sender], int] = {}

    def meet(self, topic: Topic, sender: Sender) -> None:
        """Note that nothing of a sender is lost from now on, whatever it sent before."""
        self._met.add((topic.name, sender))

    def note(self, topic: Topic, sender: Sender, sequence: int, data: bytes) -> None:
        """Note a message that has arrived.

        Args:
            sequence: Its number among those of the sender on the topic, which begin at 1.
        """
        if topic.is_latched:
            return
        key = (topic.name, sender)
        if key not in self._latest and len(self._latest) >= MOST_SENDERS:
            self._latest.clear()
            self._is_late = None
        latest = self._latest.get(key)
        if latest is None:
            is_late = None if key in self._met else self._is_late
            latest = 0 if is_late is not None and is_late(topic, data) else sequence
        self._latest[key] = max(sequence, latest)
        if sequence > latest + 1:
            self.counts[topic.name] += sequence - latest - 1


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayOptions:
    """Choice of what is played of a bag, and how."""

    topics: Collection[str] | None = None  # None for all
    # [s] in the recording where to begin; the last message of each topic before comes first
    start: float | None = None
    offset: float = 0.0  # [s] after the first message, where to begin; only what stays comes first
    speed: float | None = 1.0  # times real time; None for as fast as possible
    loops: bool = False
    clock_rate: float | None = None  # [Hz] of wall time to publish /clock; None for the recorded

    def __post_init__(self) -> None:
        if not 0.0 <= self.offset < math.inf:
            raise ConfigError(f"the offset is {self.offset} s; it must not be negative")
        if self.clock_rate is not None and not 0.0 < self.clock_rate <= 1e6:
            raise ConfigError(f"the clock's rate is {self.clock_rate} Hz; it must be positive")


def played(bag: Bag, options: PlayOptions) -> set[str]:
    """Return what is published, the clock by a rate included."""
    recorded = bag.topics.keys() & set(bag.topics if options.topics is None else options.topics)
    return recorded | ({CLOCK} if options.clock_rate is not None else set())


def topics_to_play(bag: Bag, options: PlayOptions, say: Callable[[str], None]) -> list[str]:
    """Return the topics of a bag that are asked for.

    Raises:
        ConfigError: If there are none.
    """
    wanted = bag.topics.keys() if options.topics is None else options.topics
    for name in sorted(set(wanted) - bag.topics.keys()):
        say(f"{bag.path} has no topic {name}")
    if options.clock_rate is not None and CLOCK in bag.topics and CLOCK in wanted:
        say(f"{CLOCK} is published by --clock; the recorded one is not played")
        wanted = set(wanted) - {CLOCK}
    names = [name for name in bag.topics if name in wanted]
    if not names:
        raise ConfigError(
            f"{bag.path} has none of these topics; it has {', '.join(sorted(bag.topics))}"
        )
    return names
