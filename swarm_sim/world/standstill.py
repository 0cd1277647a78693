"""Robots that are told to drive, and never do."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from swarm_common.model.records import CONTROL_PERIOD, FloatArray

ENOUGH = 2.0  # [m] that a robot has to be told to drive, before it is looked at
SHARE = 0.05  # of that, up to which it counts as not moving


class Standstill:
    """Adds up how far robots are told to drive, and finds those that have not moved for it."""

    def __init__(self, count: int) -> None:
        self._told = np.zeros(count)
        self._is_known = np.zeros(count, np.bool_)

    def add(self) -> None:
        """Add a robot."""
        self._told = np.append(self._told, 0.0)
        self._is_known = np.append(self._is_known, False)

    def observe(self, speeds: FloatArray) -> None:
        """Record one control period."""
        self._told += np.hypot(speeds[:, 0], speeds[:, 2]) * CONTROL_PERIOD

    def new(self, ways: FloatArray) -> Iterator[tuple[int, float]]:
        """Yield each robot that does not move, once, and how far [m] it was told to drive.

        Args:
            ways: [m] that the robots have driven.
        """
        stands = (self._told >= ENOUGH) & (ways < SHARE * self._told)
        for robot in np.flatnonzero(stands & ~self._is_known):
            self._is_known[robot] = True
            yield int(robot), float(self._told[robot])
