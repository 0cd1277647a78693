"""Options of playing a bag on the ROS graph; without ROS."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass

from swarm_common.model.errors import ConfigError
from swarm_recording.bag import Bag
from swarm_recording.filter import CLOCK


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
