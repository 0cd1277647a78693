"""The number of robots from which more of them bring little, with its interval.

Throughput over robots is fitted by two straight lines that meet at the knee (segmented regression,
least squares over every whole number as the knee). The interval comes from fits of curves that the
points' intervals allow. There is no knee where the second line rises more than half as steeply as
the first in more than one of twenty of these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_bench.statistics import CONFIDENCE, Interval

DRAWS = 2000
FLATTER = 0.5  # slope after the knee over slope before, at most
SURE = 0.95  # share of the draws that have a knee
LEAST_SIZES = 4


@dataclass(frozen=True, slots=True)
class Knee:
    """Where the curve bends."""

    robots: int
    low: int  # of its interval
    high: int
    plateau: float  # throughput there


def find_knee(sizes: Sequence[int], points: Sequence[Interval]) -> Knee | None:
    """Return the knee of a curve; None if it has none for sure, or too few sizes.

    Args:
        sizes: (n,) of swarms, ascending.
        points: (n,) throughput of each.
    """
    if len(sizes) < LEAST_SIZES:
        return None
    random = np.random.default_rng(0)
    means = np.array([point.estimate for point in points])
    drawn = np.stack([point.draws(DRAWS, random) for point in points], axis=1)
    knees, slopes, heights = _fit(np.asarray(sizes, float), np.vstack([means, drawn]))
    before, after = slopes
    bends = (before > 0.0) & (after <= FLATTER * before)
    if not bends[0] or bends[1:].mean() < SURE:
        return None
    low, high = np.quantile(
        knees[1:][bends[1:]], (0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE), method="nearest"
    )
    return Knee(int(knees[0]), int(low), int(high), float(heights[0]))


def _fit(
    sizes: np.ndarray, curves: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Return the best knee of each curve, the slopes before and after it, and the height there.

    Args:
        sizes: (n,)
        curves: (m, n) values at these.
    """
    count = len(curves)
    best = np.full(count, np.inf)
    knees, before, after, heights = (np.zeros(count) for _ in range(4))
    for knee in range(int(sizes[1]), int(sizes[-2]) + 1):
        design = np.stack([np.ones_like(sizes), sizes, np.maximum(sizes - knee, 0.0)], axis=1)
        solution = curves @ np.linalg.pinv(design).T
        errors = ((solution @ design.T - curves) ** 2).sum(axis=1)
        is_better = errors < best - 1e-9
        best[is_better], knees[is_better] = errors[is_better], knee
        base, slope, bend = solution[is_better].T
        before[is_better], after[is_better] = slope, slope + bend
        heights[is_better] = base + slope * knee
    return knees, (before, after), heights
