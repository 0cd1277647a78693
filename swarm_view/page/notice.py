"""What stands in the middle of the pages while there is nothing to see, and at the end."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from swarm_common.process.messages import KernelsCompiled
from swarm_view.state.swarm import Swarm

ENDED = "The run has ended. This page shows its last moment."
VIEWER_ENDED = "The viewer has ended. This page shows what it showed last."
Hear = Callable[[], Sequence[KernelsCompiled]]


class Notice:
    """The words for a swarm that starts."""

    def __init__(self, hear: Hear | None) -> None:
        """Begin; `hear` returns what the run has said since the last call."""
        self._hear = hear
        self._compiled: KernelsCompiled | None = None

    def text(self, swarm: Swarm, *, is_paused: bool) -> str:
        """Return what to say; empty once the swarm lives, or is paused before its first tick."""
        if self._hear is not None and (said := self._hear()):
            self._compiled = said[-1]
        if swarm.tick > 0 or (is_paused and swarm.markers is not None):
            return ""
        if self._compiled is None:
            return "The swarm is starting."
        count = f"{self._compiled.ready} of {self._compiled.known} kernels are compiled"
        return f"The swarm is starting for the first time: {count}."
