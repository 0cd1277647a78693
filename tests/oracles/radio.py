"""Slow twin of the radio: one message at a time, in plain Python."""

import math
from collections.abc import Sequence

MASK = (1 << 64) - 1


def is_lost(seed: int, tick: int, sender: int, receiver: int, loss: float) -> bool:
    """Return whether a message is lost; SplitMix64 chained over the four numbers."""
    word = 0
    for part in (seed, tick, sender, receiver):
        word = (word + 0x9E3779B97F4A7C15 + part) & MASK
        word = ((word ^ (word >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        word = ((word ^ (word >> 27)) * 0x94D049BB133111EB) & MASK
        word ^= word >> 31
    return (word >> 11) * 2.0**-53 < loss


def heard(
    positions: Sequence[tuple[float, float]],
    senders: Sequence[int],
    receiver: int,
    tick: int,
    seed: int,
    reach: float,
    loss: float,
) -> list[int]:
    """Return which senders a receiver hears, in order."""
    return [
        sender
        for sender in sorted(senders)
        if sender != receiver
        and math.dist(positions[sender], positions[receiver]) <= reach
        and not is_lost(seed, tick, sender, receiver, loss)
    ]
