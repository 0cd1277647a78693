"""Property: whatever the radio does and whoever changes his mind, two held tubes keep apart."""

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from swarm_nav.core.config import NavConfig, TrafficConfig
from tests.fakes.protocol import Crowd, Schedule

ROUNDING = 1e-4  # [m] beacons carry float32

RADIOS = {
    "as it is": {},
    "lossy": {"loss": 0.2},
    "very lossy": {"loss": 0.8},
    "a tick late": {"delay": 1},
    "two ticks late": {"delay": 2},
    "five ticks late": {"delay": 5},
    "out of order": {"jitter": 3},
    "lossy and out of order": {"loss": 0.3, "jitter": 2, "delay": 1},
}
FATES = {
    "all well": {},
    "at times deaf": {"deafness": 0.004},
    "dying and restarted": {"deaths": 0.003},
    "links that fail one way": {"cut_links": 0.4},
    "a mute robot": {"mute": 1, "whims": 0.04},
    "a robot that hears nobody": {"hard_of_hearing": 1},
    "a mute one and one that hears nobody": {"mute": 1, "hard_of_hearing": 1, "count": 5},
    "everything": {"deafness": 0.003, "deaths": 0.002, "whims": 0.04},
}
FOUND = (  # by long searches
    # near a request that became the space of a silent robot, a tube grew toward its body
    Schedule(1233713562, ticks=500, whims=0.05, mute=1),
    Schedule(839305063, count=6, ticks=200, delay=1, whims=0.0, deaths=0.003),
    # a robot beyond 2 m moved on where the one that did not hear it could not know
    Schedule(1528265272, count=5, ticks=250, delay=2, whims=0.05, hard_of_hearing=1),
    # a robot beyond 2 m did not have to know a request before it was granted
    Schedule(999417356, 5, 500, 0.5, whims=0.01, cut_links=0.5, mute=1, hard_of_hearing=1),
)
seeds = st.integers(0, 2**31)
schedules = st.builds(
    Schedule,
    seed=seeds,
    count=st.integers(2, 6),
    ticks=st.just(200),
    loss=st.sampled_from((0.0, 0.2, 0.5, 0.8)),
    delay=st.sampled_from((0, 0, 1, 2, 4)),
    jitter=st.sampled_from((0, 0, 2, 5)),
    whims=st.sampled_from((0.0, 0.01, 0.05)),
    deafness=st.sampled_from((0.0, 0.004)),
    deaths=st.sampled_from((0.0, 0.003)),
)
sick = st.builds(
    Schedule,
    seed=seeds,
    count=st.integers(3, 6),
    ticks=st.sampled_from((250, 500)),
    loss=st.sampled_from((0.0, 0.2, 0.5)),
    delay=st.sampled_from((0, 1, 2)),
    jitter=st.sampled_from((0, 2)),
    whims=st.sampled_from((0.01, 0.05)),
    cut_links=st.sampled_from((0.0, 0.5)),
    mute=st.integers(0, 2),
    hard_of_hearing=st.integers(0, 1),
)
STEADY = dict(deadline=None, derandomize=True, phases=(Phase.explicit, Phase.generate))


def keeps_apart(schedule, config=None):
    """Fail unless all held tubes kept the sum of both radii, the slack aside, in every tick."""
    config = config or NavConfig()
    outcome = Crowd(schedule, config).run()
    assert outcome.excess >= -config.traffic.yield_slack - ROUNDING, (outcome, schedule)


@pytest.mark.parametrize("fate", FATES)
@pytest.mark.parametrize("radio", RADIOS)
def test_held_tubes_keep_apart(radio, fate):
    keeps_apart(Schedule(4, **RADIOS[radio], **FATES[fate]))


@pytest.mark.parametrize("schedule", FOUND)
def test_held_tubes_keep_apart_where_they_once_did_not(schedule):
    keeps_apart(schedule)


@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow], **STEADY)
@given(schedules)
def test_held_tubes_keep_apart_in_any_schedule(schedule):
    keeps_apart(schedule)


@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow], **STEADY)
@given(sick)
def test_held_tubes_keep_apart_as_long_as_one_of_two_hears_the_other(schedule):
    keeps_apart(schedule)


@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow], **STEADY)
@given(schedules, st.integers(1, 6), st.sampled_from((0.1, 0.35, 0.8)), st.sampled_from((0.1, 0.4)))
def test_held_tubes_keep_apart_with_other_lengths_and_confirmations(
    schedule, confirmations, held, wanted
):
    traffic = TrafficConfig(confirmations=confirmations, held_length=held, wanted_length=wanted)
    keeps_apart(schedule, NavConfig(traffic=traffic))


@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow], **STEADY)
@given(seeds, st.sampled_from((0.0, 0.3)))
def test_without_yielding_and_whims_not_even_the_slack_is_used(seed, loss):
    outcome = Crowd(Schedule(seed, loss=loss, whims=0.0)).run()
    assert outcome.excess >= -ROUNDING


@pytest.mark.parametrize("radio", ["as it is", "lossy", "two ticks late"])
def test_space_is_granted_all_the_same(radio):
    granted = [Crowd(Schedule(seed, **RADIOS[radio])).run().granted for seed in range(3)]
    assert min(granted) > 200  # path points of 5 cm, in 40 s


def test_equal_schedules_run_equally():
    schedule = Schedule(5, loss=0.3, jitter=2, deafness=0.003, deaths=0.002)
    assert Crowd(schedule).run() == Crowd(schedule).run()


@pytest.mark.long
@pytest.mark.timeout(3600)
@settings(max_examples=3000, suppress_health_check=[HealthCheck.too_slow], **STEADY)
@given(st.one_of(schedules, sick))
def test_held_tubes_keep_apart_in_thousands_of_schedules(schedule):
    keeps_apart(schedule)
