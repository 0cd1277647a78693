"""Which processes are silent; when, and how often at most, one that died is restarted. No I/O."""

from __future__ import annotations

from collections.abc import Callable

STALL = 5.0  # [s] between two checks; a longer gap means that this process slept
MOST = 5  # restarts of one process within
WINDOW = 600.0  # [s] of wall time; after that it stays down
FIRST_PAUSE = 1.0  # [s] before the first restart; doubles with each further one


class Restarts:
    """Decides about each process by its name.

    Attributes:
        total: Number of restarts so far.
    """

    def __init__(self, *, is_allowed: bool = True) -> None:
        """Begin with no deaths.

        Args:
            is_allowed: Whether anything is restarted at all.
        """
        self.total = 0
        self._is_allowed = is_allowed
        self._starts: dict[str, list[float]] = {}
        self._due: dict[str, float] = {}

    @property
    def is_allowed(self) -> bool:
        """True if restarts are enabled at all."""
        return self._is_allowed

    def on_death(self, name: str, now: float) -> float | None:
        """Record a death; return the pause before the restart.

        Args:
            now: Wall time [s].

        Returns:
            Pause [s] before the restart; None if it stays down.
        """
        starts = [start for start in self._starts.get(name, []) if now - start < WINDOW]
        self._starts[name] = starts
        if not self._is_allowed or len(starts) >= MOST:
            return None
        pause = FIRST_PAUSE * 2.0 ** len(starts)
        self._due[name] = now + pause
        return pause

    def on_request(self, name: str, now: float) -> None:
        """Forget the deaths of a process, and start it as soon as it is down: the user wants it.

        Args:
            now: Wall time [s].
        """
        self._starts.pop(name, None)
        self._due[name] = now

    def pop_due(self, now: float) -> list[str]:
        """Return the processes to start now; each is returned once.

        Args:
            now: Wall time [s].
        """
        names = [name for name, due in self._due.items() if now >= due]
        for name in names:
            del self._due[name]
            self._starts.setdefault(name, []).append(now)
        self.total += len(names)
        return names

    def is_waiting(self, name: str) -> bool:
        """Whether a process will be started."""
        return name in self._due

    def forget(self, name: str) -> None:
        """Do not start a process any more: it is not needed any longer."""
        self._due.pop(name, None)


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
