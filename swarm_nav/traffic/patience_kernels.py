"""Bare numba kernel of the radio's round trip."""

from __future__ import annotations

from numba import njit


@njit(cache=True)
def mean_trip(acks, tick, longest):
    """Mean age of the acknowledgements, without those that are not needed or too old; 0 if none."""
    total = 0
    count = 0
    for row in range(acks.shape[0]):
        age = tick - acks[row]
        if 0 < age <= longest:
            total += age
            count += 1
    return total / count if count else 0.0
