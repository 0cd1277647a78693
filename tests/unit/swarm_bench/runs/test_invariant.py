"""The watch on the safety invariant, against its slow twin."""

import math

import numpy as np
import pytest

from swarm_bench.runs.invariant import FAR, Invariant
from swarm_common.model.beacon import empty_beacons
from tests.oracles.held_gap import smallest


def swarm(seed, count, extent):
    rng = np.random.default_rng(seed)
    beacons = empty_beacons(count)
    beacons["id"] = np.arange(count) + 1
    beacons["radius"] = rng.uniform(0.1, 0.3, count)
    beacons["held_size"] = rng.integers(0, 25, count)
    starts = rng.uniform(0.0, extent, (count, 1, 2))
    beacons["held"] = starts + np.cumsum(rng.normal(0.0, 0.04, (count, 24, 2)), axis=1)
    beacons["pose"][:, :2] = starts[:, 0] + rng.normal(0.0, 0.04, (count, 2))
    return beacons


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(("count", "extent"), [(2, 1.0), (9, 3.0), (30, 12.0)])
def test_it_finds_what_the_slow_twin_finds(seed, count, extent):
    beacons = swarm(seed, count, extent)
    watch = Invariant()
    watch.check(0, beacons)
    gap, slack = smallest(beacons)
    if gap < FAR:
        assert watch.gap == pytest.approx(gap, abs=1e-6)
        assert watch.slack == pytest.approx(slack, abs=1e-6)
    else:
        assert watch.gap == math.inf


def test_the_smallest_of_all_ticks_is_kept_and_a_breach_names_the_pair():
    beacons = empty_beacons(3)
    beacons["id"] = [4, 7, 9]
    beacons["radius"] = 0.285
    beacons["held_size"] = 1
    watch = Invariant()
    for tick, distance in enumerate((0.8, 0.58, 0.5, 0.7)):
        beacons["held"][:, 0, 0] = beacons["pose"][:, 0] = (0.0, distance, 9.0)
        watch.check(tick, beacons)
    assert watch.gap == pytest.approx(0.5)
    assert watch.slack == pytest.approx(-0.07)
    assert watch.breach.tick == 2
    assert set(watch.breach.robots) == {4, 7}
