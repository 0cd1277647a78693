"""Where messages come from: the live graph or a recording. Both look the same to the view."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Protocol


class Feed(Protocol):
    """Messages by topic, only of topics that are wanted. It never waits."""

    def topics(self) -> dict[str, str]:
        """Return the type of every topic that there is, like `nav_msgs/msg/Path`."""

    def want(self, topics: Collection[str]) -> None:
        """Deliver these topics from now on, and no others.

        Of a newly wanted topic that is latched the last message comes at once.
        """

    def take(self) -> list[tuple[str, bytes]]:
        """Return (topic, CDR bytes) of the messages since the last call, oldest first."""

    def close(self) -> None:
        """Release all resources."""


class Recording(Feed, Protocol):
    """A feed that can be played."""

    @property
    def span(self) -> tuple[float, float]:
        """First and last time [s]."""

    @property
    def now(self) -> float:
        """Time [s] in the recording."""

    @property
    def is_playing(self) -> bool:
        """Whether time goes on."""

    @property
    def speed(self) -> float:
        """Times real time."""

    @speed.setter
    def speed(self, speed: float) -> None:
        """Change it."""

    def play(self) -> None:
        """Go on."""

    def pause(self) -> None:
        """Stand still."""

    def seek(self, time: float) -> None:
        """Go to a time [s]; the state at that time is delivered next."""

    def scan(self, topics: Collection[str]) -> Iterator[tuple[str, bytes]]:
        """Yield (topic, CDR bytes) of all messages of topics, oldest first, on any thread."""
