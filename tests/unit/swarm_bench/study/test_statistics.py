"""The statistics reproduce published examples."""

from __future__ import annotations

import math

import pytest

from swarm_bench.study import statistics


def test_wilson_interval_of_newcombe_1998():
    """Newcombe 1998, table I, method 3: 81 of 263."""
    found = statistics.wilson(81, 263)
    assert found.low == pytest.approx(0.2553, abs=5e-5)
    assert found.high == pytest.approx(0.3662, abs=5e-5)


def test_wilson_interval_of_no_success_in_20():
    """Newcombe 1998, table I, method 3: 0 of 20."""
    found = statistics.wilson(0, 20)
    assert found.low == pytest.approx(0.0, abs=1e-9)
    assert found.high == pytest.approx(0.1611, abs=5e-5)


def test_zero_contacts_in_1305_runs():
    assert statistics.bound_of_zero(1305) == pytest.approx(0.0023, abs=5e-5)
    assert statistics.bound_of_zero(100) == pytest.approx(3.0 / 100, rel=0.02)


def test_holm_of_four_p_values():
    """0.01, 0.04, 0.03, 0.005: 0.005 and 0.01 are rejected at 5 %, the others are not."""
    found = statistics.holm([0.01, 0.04, 0.03, 0.005])
    assert found == pytest.approx([0.03, 0.06, 0.06, 0.02])


def test_kaplan_meier_of_freireich_1963():
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


def test_median_of_runs_that_mostly_do_not_end_is_infinite():
    assert math.isinf(statistics.kaplan_meier([5, 9, 9], [True, False, False]).median)


def test_the_median_of_two_runs_is_their_mean():
    assert statistics.kaplan_meier([100, 150], [True, True]).median == 125
    assert math.isinf(statistics.kaplan_meier([100, 150], [True, False]).median)


def test_interquartile_mean():
    assert statistics.interquartile_mean([0, 1, 2, 3, 4, 5, 6, 1000]) == pytest.approx(3.5)


def test_paired_difference_of_darwins_plants():
    """Darwin 1876: crossed less self-fertilised Zea mays, 15 pairs, in eighths of an inch.

    Mean 20.93 (Fisher 1935); Wilcoxon's two-sided p is 0.041 for T = 24.
    """
    differences = [49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48]
    found = statistics.paired(differences, [0] * 15)
    assert found.mean.estimate == pytest.approx(20.93, abs=0.01)
    assert found.p == pytest.approx(0.041, abs=1e-3)
    assert found.mean.low == pytest.approx(1.7, abs=2.5)  # Fisher's t interval is 0.03 to 41.8
    assert found.mean.high == pytest.approx(38.0, abs=2.5)


def test_equal_methods_do_not_differ():
    assert statistics.paired([1.0, 2.0], [1.0, 2.0]).p == 1.0


def test_critical_size_is_where_throughput_stays_or_runs_fail():
    gains = {
        10: {0: 100, 1: 101}, 20: {0: 180, 1: 181}, 35: {0: 181, 1: 182}, 50: {0: 170, 1: 171}
    }  # fmt: skip
    fine = {size: {0: True, 1: True} for size in gains}
    assert statistics.critical_size(gains, fine) == (20, 20, 20)
    assert statistics.critical_size(gains, fine | {20: {0: True, 1: False}}).estimate == 10
    assert statistics.critical_size(gains, fine | {10: {0: False, 1: False}}).estimate == 0


def test_sides_change_once_or_not_at_all():
    rising = {10: [-5.0, -4.0, -6.0], 20: [-1.0, 2.5, -1.0], 35: [4.0, 5.0, 6.0]}
    found = statistics.change_of_sides(rising)
    assert found is not None
    assert found == (20, 20, 35)
    assert statistics.change_of_sides({10: [1.0], 20: [2.0]}) is None
    assert statistics.change_of_sides({}) is None


def test_performance_profile():
    assert statistics.profile([1.0, 1.2, math.inf, 3.0], (1.0, 1.25, 5.0)) == [0.25, 0.5, 0.75]


def test_a_run_that_never_catches_up_has_not_recovered():
    usual = ([1] * 10, [1] * 10)
    found = statistics.dip_of(([1] * 10, [1] * 5 + [0] * 5), usual, 5, 60.0)
    assert found == (1.0, 5.0, 15.0, 300.0, False)
    assert statistics.dip_of(usual, usual, 5, 60.0) == (0.0, 0.0, 0.0, 0.0, True)
