"""Intervals, tests and curves for paired, censored and rare results."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

from swarm_common.model.records import FloatArray

RESAMPLES = 4000
DRAWS = 1000  # likewise, of sizes and levels
CONFIDENCE = 0.95
TAILS = (2.5, 97.5)  # [%]
RISE = 0.02  # of throughput that counts as more
LEAST_SUCCESS = 0.9  # share of the runs of a size that does not fail


class Interval(NamedTuple):
    """An estimate and where the true value lies with the confidence."""

    estimate: float
    low: float
    high: float


class SurvivalCurve(NamedTuple):
    """A Kaplan-Meier estimate: a step function."""

    times: FloatArray  # (k,) ascending, of events
    survival: FloatArray  # (k,) share that takes longer

    @property
    def median(self) -> float:
        """Time by which half have ended, the middle where it is not unique; inf if fewer did."""
        times = np.append(self.times, math.inf)
        first = np.flatnonzero(np.append(self.survival, 0.0) <= 0.5 + 1e-12)[0]
        if first < len(self.times) and abs(self.survival[first] - 0.5) < 1e-12:
            events = np.flatnonzero(np.append(self.survival, 0.0) < 0.5 - 1e-12)
            return float((times[first] + times[events[0]]) / 2.0)
        return float(times[first])


class Paired(NamedTuple):
    """A difference between two methods on the same seeds."""

    mean: Interval
    p: float  # of no difference: Wilcoxon's signed-rank test, two-sided; 1 without any difference
    pairs: int


def wilson(successes: int, trials: int, confidence: float = CONFIDENCE) -> Interval:
    """Return a proportion with its score interval (Wilson 1927).

    Args:
        successes: 0 to `trials`.
        trials: 1 or more.
    """
    found = stats.binomtest(successes, trials).proportion_ci(confidence, "wilson")
    return Interval(successes / trials, float(found.low), float(found.high))


def bound_of_zero(trials: int, confidence: float = CONFIDENCE) -> float:
    """Return the largest probability of an event that did not occur ("rule of three").

    Args:
        trials: In which it did not occur, 1 or more.
    """
    return float(1.0 - (1.0 - confidence) ** (1.0 / trials))


def interquartile_mean(values: Sequence[float]) -> float:
    """Return the mean of the middle half (Agarwal et al. 2021)."""
    return float(stats.trim_mean(np.asarray(values, np.float64), 0.25))


def bootstrap_mean(
    values: Sequence[float], confidence: float = CONFIDENCE, seed: int = 0
) -> Interval:
    """Return a mean with its percentile interval by resampling.

    Args:
        values: At least one; with one there is no interval (NaN).
    """
    data = np.asarray(values, np.float64)
    mean = float(data.mean())
    if len(data) < 2:
        return Interval(mean, math.nan, math.nan)
    random = np.random.default_rng(seed)
    means = data[random.integers(0, len(data), (RESAMPLES, len(data)))].mean(axis=1)
    tail = 50.0 * (1.0 - confidence)
    low, high = np.percentile(means, (tail, 100.0 - tail))
    return Interval(mean, float(low), float(high))


def paired(first: Sequence[float], second: Sequence[float]) -> Paired:
    """Compare two methods on the same seeds.

    Args:
        second: Values of the same seeds, in the same order.
    """
    differences = np.subtract(first, second)
    p = float(stats.wilcoxon(differences).pvalue) if np.any(differences) else 1.0
    return Paired(bootstrap_mean(differences.tolist()), p, len(differences))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p values adjusted for all tests of a table (Holm 1979).

    Args:
        p_values: In any order, which the result keeps.
    """
    count = len(p_values)
    adjusted = [0.0] * count
    largest = 0.0
    for rank, index in enumerate(np.argsort(p_values, kind="stable").tolist()):
        largest = max(largest, min(1.0, (count - rank) * p_values[index]))
        adjusted[index] = largest
    return adjusted


def kaplan_meier(times: Sequence[float], has_ended: Sequence[bool]) -> SurvivalCurve:
    """Return the share of runs that take longer, where some were stopped before their end.

    Args:
        times: (n,) of the end, or of the stop.
        has_ended: (n,) whether the run ended by itself.
    """
    data = stats.CensoredData.right_censored(times, ~np.asarray(has_ended, np.bool_))
    found = stats.ecdf(data).sf
    return SurvivalCurve(np.asarray(found.quantiles), np.asarray(found.probabilities))


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


def profile(ratios: Sequence[float], factors: Sequence[float]) -> list[float]:
    """Return a performance profile (Dolan and Moré 2002).

    Args:
        ratios: Cost of each instance by that of the best method; inf for one that failed.

    Returns:
        The share of the instances within each factor.
    """
    return [float(np.mean(np.asarray(ratios) <= factor + 1e-9)) for factor in factors]


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
    first: int,
    step: float,
) -> Dip:
    """Compare a run with its twin of the same seed.

    Args:
        disturbed: Orders that came and that were done in each step.
        step: [s] that a step lasts.
    """
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
