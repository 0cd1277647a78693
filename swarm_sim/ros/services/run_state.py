"""Whether the world runs: playing, paused, or paused with steps to do."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

MOST_STEPS = 1_000_000  # ticks that are asked for at a time, 28 h
MOST_WAITING = 100  # clients that wait for their steps at a time


class Answer(Enum):
    """Outcome of a request."""

    DONE = "done"
    ALREADY = "already"
    REFUSED = "refused"


class RunState:
    """Playing or paused; while paused, single ticks can be asked for.

    Attributes:
        is_paused: Whether time stands still unless steps are asked for.
    """

    def __init__(self, *, is_paused: bool = False) -> None:
        self.is_paused = is_paused
        self._steps = 0
        self._waiting: list[tuple[Callable[[bool], None], Callable[[], None]]] = []

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
        self._finish(are_done=True)
        return Answer.DONE

    def step(
        self,
        count: int,
        on_done: Callable[[bool], None],
        on_tick: Callable[[], None] = lambda: None,
    ) -> Answer:
        """Ask for `count` ticks.

        Args:
            on_done: Receives at the end whether the steps are done.

        Returns:
            REFUSED unless the world is paused, and for more steps than anybody waits for.
        """
        is_possible = 1 <= count <= MOST_STEPS - self._steps and len(self._waiting) < MOST_WAITING
        if not self.is_paused or not is_possible:
            return Answer.REFUSED
        self._steps += count
        self._waiting.append((on_done, on_tick))
        return Answer.DONE

    def cancel_steps(self) -> None:
        """Cancel all steps that are under way, of all clients."""
        self._finish(are_done=False)

    def record_tick(self) -> None:
        """Count a tick that was done."""
        if self._steps > 0:
            self._steps -= 1
            for _, on_tick in self._waiting:
                on_tick()
            if self._steps == 0:
                self._finish(are_done=True)

    def _finish(self, *, are_done: bool) -> None:
        waiting, self._waiting = self._waiting, []
        self._steps = 0
        for on_done, _ in waiting:
            on_done(are_done)
