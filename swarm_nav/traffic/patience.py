"""One scale for all times of the liveness layer: the measured slowness of the radio.

A robot that makes way needs a few round trips of the radio before it is granted anything: request,
acknowledgement, beacon of what is held. Over a slow radio every time for which robots wait for
each other grows by the same factor, so that none of them gives up before the other can have moved.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_nav.perception.neighbor_table_kernels import mean_trip

USUAL_TRIP = 2.5  # ticks from a beacon to its acknowledgement over a radio that is not slow
WEIGHT = 0.02  # of the newest tick in the mean
LONGEST_TRIP = 60  # ticks; an older acknowledgement means a robot that does not answer
MOST = 8.0  # times the usual


class Patience:
    """Measures the radio's round trip from the acknowledgements of neighbours.

    Attributes:
        factor: By which times grow, 1 or more.
    """

    def __init__(self) -> None:
        self.factor = 1
        self._trip = 0.0

    def note(self, acks: NDArray[np.int64], tick: int) -> None:
        """Take the ticks (n,) of own beacons that the neighbours have acknowledged by `tick`.

        Args:
            acks: (n,) ticks.
            tick: Now.
        """
        mean = float(mean_trip(acks, tick, LONGEST_TRIP))
        if mean > 0.0:
            self._trip += WEIGHT * (mean - self._trip)
            self.factor = round(min(MOST, max(1.0, self._trip / USUAL_TRIP)))
