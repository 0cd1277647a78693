"""Navigators that die, hang, or are wanted anew by the user; the fork server is a list."""

from typing import Any

import pytest

from swarm_commander.run.processes.navigators import (
    ANSWER_LIMIT,
    HANGING,
    START_LIMIT,
    NavigatorSupervisor,
)
from swarm_commander.run.processes.restarts import STALL, Heartbeats, Restarts
from swarm_commander.run.results.run_statistics import Meters, RunStatistics
from swarm_common.model.breaches import MissedGoal
from swarm_common.process.messages import (
    GoalMissed,
    GoalSent,
    GoalsRestored,
    KillNavigator,
    MissionLoaded,
    StartNavigator,
)
from swarm_mission.itinerary import LOST_REASON


class Clock:
    """Wall time that the test moves."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


class Case:
    """A keeper of two navigators."""

    def __init__(self, *, restarts=True):
        self.clock = Clock()
        self.told: list[Any] = []
        self.restarts = Restarts(is_allowed=restarts)
        self.supervisor = NavigatorSupervisor(self.restarts, self.told.append, self.clock)
        self.supervisor.params |= {"Srobot1": "1.yaml", "Srobot2": "2.yaml"}

    def turn(self, seconds):
        self.clock.now += seconds
        self.supervisor.turn(self.restarts.pop_due(self.clock.now))

    def fork(self, name):
        self.supervisor.on_fork(name)


@pytest.fixture
def case():
    return Case()


def test_a_dead_navigator_is_started_anew(case):
    assert case.supervisor.on_death("Srobot1") == 1.0
    case.turn(0.5)
    assert case.told == []
    case.turn(0.5)
    assert case.told == [StartNavigator("Srobot1", "1.yaml")]
    case.fork("Srobot1")
    assert case.supervisor.on_active("Srobot1")
    assert not case.supervisor.on_active("Srobot2"), "which was never down"


def test_one_that_is_wanted_anew_is_killed_first_and_its_deaths_do_not_count(case):
    for _ in range(5):
        case.supervisor.on_death("Srobot1")
        case.turn(60.0)
    case.told.clear()
    case.supervisor.restart("Srobot1")
    case.turn(0.1)
    assert case.told == [KillNavigator("Srobot1")], "not started before it is dead"
    assert case.supervisor.on_death("Srobot1") == 0.0
    case.turn(0.1)
    assert isinstance(case.told[1], StartNavigator)
    assert case.supervisor.on_death("Srobot1") is not None


def test_one_that_others_have_forgotten_begins_anew_even_if_nobody_is_restarted():
    case = Case(restarts=False)
    assert case.supervisor.on_death("Srobot1") is None
    assert case.supervisor.on_death("Srobot2", begins_anew=True) == 0.0
    case.turn(0.1)
    assert case.told == [StartNavigator("Srobot2", "2.yaml")]


def test_one_that_stays_down_may_be_wanted_again_and_figures_are_added(case):
    case.supervisor.given_up.add("Srobot1")
    case.supervisor.restart("Srobot1")
    case.turn(0.0)
    assert case.told == [StartNavigator("Srobot1", "1.yaml")]
    assert case.supervisor.given_up == set()
    meters = Meters()
    assert [meters.count("a", value) for value in (1.0, 3.0, 0.0, 2.0, 1.0)] == [1, 3, 3, 5, 6]


def test_one_that_hangs_is_noticed_once_and_so_is_a_deaf_fork_server(case):
    case.supervisor.on_death("Srobot1")
    case.turn(1.0)
    case.fork("Srobot1")
    case.clock.now += START_LIMIT
    assert case.supervisor.overdue() == []
    case.clock.now += 1.0
    assert case.supervisor.overdue() == ["Srobot1"]
    assert case.supervisor.overdue() == []
    case.supervisor.kill("Srobot1")
    case.turn(ANSWER_LIMIT + 0.1)
    assert case.supervisor.is_fork_server_deaf()
    case.supervisor.on_death("Srobot1")
    assert not case.supervisor.is_fork_server_deaf()


def test_stragglers_of_the_start_are_noticed_when_the_others_have_long_been_active(case):
    names = ["Srobot1", "Srobot2"]
    assert case.supervisor.stragglers(0, names) == []
    case.clock.now += 10.0 * HANGING
    assert case.supervisor.stragglers(0, names) == [], "nobody can be: kernels are compiled"
    assert case.supervisor.stragglers(1, names[1:]) == []
    case.clock.now += HANGING
    assert case.supervisor.stragglers(1, names[1:]) == ["Srobot2"]
    assert case.supervisor.stragglers(1, names[1:]) == []


def test_nobody_is_started_twice_or_after_it_was_taken_out(case):
    case.supervisor.on_death("Srobot1")
    case.supervisor.given_up.add("Srobot2")
    assert case.supervisor.on_fork_server_end() == ["Srobot1"]
    case.turn(60.0)
    assert case.told == []
    case.supervisor.on_death("Srobot1")
    case.supervisor.remove("Srobot1")
    case.turn(60.0)
    assert case.told == []


def test_silence_counts_from_the_last_word_and_not_while_we_slept():
    clock = Clock()
    beats = Heartbeats(clock)
    assert beats.silence("world") == 0.0, "it was never heard"
    beats.hear("world")
    for _ in range(10):
        clock.now += 0.5
        beats.look()
    assert beats.silence("world") == 5.0
    clock.now += STALL + 100.0
    beats.look()
    assert beats.silence("world") == 0.0, "what it said meanwhile is not read yet"


def test_goals_of_a_robot_that_is_found_again_are_not_missed():
    statistics = RunStatistics.of(["Srobot1"], True)
    statistics.apply(MissionLoaded(3))
    statistics.apply(GoalSent("Srobot1", "a"))
    for name, reason in (("a", "closed"), ("b", LOST_REASON), ("c", LOST_REASON)):
        statistics.apply(GoalMissed(MissedGoal("Srobot1", name, 5.0, reason)))
    assert (statistics.failed, statistics.pending) == (3, 0)
    statistics.apply(GoalsRestored("Srobot1", 2, "b"))
    assert (statistics.sent, statistics.failed, statistics.pending) == (2, 1, 2)
    assert [miss.goal for miss in statistics.misses] == ["a"]
    statistics.on_mission_restart()
    assert (statistics.sent, statistics.pending) == (1, 2), "the goal in hand will be sent again"
