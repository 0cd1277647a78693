"""The radio's measured round trip, and the factor by which times grow with it."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_nav.perception.neighbor_table_kernels import mean_trip
from swarm_nav.traffic.patience import LONGEST_TRIP, MOST, USUAL_TRIP, Patience


def after(trip: int, ticks: int = 600) -> Patience:
    """Return the patience of a robot whose beacons are acknowledged after `trip` ticks."""
    radio = Patience()
    for tick in range(100, 100 + ticks):
        radio.note(np.array((tick - trip,)), tick)
    return radio


@pytest.mark.parametrize(("trip", "factor"), [(1, 1), (2, 1), (5, 2), (10, 4), (40, 8)])
def test_times_grow_with_the_round_trip_up_to_a_limit(trip: int, factor: int) -> None:
    assert after(trip).factor == factor == min(MOST, max(1, round(trip / USUAL_TRIP)))


def test_a_lost_beacon_or_two_change_nothing() -> None:
    radio = after(2)
    radio.note(np.array((690,)), 700)
    assert radio.factor == 1


def test_without_neighbours_the_last_measurement_stays() -> None:
    radio = after(10)
    radio.note(np.zeros(0, np.int64), 800)
    assert radio.factor == 4


def test_acknowledgements_of_now_or_of_long_ago_do_not_count() -> None:
    acks = np.array((98, 96, 100, 100 - LONGEST_TRIP - 1))
    assert mean_trip(acks, 100, LONGEST_TRIP) == 3.0
    assert mean_trip(acks[2:], 100, LONGEST_TRIP) == 0.0
