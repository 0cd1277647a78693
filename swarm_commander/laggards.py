"""Navigators that do not come up although others have."""

from __future__ import annotations

from collections.abc import Sequence

PATIENCE = 30.0  # [s] of wall time since the last one became active


class Laggards:
    """Says whose navigator is to be started anew.

    Of some forty starts of 100 robots, two waited for one navigator for ever. Why was not found (a
    process that is forked while another thread holds a lock waits for that lock for ever).
    """

    def __init__(self) -> None:
        """Begin with nobody active."""
        self._active = 0
        self._since = 0.0  # when the last one became active
        self._renewed: set[str] = set()

    def due(self, now: float, missing: Sequence[str], active: int) -> list[str]:
        """Return the robots to start anew, each once.

        Args:
            now: Wall time [s].
            missing: Robots that are not active.
            active: How many are.
        """
        if active != self._active:
            self._active, self._since = active, now
        if not active or now - self._since < PATIENCE:
            return []
        names = [name for name in missing if name not in self._renewed]
        self._renewed.update(names)
        return names
