"""The statistics reproduce published examples."""

import math

import pytest

from swarm_bench import statistics
from swarm_bench.statistics import Interval, mean_of_runs, student_mean


def test_wilson_intervals_are_the_published_ones():
    """Newcombe 1998, table I, method 3: 81 of 263."""
    found = statistics.wilson(81, 263)
    assert found.low == pytest.approx(0.2553, abs=5e-5)
    assert found.high == pytest.approx(0.3662, abs=5e-5)
    # Newcombe 1998, table I, method 3: 0 of 20.
    found = statistics.wilson(0, 20)
    assert found.low == pytest.approx(0.0, abs=1e-9)
    assert found.high == pytest.approx(0.1611, abs=5e-5)
    assert statistics.bound_of_zero(1305) == pytest.approx(0.0023, abs=5e-5)
    assert statistics.bound_of_zero(100) == pytest.approx(3.0 / 100, rel=0.02)


def test_differences_of_shares_are_the_published_ones():
    """Newcombe 1998, table II, method 10: 9 of 10 less 3 of 10, and 10 of 10 less 0 of 10."""
    found, p = statistics.paired_shares([1] * 9 + [0], [1] * 3 + [0] * 7, 0.95)
    assert (found.low, found.high) == pytest.approx((0.1705, 0.8090), abs=5e-5)
    assert p == pytest.approx(2 * 0.5**6)  # six pairs differ, all to one side
    found, p = statistics.paired_shares([1] * 10, [0] * 10, 0.95)
    assert (found.low, found.high) == pytest.approx((0.6075, 1.0), abs=5e-5)
    assert statistics.paired_shares([1, 1], [1, 1], 0.95)[1] == 1.0


def test_holm_of_four_and_batches_by_hand():
    """0.01, 0.04, 0.03, 0.005: 0.005 and 0.01 are rejected at 5 %, the others are not."""
    found = statistics.holm([0.01, 0.04, 0.03, 0.005])
    assert found == pytest.approx([0.03, 0.06, 0.06, 0.02])
    # batches 8, 12, 10, 10: variance 8/3, of the mean 2/3; two such runs: 1/3, 6 degrees
    found = mean_of_runs([10.0, 10.0], [[8.0, 12.0, 10.0, 10.0]] * 2)
    assert found.half_width == pytest.approx(2.4469 * math.sqrt(1 / 3), abs=1e-4)
    assert mean_of_runs([1.0, 2.0, 3.0], [[5.0, 9.0]] * 3) == student_mean([1.0, 2.0, 3.0])
    assert student_mean([4.0]).half_width == math.inf


def test_survival_is_that_of_freireich_1963():
    """Remission of leukaemia under 6-MP, 21 patients, as in Kalbfleisch and Prentice."""
    ended = [6, 6, 6, 7, 10, 13, 16, 22, 23]
    censored = [6, 9, 10, 11, 17, 19, 20, 25, 32, 32, 34, 35]
    curve = statistics.kaplan_meier(
        [*ended, *censored], [True] * len(ended) + [False] * len(censored)
    )
    expected = {6: 0.857, 7: 0.807, 10: 0.753, 13: 0.690, 16: 0.627, 22: 0.538, 23: 0.448}
    for time, survival in expected.items():
        assert curve.survival[curve.times.tolist().index(time)] == pytest.approx(survival, abs=6e-4)
    assert curve.median == 23
    assert math.isinf(statistics.kaplan_meier([5, 9, 9], [True, False, False]).median)
    assert statistics.kaplan_meier([100, 150], [True, True]).median == 125
    assert math.isinf(statistics.kaplan_meier([100, 150], [True, False]).median)


def test_pairs_are_those_of_darwins_plants():
    """Darwin 1876: crossed less self-fertilised Zea mays, 15 pairs, in eighths of an inch.

    Mean 20.93 (Fisher 1935); Wilcoxon's two-sided p is 0.041 for T = 24.
    """
    differences = [49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48]
    found = statistics.paired(dict(enumerate(differences)), dict.fromkeys(range(20), 0))
    assert found.mean.estimate == pytest.approx(20.93, abs=0.01)
    assert found.p == pytest.approx(0.041, abs=1e-3)
    assert found.mean.low == pytest.approx(1.7, abs=2.5)  # Fisher's t interval is 0.03 to 41.8
    assert found.mean.high == pytest.approx(38.0, abs=2.5)
    drugs = [dict(enumerate(hours)) for hours in (SECOND, FIRST)]
    found = statistics.paired(*drugs, student_mean).mean
    assert found.estimate == pytest.approx(1.58)
    assert (found.low, found.high) == pytest.approx((0.7001142, 2.4598858), abs=1e-6)
    assert found.freedom == 9
    differences = [after - before for before, after in zip(FIRST, SECOND, strict=True)]
    found, p = statistics.paired_mean(differences, 0.95)
    assert (found.low, found.high) == pytest.approx((0.7001142, 2.4598858), abs=1e-6)
    assert p == pytest.approx(0.002833, abs=1e-6)
    assert statistics.paired_mean([0.0] * 9, 0.95) == (Interval(0.0, 0.0, 0.0), 1.0)
    assert statistics.paired({3: 1.0, 5: 2.0}, {3: 1.0, 5: 2.0}).p == 1.0


# Student (1908): hours of sleep that two drugs gave the same ten patients
FIRST = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
SECOND = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]
