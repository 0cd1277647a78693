from swarm_nav.withholding import LIMIT, Withholding

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
    assert not withholding.on_mission(True)
    assert withholding.should_hold(**ENDED)
    withholding.hold(10.0)
    assert withholding.is_holding
    assert not withholding.on_mission(True)
    assert withholding.on_mission(False)
    withholding.release()
    assert not withholding.should_hold(**ENDED)


def test_patience_ends_and_does_not_start_again_by_itself():
    withholding = Withholding(True)
    withholding.hold(10.0)
    assert not withholding.has_expired(10.0 + 0.9 * LIMIT)
    assert withholding.has_expired(10.0 + LIMIT)
    withholding.release()
    assert not withholding.should_hold(**ENDED)
    withholding.on_mission(True)
    assert withholding.should_hold(**ENDED)
