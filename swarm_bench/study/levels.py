"""Sizes and levels at which something changes, and how far runs fall behind their twins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from swarm_bench.statistics import Interval
from swarm_common.model.records import FloatArray

DRAWS = 1000  # of sizes and levels
TAILS = (2.5, 97.5)  # [%]
RISE = 0.02  # of throughput that counts as more
LEAST_SUCCESS = 0.9  # share of the runs of a size that does not fail


def critical_size(
    gains: Mapping[int, Mapping[int, float]], successes: Mapping[int, Mapping[int, bool]]
) -> Interval:
    """Return the size from which more robots bring no more, with its interval.

    That is the smallest size that no larger one exceeds by `RISE`, or a smaller one, the last
    before fewer than `LEAST_SUCCESS` of the runs succeed; 0 if there is none. The interval comes
    from resampled seeds.

    Args:
        gains: Throughput by size and seed.
        successes: Likewise, whether a run succeeded.
    """
    sizes = np.array(sorted(gains))
    random = np.random.default_rng(0)
    drawn = []
    for size in sizes.tolist():
        values = np.array([(gains[size][seed], successes[size][seed]) for seed in gains[size]])
        drawn.append(_resampled_means(values, random))
    means, shares = np.stack(drawn, axis=1).transpose(2, 0, 1)  # (1 + DRAWS, sizes) each
    enough = np.argmax(means * (1.0 + RISE) >= means.max(axis=1, keepdims=True), axis=1)
    failing = np.column_stack((shares < LEAST_SUCCESS, np.ones(len(shares), np.bool_)))
    last = np.minimum(enough, np.argmax(failing, axis=1) - 1)
    return _estimated(np.where(last < 0, 0, sizes[last]))


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


class Dip(NamedTuple):
    """How far a run falls behind its undisturbed twin."""

    depth: float  # share of the twin's throughput that its worst minute lacks, 0 to 1
    behind: float  # orders by which it has more open at worst
    area: float  # [order minutes] of these
    recovery: float  # [s] until at most one order more is open; to the end if that never is
    has_recovered: bool


def dip_of(
    disturbed: tuple[Sequence[int], Sequence[int]],
    twin: tuple[Sequence[int], Sequence[int]],
    since: float,
    step: float,
) -> Dip:
    """Compare a run with its twin of the same seed.

    Args:
        disturbed: Orders that came and that were done in each step.
        since: [s] when the disturbance begins.
        step: [s] that a step lasts.
    """
    first = int(since / step)
    length = min(len(disturbed[1]), len(twin[1]))
    (came, done), (came_twin, done_twin) = (
        (np.asarray(run[0][:length]), np.asarray(run[1][:length])) for run in (disturbed, twin)
    )
    excess = np.maximum(np.cumsum(came - done) - np.cumsum(came_twin - done_twin), 0)[first:]
    width = min(round(60.0 / step), length - first)
    rates = np.convolve(done[first:], np.ones(width), "valid")
    usual = float(done_twin[first:].mean()) * width
    depth = max(0.0, 1.0 - float(rates.min()) / usual) if usual else 0.0
    late = np.flatnonzero(excess > 1)
    last = int(late[-1]) + 1 if len(late) else 0
    area = float(excess.sum()) * step / 60.0
    return Dip(depth, float(excess.max()), area, last * step, last < len(excess))
