"""One scale for all times of the liveness layer: the measured slowness of the radio.

A robot that makes way needs a few round trips of the radio before it is granted anything: request,
acknowledgement, beacon of what is held. Every time for which robots wait for each other grows by
what these take longer over a slow radio, so that none of them gives up before the other can have
moved.
"""

from __future__ import annotations

USUAL_TRIP = 3.75  # ticks from a beacon to its acknowledgement up to which no radio is slow
TRIPS = 2  # round trips until a robot that makes way is granted anything
WEIGHT = 0.02  # of the newest tick in the mean


class Patience:
    """Measures the radio's round trip from the acknowledgements of neighbours.

    Attributes:
        extra: Ticks by which times grow.
    """

    def __init__(self) -> None:
        self.extra = 0
        self._trip = 0.0

    def note(self, mean: float) -> None:
        """Record the mean round trip of a tick.

        Args:
            mean: [ticks] from own beacons to their acknowledgements; 0 if none counts.
        """
        if mean > 0.0:
            self._trip += WEIGHT * (mean - self._trip)
            self.extra = round(TRIPS * max(0.0, self._trip - USUAL_TRIP))
