"""Bare numba kernel of the radio's round trip."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit


@njit(cache=True)
def mean_trip(acks: NDArray[np.int64], tick: int, longest: int) -> float:
    """Return the mean age [ticks] of the acknowledgements; 0 if none counts.

    Args:
        acks: (n,) tick of the newest own beacon that each neighbour has acknowledged. One of now
            is none that was needed.
        tick: Now.
        longest: [ticks] age of the oldest that count.
    """
    total = 0
    count = 0
    for row in range(acks.shape[0]):
        age = tick - acks[row]
        if 0 < age <= longest:
            total += age
            count += 1
    return total / count if count else 0.0
