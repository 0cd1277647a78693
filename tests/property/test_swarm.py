"""Property: whole navigators in random halls keep apart whatever happens to one of them.

Where nothing is the matter for good, everybody arrives as well.
"""

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tests.fakes.traffic import Trial, run

HELD_GAP = 0.5  # [m] that two held tubes keep at least; waffles touch below 0.476 m
STEADY = dict(
    deadline=None,
    derandomize=True,
    phases=(Phase.explicit, Phase.generate),
    suppress_health_check=[HealthCheck.too_slow],
)
trials = st.builds(
    Trial,
    seed=st.integers(0, 2**20),
    loss=st.sampled_from((0.0, 0.2)),
    delay=st.sampled_from((0.0, 0.1, 0.2)),
    restart=st.sampled_from((-1, 60, 150)),
    deaf=st.sampled_from((range(0), range(80, 95), range(80, 140))),
    pillars=st.integers(0, 2),
)


def is_safe(report):
    return report.contacts == 0 and report.tube_gap >= HELD_GAP


@settings(max_examples=6, **STEADY)
@given(trials)
def test_all_arrive_through_loss_delay_deafness_and_a_restart(trial):
    report = run(trial)
    assert is_safe(report), (trial, report)
    assert report.is_done, (trial, report)


@pytest.mark.parametrize("seed", [2, 11])
@pytest.mark.parametrize("fault", ["mute", "numb"])
def test_nobody_touches_a_robot_whose_radio_fails_one_way(fault, seed):
    trial = Trial(seed, loss=0.2, with_lidar=True, **{fault: 60})
    report = run(trial, limit=400)
    assert is_safe(report), (trial, report)


@pytest.mark.parametrize("seed", [3, 4])
def test_nobody_touches_a_restarted_navigator_which_then_arrives(seed):
    report = run(Trial(seed, restart=90))
    assert is_safe(report), report
    assert report.is_done


@pytest.mark.long
@pytest.mark.timeout(7200)
@settings(max_examples=300, **STEADY)
@given(trials)
def test_all_arrive_in_hundreds_of_halls(trial):
    report = run(trial)
    assert is_safe(report), (trial, report)
    assert report.is_done, (trial, report)
