"""The safety invariant: no two robots hold space nearer to each other than their radii."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_bench.runs.invariant_kernels import smallest_gap
from swarm_common.model.beacon import BeaconArray

FAR = 1.2  # [m] gaps from here on are not looked at
TOLERANCE = 1e-3  # [m] of the single-precision points in beacons


@dataclass(frozen=True, slots=True)
class Breach:
    """Two tubes that came nearer than ever before in this run, and nearer than they may."""

    tick: int  # when
    robots: tuple[int, int]  # ids
    slack: float  # [m] gap less the sum of the radii, negative


class Invariant:
    """Watches the beacons of a run.

    Attributes:
        gap: [m] smallest distance between two held tubes so far.
        slack: [m] smallest distance less the sum of the two radii so far. A published tube begins
            at the true pose, so it may fall below 0 by actuation errors: the tests allow -0.06 m.
        breach: The worst so far.
    """

    def __init__(self) -> None:
        self.gap = math.inf
        self.slack = math.inf
        self.breach: Breach | None = None
        self._best = np.empty(4)
        self._bounds = np.zeros((0, 4))

    def check(self, tick: int, beacons: BeaconArray) -> None:
        """Take in the beacons that were sent at a tick.

        Args:
            beacons: (n,) of all robots; n may change from tick to tick.
        """
        if len(self._bounds) != len(beacons):
            self._bounds = np.zeros((len(beacons), 4))
        best = self._best
        best[:] = FAR, math.inf, -1.0, -1.0
        smallest_gap(
            beacons["held"], beacons["held_size"], beacons["radius"], self._bounds, FAR, best
        )
        if best[0] < min(self.gap, FAR):
            self.gap = float(best[0])
        if best[1] < self.slack:
            self.slack = float(best[1])
            if self.slack < -TOLERANCE:
                pair = beacons["id"][best[2:].astype(np.int64)]
                self.breach = Breach(tick, (int(pair[0]), int(pair[1])), self.slack)
