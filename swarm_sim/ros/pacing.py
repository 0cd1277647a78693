"""Throttle to a multiple of real time, and rates that are limited on the wall clock."""

from __future__ import annotations

from swarm_common.model.records import CONTROL_PERIOD

MAX_LAG = 1.0  # [s] of wall time that a slow machine may catch up


class Throttle:
    """When the next tick is due."""

    def __init__(self, speed: float | None) -> None:
        """Begin without a tick that is due.

        Args:
            speed: Times real time; None does not throttle.
        """
        self._due = 0.0
        self.set_speed(speed)

    def set_speed(self, speed: float | None) -> None:
        """Change the speed."""
        self._period = None if speed is None else CONTROL_PERIOD / speed

    def start(self, now: float) -> None:
        """Begin to count."""
        self._due = now

    def wait_after_tick(self, now: float) -> float:
        """Return how long [s] to wait before the next tick, at the end of one."""
        if self._period is None:
            return 0.0
        self._due = max(self._due + self._period, now - MAX_LAG)
        return max(0.0, self._due - now)


class Rate:
    """True at most once per period of wall time."""

    def __init__(self, period: float) -> None:
        """Begin; the first question is answered with True."""
        self._period = period
        self._last = float("-inf")

    def is_due(self, now: float) -> bool:
        """Whether it is time; a True starts the next period."""
        if now - self._last < self._period - 1e-6:
            return False
        self._last = now
        return True


class SpeedMeter:
    """Real-time factor over the last second or so."""

    def __init__(self) -> None:
        self._wall = self._sim = 0.0
        self.factor = 0.0

    def start(self, now: float, sim_time: float) -> None:
        """Begin to measure."""
        self._wall, self._sim = now, sim_time

    def update(self, now: float, sim_time: float) -> None:
        """Measure since the last call."""
        if now > self._wall:
            self.factor = (sim_time - self._sim) / (now - self._wall)
        self.start(now, sim_time)
