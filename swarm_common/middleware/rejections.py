"""Inputs that the doors of a process reject: counted by kind, reported once per kind and source.

A door is the one place where bytes from another process become checked values. It either returns a
value or raises `RejectedError`; the caller drops the input, tells `Rejections`, and continues. The
counts reach report.json as `rejected`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from swarm_common.model.errors import SwarmError
from swarm_common.process.messages import InputsRejected
from swarm_common.process.pipes import EventWriter

TELL_PERIOD = 0.5  # [s] of wall time between two events
SOURCES_PER_KIND = 20  # that are told apart; a forger has as many names as he likes
REASON_LENGTH = 300  # characters of a reason, which may quote the input


class RejectedError(SwarmError, ValueError):
    """An input is not what its door lets in; the message says why."""


class Rejections:
    """The inputs that the doors of one process turned away."""

    def __init__(self, events: EventWriter, say: Callable[[str], object]) -> None:
        """Begin with none.

        Args:
            say: Receives a line for the log, once per kind and source.
        """
        self.counts: Counter[str] = Counter()
        self._events = events
        self._say = say
        self._told: Counter[str] = Counter()
        self._sources: dict[str, set[str]] = {}
        self._notices: dict[str, str] = {}  # the first reason of each kind, not told yet
        self._due = 0.0

    def reject(self, kind: str, source: str, reason: object) -> None:
        """Count an input that was turned away.

        Args:
            kind: The input, like `odom`, `goal` or `/sim/spawn_entity`. As few as there are doors:
                never a part of the input itself.
            source: Sender as far as it is known: a robot, a node, a client.
        """
        self.counts[kind] += 1
        sources = self._sources.setdefault(kind, set())
        if source in sources or len(sources) >= SOURCES_PER_KIND:
            return
        if not sources:
            self._notices[kind] = _line(kind, source, reason)
        sources.add(source)
        self._say(_line(kind, source, reason))

    def tell(self, now: float) -> None:
        """Send new rejections to swarm-up, no more often than it reads them."""
        if now >= self._due and self.counts != self._told:
            self._due = now + TELL_PERIOD
            self.flush()

    def flush(self) -> None:
        """Send the remaining rejections, at the end of the process."""
        new = self.counts - self._told
        if new:
            notices, self._notices = self._notices, {}
            self._events.write(InputsRejected(dict(new), notices))
            self._told = self.counts.copy()


def _line(kind: str, source: str, reason: object) -> str:
    return f"rejected: {kind} from {source}: {reason}"[:REASON_LENGTH]
