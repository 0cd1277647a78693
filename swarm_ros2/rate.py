"""Figures of a topic's messages: rate, bandwidth, delay."""

from __future__ import annotations

import math
import statistics
from collections import deque

WINDOW = 10000  # messages
SCALES = ((1e6, 1e6, "MB", 2), (1e3, 1e3, "KB", 2), (0.0, 1.0, "B", 0))  # from, unit, name, digits


class BandwidthMeter:
    """Sizes of the last messages."""

    def __init__(self, window: int) -> None:
        self._messages: deque[tuple[float, int]] = deque(maxlen=window)

    def add(self, now: float, data: bytes) -> None:
        """Note a serialized message that arrived at `now` [s]."""
        self._messages.append((now, len(data)))

    def report(self, now: float) -> str | None:
        """Return the bandwidth as ros2cli words it, None before two messages."""
        if len(self._messages) < 2 or now <= self._messages[0][0]:
            return None
        sizes = [size for _, size in self._messages]
        rate = sum(sizes) / (now - self._messages[0][0])
        _, unit, name, digits = next(scale for scale in SCALES if rate >= scale[0])
        mean, least, most = (
            f"{value / unit:.{digits}f} {name}"
            for value in (statistics.fmean(sizes), min(sizes), max(sizes))
        )
        return (
            f"{rate / unit:.{digits}f} {name}/s from {len(sizes)} messages\n"
            f"\tMessage size mean: {mean} min: {least} max: {most}"
        )


class DelayMeter:
    """How old the last messages were by their stamps."""

    def __init__(self, window: int) -> None:
        self._delays: deque[float] = deque(maxlen=window)
        self._is_new = False

    def add(self, delay: float) -> None:
        """Note a message that is `delay` [s] old."""
        self._delays.append(delay)
        self._is_new = True

    def report(self) -> str | None:
        """Return the statistics as ros2cli words them, None before the first message."""
        if not self._delays:
            return None
        if not self._is_new:
            return "no new messages"
        self._is_new = False
        mean = statistics.fmean(self._delays)
        return (
            f"average delay: {mean:.3f}\n"
            f"\tmin: {min(self._delays):.3f}s max: {max(self._delays):.3f}s"
            f" std dev: {statistics.pstdev(self._delays, mean):.5f}s window: {len(self._delays)}"
        )


class RateMeter:
    """Arrival times of the last messages, and their statistics."""

    def __init__(self, window: int = WINDOW) -> None:
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
