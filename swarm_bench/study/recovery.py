"""Times to recover."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

WINDOW = 12  # steps in which orders are counted to tell whether a swarm has recovered
RECOVERED = 0.9  # share of the twin's orders in it


def recovery_of(done: Sequence[int], twin: Sequence[int], first: int) -> tuple[int, bool]:
    """Return the steps after which a run does as many orders as its twin again.

    Args:
        done: Orders done in each step.
        twin: Likewise, by the undisturbed run of the same seed.
        first: Step at which the disturbance is over.

    Returns:
        Steps from `first` on, and whether it did before the end.
    """
    own, other = (np.convolve(each, np.ones(WINDOW), "valid")[first:] for each in (done, twin))
    length = min(len(own), len(other))
    good = np.flatnonzero(own[:length] >= RECOVERED * other[:length])
    return (int(good[0]), True) if len(good) else (length, False)
