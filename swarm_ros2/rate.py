"""The rate at which messages arrive."""

from __future__ import annotations

import math
import statistics
from collections import deque

WINDOW = 10000  # messages


class RateMeter:
    """Arrival times of the last messages, and their statistics."""

    def __init__(self, window: int = WINDOW) -> None:
        """Start without messages.

        Args:
            window: Number of intervals to keep.
        """
        self._last: float | None = None
        self._intervals: deque[float] = deque(maxlen=window)
        self._reported = 0
        self._count = 0

    def add(self, now: float) -> None:
        """Note a message that arrived at `now` [s]."""
        if self._last is not None:
            self._intervals.append(now - self._last)
        self._last = now
        self._count += 1

    def report(self) -> str | None:
        """Return the statistics as ros2cli words them, None if nothing came since the last call."""
        if not self._intervals or self._count == self._reported:
            return None
        self._reported = self._count
        mean = statistics.fmean(self._intervals)
        rate = 1.0 / mean if mean > 0.0 else math.inf
        deviation = statistics.pstdev(self._intervals, mean)
        return (
            f"average rate: {rate:.3f}\n"
            f"\tmin: {min(self._intervals):.3f}s max: {max(self._intervals):.3f}s"
            f" std dev: {deviation:.5f}s window: {len(self._intervals) + 1}"
        )
