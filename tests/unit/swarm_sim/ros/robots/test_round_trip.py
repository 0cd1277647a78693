"""When an answer is asked for again: RFC 6298, with our limits."""

import numpy as np
import pytest

from swarm_sim.ros.robots.round_trip import FIRST, LEAST, LONGEST, RoundTrip


def answered(trip, now, times):
    """Let answers take some times [s], one after the other; return the time on the wall then."""
    for time in times:
        trip.send(now)
        now += time
        trip.answer(now)
    return now


def test_the_equations_of_the_rfc():
    trip = RoundTrip(0.0)
    assert trip.limit == FIRST
    answered(trip, 0.0, [0.1])
    assert trip.limit == pytest.approx(0.1 + 4 * 0.05)  # 2.2
    answered(trip, 5.0, [0.2])  # 2.3: the deviation first
    deviation = 0.75 * 0.05 + 0.25 * 0.1
    assert trip.limit == pytest.approx((7 / 8 * 0.1 + 1 / 8 * 0.2) + 4 * deviation)


@pytest.mark.parametrize("time", [0.002, 0.015, 0.08, 0.3])
def test_the_limit_follows_the_link(time):
    """A period of 0.25 s is 100 times too long on one link, and too short on the other."""
    trip = RoundTrip(LEAST)
    jitter = np.random.default_rng(1).uniform(0.8, 1.2, 200)
    answered(trip, 0.0, (time * jitter).tolist())
    assert time * 1.2 < trip.limit + 1e-9 or trip.limit == LEAST
    assert trip.limit < max(3.0 * time, 2 * LEAST)


def test_each_repeat_doubles_the_limit_until_an_answer_comes_at_the_first_time():
    trip = RoundTrip(LEAST)
    now = answered(trip, 0.0, [0.02] * 50)
    trip.send(now)
    sent, limits = [now], [trip.limit]
    while now < 3.0:
        now = trip.due_at
        trip.repeat(now)
        sent.append(now)
        limits.append(trip.limit)
    assert limits[1] == pytest.approx(2 * limits[0])
    assert limits[-1] == LONGEST
    assert len(sent) < 12  # in 2 s; with a fixed period of 0.02 s it would be 100
    trip.answer(now + 0.02)  # to which of them? (Karn)
    assert trip.limit == LONGEST
    answered(trip, now + 1.0, [0.02])
    assert trip.limit < 0.1


def test_a_link_that_becomes_slower_than_its_limit_is_learned():
    trip = RoundTrip(LEAST)
    now = answered(trip, 0.0, [0.005] * 50)
    for _ in range(20):
        trip.send(now)
        end = now + 0.15
        while trip.due_at < end:
            trip.repeat(trip.due_at)
        trip.answer(end)
        now = end
    trip.send(now)
    assert trip.due_at - now > 0.15


def test_repeats_that_were_not_needed_lengthen_the_limit():
    """On a busy machine every tenth answer takes long; nothing is lost."""
    trip, now, repeats = RoundTrip(LEAST), 0.0, 0
    for turn in range(1000):
        trip.send(now)
        end = now + (0.08 if turn % 10 == 0 else 0.02)
        while trip.due_at < end:
            trip.repeat(trip.due_at)
            repeats += turn >= 100
        trip.answer(end)
        now = end
    assert repeats < 150  # of 900; 180 if only answers that came in time counted


def test_on_one_host_nothing_is_repeated_and_hurrying_is_no_repeat():
    trip = RoundTrip(0.25)
    answered(trip, 0.0, [0.001] * 100)
    assert trip.limit == 0.25
    trip = RoundTrip(LEAST)
    now = answered(trip, 0.0, [0.02] * 50)
    limit = trip.limit
    trip.send(now)
    trip.hurry(now + 0.015)
    assert trip.is_hurried
    assert trip.limit == limit
    assert trip.due_at == pytest.approx(now + 0.015 + limit)
    trip.answer(now + 0.04)  # to which of them?
    assert trip.limit == limit
    trip.send(now + 0.1)
    assert not trip.is_hurried
