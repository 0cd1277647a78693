"""Whose navigator is started anew."""

from swarm_commander.laggards import PATIENCE, Laggards


def test_who_lags_behind_the_others_is_started_anew_once():
    laggards = Laggards()
    assert laggards.due(5.0, ["Srobot1", "Srobot2"], 98) == []
    assert laggards.due(10.0, ["Srobot2"], 99) == []
    assert laggards.due(9.0 + PATIENCE, ["Srobot2"], 99) == []
    assert laggards.due(11.0 + PATIENCE, ["Srobot2"], 99) == ["Srobot2"]
    assert laggards.due(12.0 + PATIENCE, ["Srobot2"], 99) == []


def test_nobody_is_started_anew_before_the_first_is_active():
    laggards = Laggards()
    assert laggards.due(10.0 * PATIENCE, ["Srobot1", "Srobot2"], 0) == []
