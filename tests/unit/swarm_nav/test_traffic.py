"""Property: in any hall with room to pass and to wait, nobody touches and everybody arrives."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.fakes.traffic import Trial, run

HELD_GAP = 0.5  # [m] that two held tubes keep at least, whatever happens
HULL_CONTACT = 0.476  # [m] between centres up to which two waffles can touch


@settings(
    max_examples=4, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)  # fmt: skip
@given(seed=st.integers(0, 10_000), loss=st.sampled_from((0.0, 0.2)))
def test_nobody_touches_and_everybody_arrives(seed, loss):
    trial = Trial(seed, loss)
    report = run(trial)
    assert report.contacts == 0
    assert report.tube_gap >= HELD_GAP > HULL_CONTACT
    assert report.is_done, report


@pytest.mark.parametrize("seed", [7, 8, 19])
def test_the_others_arrive_when_one_dies(seed):
    report = run(Trial(seed, death=100), limit=1600)  # a goal may be waited for for 120 s
    assert report.contacts == 0
    assert report.tube_gap >= HELD_GAP
    assert report.is_done, report


@pytest.mark.parametrize("loss", [0.6, 0.9])
def test_with_a_very_bad_radio_nobody_touches(loss):
    report = run(Trial(5, loss), limit=400)
    assert report.contacts == 0
    assert report.tube_gap >= HELD_GAP
