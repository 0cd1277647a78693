"""When a navigator withholds the answer to a tick, so that a mission's outcome is repeatable.

The next goal of a mission comes from another process. Between the end of a goal and the next one
no simulated time may pass, however slow the machine is: in lockstep, the world stands still while
one robot does not answer.
"""

from __future__ import annotations

LIMIT = 10.0  # [s] of wall time, then the operator counts as gone


class Withholding:
    """Follows the operator's Mission messages and the goals."""

    def __init__(self, waits_for_mission: bool) -> None:
        """Begin; with `waits_for_mission` a mission counts as active from the start."""
        self._is_active = waits_for_mission
        self._since: float | None = None

    @property
    def is_holding(self) -> bool:
        """Whether an answer is being withheld."""
        return self._since is not None

    def should_hold(self, has_goal: bool, is_first: bool, has_ended: bool) -> bool:
        """Whether the answer of this tick must wait.

        Args:
            has_goal: Whether a goal is in hand or pending.
            is_first: Whether this is the navigator's first answer.
            has_ended: Whether a goal ended in this tick.
        """
        return self._is_active and not has_goal and (is_first or has_ended)

    def hold(self, now: float) -> None:
        """Begin to withhold at wall time `now`."""
        self._since = now

    def release(self) -> None:
        """The answer has been sent."""
        self._since = None

    def on_mission(self, is_active: bool) -> bool:
        """Take a Mission message; return whether a withheld answer must be sent now."""
        self._is_active = is_active
        return self.is_holding and not is_active

    def has_expired(self, now: float) -> bool:
        """Whether the operator has been silent for too long; then it counts as gone."""
        if self._since is None or now - self._since < LIMIT:
            return False
        self._is_active = False
        return True
