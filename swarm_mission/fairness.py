"""How evenly a swarm was served."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Fairness:
    """Durations of all goals reached in a run; None where there was none.

    A goal's duration is the simulated time from the tick at which its robot was free to set off
    for it (the end of the goal before and the pause there) to the tick in which it was reached,
    with all tries, holding and waiting.

    Attributes:
        median: [s] over all goals of all robots.
        worst: [s] the longest.
        ratio: worst / median: 1 if all goals took equally long.
    """

    median: float | None
    worst: float | None
    ratio: float | None


def fairness(durations: Sequence[float]) -> Fairness:
    """Return how evenly goals with these durations [s] were served.

    Args:
        durations: [s] of the goals that were reached; may be none.
    """
    if not durations:
        return Fairness(None, None, None)
    median, worst = statistics.median(durations), max(durations)
    return Fairness(median, worst, worst / median if median > 0.0 else None)
