"""The radio's measured round trip, and the ticks by which times grow with it."""

import numpy as np
import pytest

from swarm_nav.perception.neighbor_table_kernels import LONGEST_TRIP, mean_trip
from swarm_nav.traffic.patience import TRIPS, USUAL_TRIP, Patience


def after(trip, ticks=600):
    radio = Patience()
    for tick in range(100, 100 + ticks):
        radio.note(mean_trip(np.array((tick - trip,)), tick))
    return radio


@pytest.mark.parametrize(("trip", "extra"), [(1, 0), (3, 0), (5, 2), (10, 12), (40, 72)])
def test_times_grow_by_what_the_round_trips_take_longer(trip, extra):
    assert after(trip).extra == extra == max(0, int(TRIPS * (trip - USUAL_TRIP)))


def test_times_over_a_dead_radio_have_an_end_and_lost_beacons_change_nothing():
    assert after(LONGEST_TRIP).extra < TRIPS * LONGEST_TRIP
    assert after(LONGEST_TRIP + 1).extra == 0
    radio = after(2)
    radio.note(10.0)
    assert radio.extra == 0
    radio = after(10)
    radio.note(mean_trip(np.zeros(0, np.int64), 800))
    assert radio.extra == 12
    acks = np.array((98, 96, 100, 100 - LONGEST_TRIP - 1))
    assert mean_trip(acks, 100) == 3.0
    assert mean_trip(acks[2:], 100) == 0.0
