"""Sizes from which one side is ahead of the other, and times to recover."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from swarm_bench.statistics import Interval
from swarm_common.model.records import FloatArray

DRAWS = 1000  # of levels
TAILS = (2.5, 97.5)  # [%]
WINDOW = 12  # steps in which orders are counted to tell whether a swarm has recovered
RECOVERED = 0.9  # share of the twin's orders in it


def change_of_sides(differences: Mapping[float, Sequence[float]]) -> Interval | None:
    """Return the level from which on the side stays ahead that is ahead at the last one.

    Args:
        differences: Differences of paired runs, by level; positive where the first side is ahead.

    Returns:
        The level with its interval from resampled pairs; None if one side is ahead at all levels.
    """
    levels = np.array(sorted(differences))
    if len(levels) < 2:
        return None
    random = np.random.default_rng(0)
    drawn = [
        _resampled_means(np.asarray(differences[level], np.float64)[:, None], random)
        for level in levels.tolist()
    ]
    signs = np.concatenate(drawn, axis=1) > 0.0  # (1 + DRAWS, levels)
    differs = (signs != signs[:, -1:])[:, ::-1]
    is_same = ~differs.any(axis=1)
    first = np.where(is_same, 0, len(levels) - np.argmax(differs, axis=1))
    return None if is_same[0] else _estimated(levels[first])


def _resampled_means(values: FloatArray, random: np.random.Generator) -> FloatArray:
    """Return means (1 + DRAWS, k): of the values (n, k), and of as many drawn from them."""
    chosen = random.integers(0, len(values), (DRAWS, len(values)))
    return np.vstack([values.mean(axis=0), values[chosen].mean(axis=1)])


def _estimated(values: FloatArray) -> Interval:
    """Return the interval of an estimate (the first value) from resampled ones (the others)."""
    low, high = np.percentile(values[1:], TAILS, method="nearest")
    return Interval(float(values[0]), float(low), float(high))


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
