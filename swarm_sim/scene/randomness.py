"""Random numbers that depend on what they are for and on nothing else.

A generator with a state gives different numbers as soon as one more is drawn, or in another order.
Here each number follows from its coordinates: seed, tick, sender, receiver.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.libm import log

GOLDEN = np.uint64(0x9E3779B97F4A7C15)


def hash_words(*coordinates: int | NDArray[np.int64]) -> NDArray[np.uint64]:
    """Return one word per broadcast combination of the coordinates (SplitMix64, chained).

    Args:
        *coordinates: Seed, tick, indices, ...: integers, or arrays that broadcast.

    Returns:
        uint64 of the broadcast shape; a single number for plain integers.
    """
    shape = np.broadcast_shapes(*(np.shape(part) for part in coordinates))
    words = np.zeros(shape, np.uint64)
    with np.errstate(over="ignore"):
        for part in coordinates:
            words = _mix(words + GOLDEN + np.asarray(part).astype(np.uint64))
    return words


def uniform(words: NDArray[np.uint64]) -> NDArray[np.float64]:
    """Return numbers in [0, 1) made of words.

    Args:
        words: Result of `hash_words`; 53 bits of each count.
    """
    return (words >> np.uint64(11)).astype(np.float64) * 2.0**-53


def normal(words: NDArray[np.uint64]) -> NDArray[np.float64]:
    """Return standard normal numbers made of words (Box and Muller).

    Args:
        words: Result of `hash_words`; each gives one number.
    """
    first = ((words >> np.uint64(32)).astype(np.float64) + 1.0) * 2.0**-32
    second = (words & np.uint64(0xFFFFFFFF)).astype(np.float64) * 2.0**-32
    result: NDArray[np.float64] = np.sqrt(-2.0 * log(first)) * np.cos(2.0 * np.pi * second)
    return result


def _mix(words: NDArray[np.uint64]) -> NDArray[np.uint64]:
    words = (words ^ (words >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    words = (words ^ (words >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return words ^ (words >> np.uint64(31))
