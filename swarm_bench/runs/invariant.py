"""The safety invariant: no two robots, nor what they hold, are nearer than their radii allow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_bench.runs.invariant_kernels import smallest_gap
from swarm_common.model.beacon import BeaconArray
from swarm_nav.core.plugins import corrects_pose
from swarm_nav.interfaces import Reserving
from swarm_nav.reservation.tube import TOLERANCE as BESIDE

DEVIATION = BESIDE + 0.001  # [m] of a robot from what it holds: Margin in safety.md
FAR = 1.2  # [m] gaps from here on are not looked at
TOLERANCE = 1e-3  # [m] of the single-precision points in beacons


@dataclass(frozen=True, slots=True)
class Breach:
    """Two robots that came nearer than ever before in this run, and nearer than both radii."""

    tick: int  # when
    robots: tuple[int, int]  # ids
    slack: float  # [m] gap less the sum of the radii, negative


def least_slack(drivers: Sequence[object]) -> float | None:
    """Return the least slack [m] that is proved for some robots; None where nothing is.

    It is proved for navigators that know where they are: docs/architecture/safety.md.

    Args:
        drivers: What decides for each robot.
    """
    configs = [each.reservation_config for each in drivers if isinstance(each, Reserving)]
    if not configs or len(configs) < len(drivers) or any(map(corrects_pose, configs)):
        return None
    return -(max(config.traffic.yield_slack for config in configs) + 2.0 * DEVIATION)


class Invariant:
    """Watches the beacons of a run.

    Attributes:
        gap: [m] smallest distance so far between two robots with the space that they hold.
        slack: [m] the same less the sum of the two radii; at least `least_slack`.
        breach: The worst so far.
    """

    def __init__(self) -> None:
        self.gap = math.inf
        self.slack = math.inf
        self.breach: Breach | None = None
        self._best = np.empty(4)
        self._bounds = np.zeros((0, 4))

    def check(self, tick: int, beacons: BeaconArray) -> None:
        """Check the beacons that were sent at a tick.

        Args:
            beacons: (n,) of all robots; n may change from tick to tick.
        """
        if len(self._bounds) != len(beacons):
            self._bounds = np.zeros((len(beacons), 4))
        best = self._best
        best[:] = FAR, math.inf, -1.0, -1.0
        places = np.ascontiguousarray(beacons["pose"][:, :2])
        smallest_gap(
            places, beacons["held"], beacons["held_size"], beacons["radius"], self._bounds, FAR,
            best,
        )  # fmt: skip
        if best[0] < min(self.gap, FAR):
            self.gap = float(best[0])
        if best[1] < self.slack:
            self.slack = float(best[1])
            if self.slack < -TOLERANCE:
                pair = beacons["id"][best[2:].astype(np.int64)]
                self.breach = Breach(tick, (int(pair[0]), int(pair[1])), self.slack)
