"""Whether the world runs: playing, paused, or paused with steps to do."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

MOST_STEPS = 1_000_000  # ticks that are asked for at a time, 28 h
MOST_WAITING = 100  # who wait for their steps at a time


class Answer(Enum):
    """What became of a request."""

    DONE = "done"
    ALREADY = "already"
    REFUSED = "refused"


class RunState:
    """Playing or paused; while paused, single ticks can be asked for.

    Attributes:
        is_paused: Whether time stands still unless steps are asked for.
    """

    def __init__(self) -> None:
        """Begin by playing."""
        self.is_paused = False
        self._steps = 0
        self._on_done: list[Callable[[], None]] = []

    @property
    def is_held(self) -> bool:
        """Whether the next tick has to wait."""
        return self.is_paused and self._steps == 0

    def pause(self) -> Answer:
        """Stop before the next tick."""
        if self.is_paused:
            return Answer.ALREADY
        self.is_paused = True
        return Answer.DONE

    def play(self) -> Answer:
        """Go on; steps that are not done yet are done as part of it."""
        if not self.is_paused:
            return Answer.ALREADY
        self.is_paused = False
        self._steps = 0
        self._finish()
        return Answer.DONE

    def step(self, count: int, on_done: Callable[[], None]) -> Answer:
        """Ask for `count` ticks; `on_done` is told when they are done.

        Returns:
            REFUSED unless the world is paused, and for more steps than anybody waits for.
        """
        is_possible = 1 <= count <= MOST_STEPS - self._steps and len(self._on_done) < MOST_WAITING
        if not self.is_paused or not is_possible:
            return Answer.REFUSED
        self._steps += count
        self._on_done.append(on_done)
        return Answer.DONE

    def note_tick(self) -> None:
        """Count a tick that was done."""
        if self._steps > 0:
            self._steps -= 1
            if self._steps == 0:
                self._finish()

    def _finish(self) -> None:
        waiting, self._on_done = self._on_done, []
        for on_done in waiting:
            on_done()
