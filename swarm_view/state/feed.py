"""Where messages come from: the live graph or a recording. Both look the same to the view."""

from __future__ import annotations

from collections.abc import Collection
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
