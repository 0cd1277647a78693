"""Plug-ins drive robots; one that fails costs its robot the goal, and nobody else anything."""

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose, Twist
from swarm_common.model.sites import Sites
from swarm_common.process import plugins
from swarm_nav.behaviour.plugin_brain import make_brain
from swarm_nav.control.plugin_controller import PluginController
from swarm_nav.core.config import ControllerConfig, NavConfig, PlannerConfig, config_from_parameters
from swarm_nav.core.goals import ErrorCode, Outcome, PlanError
from swarm_nav.core.plugins import KINDS, RULE_NAMES, check_plugins
from swarm_nav.interfaces import Proposal
from swarm_nav.planning.plugin_planner import planner_maker
from swarm_nav.reservation.tube import Tube
from swarm_nav.ros.settings import parse_node_settings
from swarm_nav.traffic.robot_state import initial_state
from tests.fakes import plugins as fakes
from tests.fakes.navigation import Squad, room, waffle

HERE = "tests.fakes.plugins:"
WORKING = {
    "controller.plugin": "Pursuit",
    "planner.plugin": "Dijkstra",
    "localiser.plugin": "DeadReckoning",
    "traffic.priority_plugin": "HighestId",
}


ROOM = room(6.0, 4.0, (2.8, 0.0, 3.2, 1.2))
STARTS = (Pose(1.0, 0.8, 0.0), Pose(5.0, 2.0, math.pi))


def squad(*plugins_of):
    """Return robots, each with plug-ins of `tests.fakes.plugins`."""
    made = Squad(ROOM, STARTS[: len(plugins_of)])
    for index, named in enumerate(plugins_of):
        values = {parameter: HERE + name for parameter, name in named.items()}
        config = config_from_parameters(values)
        made.robots[index] = make_brain(config, waffle(), ROOM, Sites(), index + 1, STARTS[index])
    return made


def cross(robots):
    """Let two robots change sides; return the ticks at which they arrived."""
    robots.send(0, Pose(5.0, 1.0, 0.0), goal_id=1)
    robots.send(1, Pose(1.0, 1.8, 0.0), goal_id=2)
    robots.run_until(lambda: all(robots.ended(index) for index in (0, 1)), 900)
    assert {robots.ended(index)[0].outcome for index in (0, 1)} == {Outcome.SUCCEEDED}
    return [robots.ended(index)[0].tick for index in (0, 1)]


@pytest.mark.parametrize("parameter", WORKING)
def test_each_alone_drives_robots_past_each_other(parameter):
    named = {parameter: WORKING[parameter]}
    is_equal = cross(squad(named, named)) == cross(squad({}, {}))
    assert is_equal == (parameter in ("localiser.plugin", "traffic.priority_plugin"))


def test_own_rules_are_asked_and_say_who_goes_first():
    for named, first in (({}, 0), ({"traffic.priority_plugin": "HighestId"}, 1)):
        robots = squad(named, named)
        robots.send(0, Pose(5.0, 1.0, 0.0))
        robots.send(1, Pose(1.0, 1.8, 0.0))
        robots.run(20)
        ranks = [robot._s.priority for robot in robots.robots]
        assert ranks.index(max(ranks)) == first
    robots = with_rule("Stand")
    robots.run(99)
    assert robots.bodies[0].pose.distance(STARTS[0]) < 0.05
    assert robots.robots[0].status().detail == "has lunch"
    robots.run_until(lambda: robots.ended(0), 600)
    assert robots.ended(0)[0].outcome is Outcome.SUCCEEDED


def test_a_large_correction_of_the_pose_waits_for_a_standstill():
    robots = squad({"localiser.plugin": "Jumping"})
    (robot,) = robots.robots
    robots.send(0, Pose(5.0, 3.0, 0.0))
    robots.run(fakes.JUMP - 1)
    assert robots.bodies[0].twist.vx > 0.2
    before = robot.pose_map
    robots.run(2)
    assert robot.pose_map.distance(before) < 0.1
    robots.run_until(lambda: abs(robot.pose_map.y - robots.bodies[0].pose.y - 0.5) < 1e-6, 20)
    assert robots.bodies[0].twist.vx < 0.02


CODES = {
    "controller.plugin": (100, 106, 107),
    "planner.plugin": (200, 208, 207),
    "localiser.plugin": (202, 202, 202),
    "traffic.priority_plugin": (100, 106, 107),
    "brain.plugin": (100, 106, 107),
}


@pytest.mark.parametrize("parameter", CODES)
@pytest.mark.parametrize(("fault", "name"), enumerate(("Failing", "Nan", "Late")))
def test_one_that_fails_costs_its_robot_the_goal_only(parameter, fault, name, monkeypatch, capsys):
    monkeypatch.setattr(plugins, "_printed", set())
    monkeypatch.setattr(plugins, "MOST_TIME", fakes.LATE / 2)
    robots = squad({parameter: name}, {})
    for goal_id in (1, 2):
        robots.send(0, Pose(5.0, 1.0, 0.0), goal_id=goal_id)
        robots.send(1, Pose(3.8, 2.0, 0.0), goal_id=goal_id)
        robots.run(60)
    kind = next(kind for kind in KINDS if kind.parameter == parameter)
    for end in robots.ended(0):
        assert (end.outcome, end.error_code) == (Outcome.ABORTED, CODES[parameter][fault])
        assert end.message.startswith(f"{kind.word} {HERE}{name}: ")
    assert [end.goal_id for end in robots.ended(0)] == [1, 2]
    assert robots.distance(0, STARTS[0]) < 1e-3
    assert [end.outcome for end in robots.ended(1)][-1] is Outcome.SUCCEEDED
    assert capsys.readouterr().err.count(f"{kind.word} {HERE}{name}: ") == 1


ANSWERS = {
    "no path from": np.zeros((0, 2)),
    "no path from (1.00, 0.80) to (5.00, 1.00): planner": [],
    "plan returned (2,); expected points (n, 2)": np.array((1.0, 2.0)),
    "plan returned NoneType; expected points (n, 2)": None,
    "plan returned a path that begins 1.00 m off": np.array(((2.0, 0.8), (5.0, 1.0))),
    "plan returned a path that ends 3.00 m off": np.array(((1.0, 0.8), (2.0, 1.0))),
    "plan returned a path into a wall at (2.": np.array(((1.0, 0.8), (5.0, 1.0))),
    "plan returned (90.00, 1.00), which is off the map": np.array(((1.0, 0.8), (90.0, 1.0))),
    "plan returned (nan, 1.00), which is off the map": np.array(((np.nan, 1.0), (5.0, 1.0))),
    "plan returned a path of ": np.tile(((1.0, 0.8), (5.0, 1.0)), (2000, 1)),
}


@pytest.mark.parametrize("message", ANSWERS)
def test_a_path_that_is_none_is_told(message):
    maker = planner_maker(f"{__name__}:Answering", waffle())
    planner = maker(
        initial_state(NavConfig(), waffle(), ROOM, 1, STARTS[0]).terrain, PlannerConfig()
    )
    Answering.answer = ANSWERS[message]
    with pytest.raises(PlanError, match=re.escape(message)) as caught:
        planner.plan((1.0, 0.8), (5.0, 1.0), planner.no_extra())
    assert caught.value.code is ErrorCode.NO_VALID_PATH
    assert caught.value.is_final == message.startswith("plan returned")
    Answering.answer = [(1.0, 0.8)]
    assert len(planner.plan((1.0, 0.8), (1.02, 0.81), planner.no_extra())) >= 2


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.word)
def test_one_that_is_missing_is_told_before_the_start(kind):
    check_plugins(NavConfig())
    kind.load(next(iter(kind.built_in)))
    values = {kind.parameter: "tests.fakes.plugins:Nobody"}
    with pytest.raises(ConfigError, match=f"unknown {kind.parameter} 'Nobody'"):
        check_plugins(config_from_parameters(values))
    with pytest.raises(ConfigError, match="'nowhere:Mine': there is no module 'nowhere'"):
        check_plugins(config_from_parameters({kind.parameter: "nowhere:Mine"}))
    with pytest.raises(ConfigError, match=f"'collections:Counter', which has no {kind.method}"):
        check_plugins(config_from_parameters({kind.parameter: "collections:Counter"}))


def test_a_navigators_parameters_are_refused_with_a_plug_in_that_is_missing():
    from tests.graph.conftest import parameters

    values = parameters(1, [0.0, 0.0, 0.0]) | {"planner.plugin": "nowhere:Mine"}
    with pytest.raises(ConfigError, match=r"here\.yaml: planner.plugin is 'nowhere:Mine'"):
        parse_node_settings("Srobot1", values, "here.yaml")


class Answering:
    answer: Any = None

    def __init__(self, spec):
        pass

    def follow(self, *_):
        return Answering.answer

    plan = follow


NUMBERS = st.floats(width=32) | st.just(None) | st.just("fast")


@settings(max_examples=60, deadline=None)
@given(NUMBERS, NUMBERS, st.integers(0, 12), st.floats(0.0, 0.26))
def test_whatever_a_controller_answers_the_command_is_within_the_limits(vx, wz, held, speed):
    faults: list[str] = []
    config = ControllerConfig(plugin=f"{__name__}:Answering")
    controller = PluginController(waffle(), config, lambda code, message: faults.append(message))
    tube = Tube(Pose(0.0, 0.0, 0.0), 1, 0.35, 0.35)
    tube.adopt(np.array([(0.05 * k, 0.0) for k in range(16)]))
    tube.stop = held
    tube.track(Pose(0.0, 0.0, 0.0))
    Answering.answer = Twist(vx, 0.0, wz)
    chosen = controller.follow(tube, Pose(0.0, 0.0, 0.0), Twist(speed, 0.0, 0.0))
    is_usable = all(isinstance(value, float) and math.isfinite(value) for value in (vx, wz))
    assert bool(faults) != is_usable
    assert abs(chosen.vx) <= 0.26 + 1e-9
    assert abs(chosen.wz) <= 1.82 + 1e-9
    if held == 0:
        assert chosen.vx == 0.0


class Stand:
    def __init__(self, spec):
        pass

    def propose(self, state):
        return Proposal(stands=True, why="has lunch") if state.tick < 100 else None


class Wrong(Stand):
    def propose(self, state):
        return Proposal(path=np.full((3, 2), np.nan))


class Mute(Stand):
    def propose(self, state):
        return Proposal(why=7)


def with_rule(name):
    robots = squad({})
    rules = " ".join(("keep_apart", f"{__name__}:{name}", *RULE_NAMES[1:]))
    config = config_from_parameters({"traffic.rules": rules})
    robots.robots[0] = make_brain(config, waffle(), ROOM, Sites(), 1, STARTS[0])
    robots.send(0, Pose(5.0, 2.0, 0.0))
    return robots


@pytest.mark.parametrize(("rule", "message"), [("Wrong", "off the map"), ("Mute", "why must be")])
def test_a_rule_that_proposes_nonsense_ends_the_goal(rule, message):
    robots = with_rule(rule)
    robots.run(60)
    (end,) = robots.ended(0)
    assert message in end.message


@pytest.mark.parametrize("rules", ["", " ", ","])
def test_no_rules_at_all_are_refused(rules):
    with pytest.raises(ConfigError, match=r"traffic\.rules is empty; expected all"):
        config_from_parameters({"traffic.rules": rules})
