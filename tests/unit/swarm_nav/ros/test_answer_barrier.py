import pytest

from swarm_nav.ros.answer_barrier import LIMIT, START_LIMIT, AnswerBarrier

ENDED = {"has_goal": False, "is_first": False, "has_ended": True}
FIRST = {"has_goal": False, "is_first": True, "has_ended": False}


def test_without_a_mission_nothing_is_withheld_and_with_one_the_first_answer_is():
    answer_barrier = AnswerBarrier(False)
    assert not answer_barrier.should_hold(**ENDED)
    assert not answer_barrier.should_hold(**FIRST)
    answer_barrier = AnswerBarrier(True)
    assert answer_barrier.should_hold(**FIRST)
    assert not answer_barrier.should_hold(**FIRST | {"has_goal": True})


def test_the_end_of_a_goal_is_withheld_until_the_mission_says_so():
    answer_barrier = AnswerBarrier(False)
    assert not answer_barrier.on_mission(True, 10.0)
    assert answer_barrier.should_hold(**ENDED)
    answer_barrier.hold(10.0, is_first=False)
    assert answer_barrier.is_holding
    assert not answer_barrier.on_mission(True, 10.0)
    assert answer_barrier.on_mission(False, 11.0)
    answer_barrier.release()
    assert not answer_barrier.should_hold(**ENDED)


def test_with_a_courier_every_answer_waits_until_it_has_been_silent_for_too_long():
    answer_barrier = AnswerBarrier(False, has_courier=True)
    driving = {"has_goal": True, "is_first": False, "has_ended": False}
    assert answer_barrier.should_hold(**driving)
    answer_barrier.on_release()
    answer_barrier.hold(10.0, is_first=False)
    assert answer_barrier.has_expired(10.0 + LIMIT)
    answer_barrier.release()
    assert not answer_barrier.should_hold(**driving)
    answer_barrier.on_release()
    assert answer_barrier.should_hold(**driving)


def test_patience_ends_and_does_not_start_again_by_itself():
    answer_barrier = AnswerBarrier(True)
    answer_barrier.hold(10.0, is_first=False)
    assert not answer_barrier.has_expired(10.0 + 0.9 * LIMIT)
    assert answer_barrier.has_expired(10.0 + LIMIT)
    answer_barrier.release()
    assert not answer_barrier.should_hold(**ENDED)
    answer_barrier.on_mission(True, 10.0)
    assert answer_barrier.should_hold(**ENDED)


def test_the_first_message_may_take_as_long_as_a_start():
    answer_barrier = AnswerBarrier(True)
    answer_barrier.hold(10.0, is_first=True)
    assert not answer_barrier.has_expired(10.0 + 0.9 * START_LIMIT)
    assert answer_barrier.has_expired(10.0 + START_LIMIT)
    answer_barrier = AnswerBarrier(True)
    answer_barrier.hold(10.0, is_first=False)
    assert answer_barrier.has_expired(10.0 + LIMIT)


@pytest.mark.parametrize("is_early", [False, True])
def test_after_it_the_first_goal_must_follow(is_early):
    answer_barrier = AnswerBarrier(True)
    if is_early:
        answer_barrier.on_mission(True, 5.0)
    answer_barrier.hold(10.0, is_first=True)
    since = 10.0
    if not is_early:
        since = 110.0
        answer_barrier.on_mission(True, since)
    answer_barrier.on_mission(True, since + 0.5 * LIMIT)
    assert not answer_barrier.has_expired(since + 0.9 * LIMIT)
    assert answer_barrier.has_expired(since + LIMIT)
