"""Which processes have said nothing for too long. No I/O."""

from __future__ import annotations

from collections.abc import Callable

STALL = 5.0  # [s] between two checks; a longer gap means that this process slept


class Heartbeats:
    """Knows when each process was heard last; processes speak at least every few seconds."""

    def __init__(self, clock: Callable[[], float]) -> None:
        """Begin with no process heard.

        Args:
            clock: Wall time [s].
        """
        self._clock = clock
        self._heard: dict[str, float] = {}
        self._looked = clock()

    def hear(self, name: str) -> None:
        """Note that a process has said something."""
        self._heard[name] = self._clock()

    def forget(self, name: str) -> None:
        """Expect nothing of a process until it is heard again."""
        self._heard.pop(name, None)

    def silence(self, name: str) -> float:
        """Return how long [s] a process has been silent; 0 for one that was never heard."""
        return self._clock() - self._heard.get(name, self._clock())

    def look(self) -> None:
        """Begin a round of checks: messages sent while this process slept are not read yet."""
        now = self._clock()
        if now - self._looked > STALL:
            self._heard = dict.fromkeys(self._heard, now)
        self._looked = now
