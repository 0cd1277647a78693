"""Means with intervals: over seeds, by batch means, of pairs.

Runs of different seeds are independent, so three or more give Student's interval of their means
(replication and deletion). With fewer, the batches of all runs do: each run after its warm-up is
cut into batches of equal length, whose means are nearly independent. Source of both: Law,
Simulation Modeling and Analysis, chapter 9.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

LEVEL = 0.95  # of all intervals
LEAST_SEEDS = 3  # for an interval over seeds


@dataclass(frozen=True, slots=True)
class SizeEstimate:
    """A mean and how well it is known."""

    mean: float
    error: float  # standard error of the mean; inf if nothing is known of it
    freedom: int  # degrees of freedom of the error

    @property
    def half_width(self) -> float:
        """Half the width of the interval."""
        if not math.isfinite(self.error) or self.freedom < 1:
            return math.inf
        return float(stats.t.ppf(0.5 + 0.5 * LEVEL, self.freedom)) * self.error

    @property
    def low(self) -> float:
        """Lower end of the interval."""
        return self.mean - self.half_width

    @property
    def high(self) -> float:
        """Upper end of the interval."""
        return self.mean + self.half_width

    @property
    def relative(self) -> float:
        """Half the width as a share of the mean; inf for a mean of 0 that is not exact."""
        if self.half_width == 0.0:
            return 0.0
        return self.half_width / abs(self.mean) if self.mean else math.inf

    def draws(self, count: int, random: np.random.Generator) -> np.ndarray:
        """Return (count,) values of the mean that the data allow."""
        if not math.isfinite(self.error) or self.freedom < 1:
            return np.full(count, self.mean)
        return self.mean + self.error * random.standard_t(self.freedom, count)


def estimate(values: Sequence[float]) -> SizeEstimate:
    """Return the mean of independent values, with Student's error.

    Args:
        values: (n,) with n of 1 or more.
    """
    count = len(values)
    if count < 2:
        return SizeEstimate(float(values[0]), math.inf, 0)
    error = float(np.std(values, ddof=1)) / math.sqrt(count)
    return SizeEstimate(float(np.mean(values)), error, count - 1)


def estimate_of_runs(means: Sequence[float], batches: Sequence[Sequence[float]]) -> SizeEstimate:
    """Return the mean over runs.

    Args:
        means: (n,) of each run.
        batches: (n, b) means of each run's batches, for fewer than `LEAST_SEEDS` runs.
    """
    if len(means) >= LEAST_SEEDS or min(map(len, batches)) < 2:
        return estimate(means)
    squares = [float(np.var(row, ddof=1)) / len(row) for row in batches]
    error = math.sqrt(sum(squares)) / len(means)
    return SizeEstimate(float(np.mean(means)), error, sum(len(row) - 1 for row in batches))


def paired(first: Sequence[float], second: Sequence[float]) -> SizeEstimate:
    """Return the mean of `second - first` of pairs.

    Args:
        first: (n,) with the same seeds as the others, in their order.
        second: (n,)
    """
    return estimate([b - a for a, b in zip(first, second, strict=True)])
