"""Robot poses between two messages: they glide from the shown pose to the true one."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from swarm_common.model.records import FloatArray

JUMP = 1.0  # [m] from which a robot was moved, not driven
LONGEST = 0.5  # [s] of wall time over which a step is spread
SMOOTHING = 0.3  # of the newest interval in the estimate


class Track:
    """Poses (n, 3) of all robots as they are to be drawn at a wall time.

    Messages come at the world's pace, frames at ours. Each message's poses are reached when the
    next one is expected, so that robots move evenly, one message late.
    """

    def __init__(self) -> None:
        self._from = self._to = np.zeros((0, 3))
        self._since = 0.0
        self._interval = 0.1

    @property
    def latest(self) -> FloatArray:
        """The newest poses."""
        return self._to

    def add(self, poses: FloatArray, now: float) -> None:
        """Add new poses (n, 3): x, y, yaw in map, that came at wall time `now` [s]."""
        if len(poses) != len(self._to):
            self._from = self._to = poses
            self._since = now
            return
        shown = self.at(now)
        newest = min(LONGEST, max(1e-3, now - self._since))
        self._interval += SMOOTHING * (newest - self._interval)
        moved = np.hypot(*(poses[:, :2] - shown[:, :2]).T)
        shown[moved > JUMP] = poses[moved > JUMP]
        self._from, self._to, self._since = shown, poses, now

    def put(self, poses: FloatArray) -> None:
        """Stand at poses (n, 3) at once."""
        self._from = self._to = poses

    def at(self, now: float) -> FloatArray:
        """Return the poses (n, 3) to be drawn at a wall time; a copy."""
        share = min(1.0, max(0.0, (now - self._since) / self._interval))
        step = self._to - self._from
        step[:, 2] = (step[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
        result: FloatArray = self._from + share * step
        return result


class Trails:
    """Where the robots have been lately."""

    def __init__(self, length: int = 60, spacing: float = 0.15) -> None:
        """Keep up to `length` points of each robot that are `spacing` [m] apart."""
        self._points: deque[FloatArray] = deque(maxlen=length)
        self._spacing = spacing

    def add(self, poses: FloatArray) -> None:
        """Add poses (n, 3); keep them when a robot has moved far enough."""
        places = poses[:, :2].copy()
        if self._points and len(self._points[-1]) != len(places):
            self._points.clear()
        if self._points:
            moved = np.hypot(*(places - self._points[-1]).T)
            if (moved < self._spacing).all():  # a new robot has no past poses: NaN
                return
        self._points.append(places)

    def clear(self) -> None:
        """Forget all."""
        self._points.clear()

    def rearrange(self, rows: Sequence[int]) -> None:
        """Continue with another list of robots: the old row of each, -1 for a new one."""
        old = list(self._points)
        self._points.clear()
        for places in old:
            padded = np.vstack([places, np.full((1, 2), np.nan)])  # the row that -1 means
            self._points.append(padded[list(rows)])

    def segments(self) -> FloatArray:
        """Return line segments (m, 2, 2) in map; jumps are left out."""
        if len(self._points) < 2:
            return np.zeros((0, 2, 2))
        points = np.array(self._points)  # (time, robot, 2)
        segments = np.stack([points[:-1], points[1:]], axis=2).reshape(-1, 2, 2)
        length = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
        kept: FloatArray = segments[(length > 0.01) & (length < JUMP)]
        return kept
