"""Intervals, pairs and curves of results that are paired, censored or rare."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy  # its `stats`, slow to import, once they are used

from swarm_common.model.records import FloatArray

RESAMPLES = 4000
CONFIDENCE = 0.95
LEAST_SEEDS = 3  # for Student's interval over seeds


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimate, and where the true value lies with the confidence; NaN if nothing is known."""

    estimate: float
    low: float = math.nan
    high: float = math.nan
    freedom: int = 0  # degrees of Student's distribution; 0 for another

    @property
    def is_known(self) -> bool:
        """Whether there is an interval."""
        return not math.isnan(self.low)

    @property
    def half_width(self) -> float:
        """Half the width; inf if there is no interval."""
        return 0.5 * (self.high - self.low) if self.is_known else math.inf

    @property
    def relative(self) -> float:
        """Half the width as a share of the estimate; inf for an estimate of 0 that is not exact."""
        if self.half_width == 0.0:
            return 0.0
        return self.half_width / abs(self.estimate) if self.estimate else math.inf

    def draws(self, count: int, random: np.random.Generator) -> FloatArray:
        """Return (count,) values that Student's interval allows."""
        if not self.is_known:
            return np.full(count, self.estimate)
        error = self.half_width / _student(self.freedom)
        return self.estimate + error * random.standard_t(self.freedom, count)

    def text(self, form: str = "{:+.0f}") -> str:
        """Return the estimate with its interval, each in a form."""
        if not self.is_known:
            return form.format(self.estimate)
        return f"{form.format(self.estimate)} {self.ends(form)}"

    def ends(self, form: str) -> str:
        """Return the interval alone; a dash if there is none."""
        return f"[{form.format(self.low)}, {form.format(self.high)}]" if self.is_known else "–"


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
    """Differences between two methods on the same seeds."""

    differences: list[float]  # by seed
    mean: Interval

    @property
    def p(self) -> float:
        """Probability of no difference: Wilcoxon's signed-rank test, two-sided; 1 if all are 0."""
        return (
            float(scipy.stats.wilcoxon(self.differences).pvalue) if any(self.differences) else 1.0
        )


def wilson(successes: int, trials: int, confidence: float = CONFIDENCE) -> Interval:
    """Return a proportion with its score interval (Wilson 1927).

    Args:
        successes: 0 to `trials`.
        trials: 1 or more.
    """
    found = scipy.stats.binomtest(successes, trials).proportion_ci(confidence, "wilson")
    return Interval(successes / trials, float(found.low), float(found.high))


def bound_of_zero(trials: int) -> float:
    """Return the largest probability of an event that did not occur ("rule of three").

    Args:
        trials: In which it did not occur, 1 or more.
    """
    return float(1.0 - (1.0 - CONFIDENCE) ** (1.0 / trials))


def bootstrap_mean(values: Sequence[float]) -> Interval:
    """Return a mean with its percentile interval by resampling.

    Args:
        values: At least one; with one there is no interval.
    """
    data = np.asarray(values, np.float64)
    mean = float(data.mean())
    if len(data) < 2:
        return Interval(mean)
    random = np.random.default_rng(0)
    means = data[random.integers(0, len(data), (RESAMPLES, len(data)))].mean(axis=1)
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.percentile(means, (tail, 100.0 - tail))
    return Interval(mean, float(low), float(high))


def student_mean(values: Sequence[float]) -> Interval:
    """Return the mean of independent values with Student's interval.

    Args:
        values: At least one; with one there is no interval.
    """
    count, mean = len(values), float(np.mean(values))
    if count < 2:
        return Interval(mean)
    return _of_error(mean, float(np.std(values, ddof=1)) / math.sqrt(count), count - 1)


def mean_of_runs(means: Sequence[float], batches: Sequence[Sequence[float]]) -> Interval:
    """Return the mean over runs (Law, Simulation Modeling and Analysis, chapter 9).

    Runs of different seeds are independent, so `LEAST_SEEDS` give Student's interval of their means
    (replication and deletion). With fewer, batches do: each run after its warm-up is cut into parts
    of equal length, whose means are nearly independent.

    Args:
        means: (n,) of each run.
        batches: (n, b) means of each run's batches.
    """
    if len(means) >= LEAST_SEEDS or min(map(len, batches)) < 2:
        return student_mean(means)
    squares = [float(np.var(row, ddof=1)) / len(row) for row in batches]
    freedom = sum(len(row) - 1 for row in batches)
    return _of_error(float(np.mean(means)), math.sqrt(sum(squares)) / len(means), freedom)


def _of_error(mean: float, error: float, freedom: int) -> Interval:
    half = _student(freedom) * error
    return Interval(mean, mean - half, mean + half, freedom)


def _student(freedom: int) -> float:
    return float(scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom))


def paired(
    first: Mapping[int, float],
    second: Mapping[int, float],
    mean: Callable[[Sequence[float]], Interval] = bootstrap_mean,
) -> Paired:
    """Compare two methods on the seeds that both have.

    Args:
        first: Values of one method by seed.
        second: Values of the other by seed, which are subtracted.
        mean: Gives the mean of the differences with its interval.

    Raises:
        ValueError: If no seed is common.
    """
    seeds = sorted(first.keys() & second.keys())
    differences = [first[seed] - second[seed] for seed in seeds]
    return Paired(differences, mean(differences))


def paired_mean(differences: Sequence[float], confidence: float) -> tuple[Interval, float]:
    """Return the mean of paired differences with Student's interval, and the p value of none.

    Args:
        differences: (n,), at least two. If all are the same, the signed-rank test gives p.
    """
    data = np.asarray(differences, np.float64)
    if np.allclose(data, data[0], rtol=1e-9, atol=1e-12):
        mean = float(data[0])
        p = float(scipy.stats.wilcoxon(data).pvalue) if abs(mean) > 1e-12 else 1.0
        return Interval(mean, mean, mean), p
    found = scipy.stats.ttest_1samp(data, 0.0)
    ends = found.confidence_interval(confidence)
    freedom = len(data) - 1
    interval = Interval(float(data.mean()), float(ends.low), float(ends.high), freedom)
    return interval, float(found.pvalue)


def jackknifed_ratio(parts: Sequence[float], wholes: Sequence[float]) -> list[float]:
    """Return pseudo-values whose mean is the sum of parts by the sum of wholes, without its bias.

    They take the place of a sample in tests and intervals (Miller, Biometrika 61, 1974).

    Args:
        parts: (n,).
        wholes: (n,), whose sum is above 0; else all of it is kept by none, and the ratio is 0.
    """
    part, whole = np.asarray(parts, np.float64), np.asarray(wholes, np.float64)
    count = len(part)
    if count == 0 or whole.sum() <= 0.0:
        return [0.0] * count
    ratio = part.sum() / whole.sum()
    rest = whole.sum() - whole
    others = np.divide(part.sum() - part, rest, out=np.full(count, ratio), where=rest > 0.0)
    values: list[float] = (count * ratio - (count - 1) * others).tolist()
    return values


def paired_shares(
    first: Sequence[float], second: Sequence[float], confidence: float
) -> tuple[Interval, float]:
    """Return the difference of two shares on the same trials, and the p value of none.

    The interval is Newcombe's of two score intervals (1998, method 10), for independent trials, so
    rather too wide; the test is McNemar's, exact.

    Args:
        first: (n,) 1 where the event occurred, else 0.
        second: (n,) likewise, of the other.
    """
    count = len(first)
    one, other = (wilson(round(sum(each)), count, confidence) for each in (first, second))
    estimate = one.estimate - other.estimate
    low = math.hypot(one.estimate - one.low, other.high - other.estimate)
    high = math.hypot(one.high - one.estimate, other.estimate - other.low)
    wins = sum(a > b for a, b in zip(first, second, strict=True))
    losses = sum(a < b for a, b in zip(first, second, strict=True))
    p = float(scipy.stats.binomtest(wins, wins + losses).pvalue) if wins + losses else 1.0
    return Interval(estimate, estimate - low, estimate + high), p


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
    data = scipy.stats.CensoredData.right_censored(times, ~np.asarray(has_ended, np.bool_))
    found = scipy.stats.ecdf(data).sf
    return SurvivalCurve(np.asarray(found.quantiles), np.asarray(found.probabilities))
