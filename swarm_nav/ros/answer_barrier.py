"""When a navigator withholds the answer to a tick, so that a mission's outcome is repeatable.

The next goal of a mission comes from another process. Between the end of a goal and the next one
no simulated time may pass, however slow the machine is: in lockstep, the world stands still while
one robot does not answer. At the start it does so without limit, later for `wall_limit` of the
world's settings, which must therefore be longer than `LIMIT`: then a withheld answer is never late.

A robot with a courier withholds every answer until its courier releases the tick: the courier may
say something in any of them.
"""

from __future__ import annotations

LIMIT = 10.0  # [s] of wall time, then the operator counts as gone
START_LIMIT = 600.0  # [s] of wall time for the mission's first message, as swarm-up's for its start


class AnswerBarrier:
    """Follows the operator's Mission messages and the goals."""

    def __init__(self, waits_for_mission: bool, *, has_courier: bool = False) -> None:
        """Start without an answer that is withheld.

        Args:
            waits_for_mission: Whether a mission counts as active from the start.
            has_courier: Whether a courier releases each tick, and counts as active from the start.
        """
        self._has_courier = has_courier
        self._is_active = waits_for_mission or has_courier
        self._since: float | None = None
        self._limit = LIMIT
        self._is_announced = False  # a Mission message has come

    @property
    def is_holding(self) -> bool:
        """Whether an answer is being withheld."""
        return self._since is not None

    def should_hold(self, has_goal: bool, is_first: bool, has_ended: bool) -> bool:
        """Whether the answer of this tick must wait.

        Args:
            has_goal: Whether there is a current or pending goal.
            is_first: Whether this is the navigator's first answer.
            has_ended: Whether a goal ended in this tick.
        """
        if self._has_courier:
            return self._is_active
        return self._is_active and not has_goal and (is_first or has_ended)

    def hold(self, now: float, is_first: bool) -> None:
        """Begin to withhold an answer.

        Args:
            now: [s] of wall time.
            is_first: Whether this is the navigator's first answer.
        """
        self._since = now
        self._limit = START_LIMIT if is_first and not self._is_announced else LIMIT

    def release(self) -> None:
        """The answer has been sent."""
        self._since = None

    def on_mission(self, is_active: bool, now: float) -> bool:
        """Receive a Mission message.

        Args:
            is_active: Whether the operator has more goals to come.
            now: [s] of wall time.

        Returns:
            Whether a withheld answer must be sent now.
        """
        if self.is_holding and not self._is_announced:  # its first goal is about to come
            self._since, self._limit = now, LIMIT
        self._is_announced = True
        self._is_active = is_active
        return self.is_holding and not is_active

    def on_release(self) -> None:
        """The courier is there: it is waited for, also if it was silent for too long."""
        self._is_announced = self._is_active = True

    def has_expired(self, now: float) -> bool:
        """Whether the operator has been silent for too long; then it counts as gone.

        Args:
            now: [s] of wall time.
        """
        if self._since is None or now - self._since < self._limit:
            return False
        self._is_active = False
        return True
