import pytest

from swarm_nav.ros.withholding import LIMIT, START_LIMIT, Withholding
from swarm_sim.ros.settings import RobotEntry, Settings

ENDED = {"has_goal": False, "is_first": False, "has_ended": True}
FIRST = {"has_goal": False, "is_first": True, "has_ended": False}


def test_without_a_mission_nothing_is_withheld():
    withholding = Withholding(False)
    assert not withholding.should_hold(**ENDED)
    assert not withholding.should_hold(**FIRST)


def test_a_mission_from_the_start_withholds_the_first_answer():
    withholding = Withholding(True)
    assert withholding.should_hold(**FIRST)
    assert not withholding.should_hold(**FIRST | {"has_goal": True})


def test_the_end_of_a_goal_is_withheld_until_the_mission_says_so():
    withholding = Withholding(False)
    assert not withholding.on_mission(True, 10.0)
    assert withholding.should_hold(**ENDED)
    withholding.hold(10.0, is_first=False)
    assert withholding.is_holding
    assert not withholding.on_mission(True, 10.0)
    assert withholding.on_mission(False, 11.0)
    withholding.release()
    assert not withholding.should_hold(**ENDED)


def test_patience_ends_and_does_not_start_again_by_itself():
    withholding = Withholding(True)
    withholding.hold(10.0, is_first=False)
    assert not withholding.has_expired(10.0 + 0.9 * LIMIT)
    assert withholding.has_expired(10.0 + LIMIT)
    withholding.release()
    assert not withholding.should_hold(**ENDED)
    withholding.on_mission(True, 10.0)
    assert withholding.should_hold(**ENDED)


def test_the_world_waits_longer_than_a_navigator_withholds():
    settings = Settings(world="any", robots=(RobotEntry("Srobot1", "any"),))
    assert settings.wall_limit > 1.2 * LIMIT


def test_the_first_message_of_a_mission_may_take_as_long_as_a_start():
    withholding = Withholding(True)
    withholding.hold(10.0, is_first=True)
    assert not withholding.has_expired(10.0 + 0.9 * START_LIMIT)
    assert withholding.has_expired(10.0 + START_LIMIT)


@pytest.mark.parametrize("is_early", [False, True])
def test_after_it_the_first_goal_must_follow(is_early):
    withholding = Withholding(True)
    if is_early:
        withholding.on_mission(True, 5.0)
    withholding.hold(10.0, is_first=True)
    since = 10.0
    if not is_early:
        since = 110.0
        withholding.on_mission(True, since)
    withholding.on_mission(True, since + 0.5 * LIMIT)
    assert not withholding.has_expired(since + 0.9 * LIMIT)
    assert withholding.has_expired(since + LIMIT)


def test_a_first_goal_that_fails_before_the_message_is_not_a_start():
    withholding = Withholding(True)
    withholding.hold(10.0, is_first=False)
    assert withholding.has_expired(10.0 + LIMIT)
