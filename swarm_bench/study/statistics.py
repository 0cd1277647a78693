"""Intervals, tests and curves for paired, censored and rare results."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

from swarm_common.model.records import FloatArray

RESAMPLES = 4000
CONFIDENCE = 0.95


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
        second: Of the same seeds, in the same order.
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
