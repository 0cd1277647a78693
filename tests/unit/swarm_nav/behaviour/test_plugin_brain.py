"""A brain that has the required methods only is answered for."""

import math

import numpy as np
import pytest

from swarm_common.model.beacon import BEACON_DTYPE, reception_of
from swarm_common.model.records import Odometry, Pose, Twist
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.behaviour.plain import plain_beacon
from swarm_nav.behaviour.plugin_brain import PluginBrain, make_brain
from swarm_nav.core.config import NavConfig, config_from_parameters
from swarm_nav.core.goals import ErrorCode, Goal, GoalEnded, GoalKind, Outcome, Output, StateChanged
from tests.fakes.navigation import room, waffle

ROOM = room(6.0, 4.0, (2.8, 0.0, 3.2, 1.2))
HERE = Pose(1.0, 1.0, 0.0)
THERE = Pose(5.0, 1.0, 0.0)


class Bold:
    """Drives ahead until it is told that it is there."""

    made: "Bold"

    def __init__(self, config, spec, grid, sites, robot_id, initial_pose_map):
        Bold.made = self
        self.spec, self.robot_id = spec, robot_id
        self.goals: list[Goal] = []
        self.events: list[GoalEnded | StateChanged] = []

    def on_odom(self, odom):
        pass

    on_reception = on_odom

    def set_goal(self, goal):
        self.goals.append(goal)

    def tick(self, tick):
        events, self.events = tuple(self.events), []
        beacon = plain_beacon(self.robot_id, tick, self.spec, HERE, Twist(), is_driving=True)
        return Output(Twist(0.2), beacon, events)


class Complete:
    """Has everything that ours has."""

    def __init__(self, *arguments):
        self._navigator = Navigator(*arguments)

    def __getattr__(self, name):
        owner = self._navigator if hasattr(self._navigator, name) else self._navigator.services
        return getattr(owner, name)


def adapter(name="Bold"):
    config = config_from_parameters({"brain.plugin": f"{__name__}:{name}"})
    made = make_brain(config, waffle(), ROOM, Sites(), 2, HERE)
    assert isinstance(made, PluginBrain)
    made.on_odom(Odometry(0, Pose(0.0, 0.0, 0.0), Twist()))
    made.on_reception(reception_of(np.zeros(0, BEACON_DTYPE)))
    return made


def ended(output):
    return [(e.goal_id, e.outcome) for e in output.events if isinstance(e, GoalEnded)]


def go(goal_id, kind=GoalKind.NAVIGATE):
    return Goal(kind=kind, goal_id=goal_id, poses_map=(THERE,))


def test_without_a_plug_in_the_brain_is_ours_and_what_one_has_itself_counts():
    assert type(make_brain(NavConfig(), waffle(), ROOM, Sites(), 1, HERE)) is Navigator
    made = adapter("Complete")
    made.set_goal(Goal(kind=GoalKind.WAIT, goal_id=4, duration=60.0))
    assert made.goal_id == 4
    made.tick(1)
    assert made.status().state == "pausing"
    assert made.global_costmap().cells.max() > 0
    made.on_speed_limit(50.0, is_percentage=True)
    made.cancel_goal()
    assert ended(made.tick(2)) == [(4, Outcome.CANCELED)]
    assert made.tick(3).twist == Twist()


def test_a_goal_ends_once():
    made = adapter()
    assert made.goal_id is None
    assert made.feedback() is None
    made.set_goal(go(7))
    assert made.goal_id == 7
    assert made.feedback().distance_remaining == 4.0
    assert made.status().state == "driving"
    end = GoalEnded(7, Outcome.SUCCEEDED, 1)
    Bold.made.events += [GoalEnded(6, Outcome.SUCCEEDED, 1), end, end]
    assert ended(made.tick(1)) == [(7, Outcome.SUCCEEDED)]
    assert made.goal_id is None
    status = made.status()
    assert (status.state, status.goals_reached, status.goals_failed) == ("idle", 1, 0)


def test_a_goal_preempts_the_one_before_and_can_be_canceled():
    made = adapter()
    made.set_goal(go(1))
    made.set_goal(go(2))
    assert ended(made.tick(1)) == [(1, Outcome.CANCELED)]
    made.cancel_goal()
    made.cancel_goal()
    assert ended(made.tick(2)) == [(2, Outcome.CANCELED)]
    assert Bold.made.goals[-1].poses_map == (HERE,), "without cancel_goal it is to stay"
    Bold.made.events.append(GoalEnded(0, Outcome.SUCCEEDED, 3))
    assert ended(made.tick(3)) == []


def test_other_goals_are_refused_and_it_stands_while_it_is_not_active():
    made = adapter()
    made.set_goal(go(3, GoalKind.SPIN))
    (end,) = made.tick(1).events
    assert isinstance(end, GoalEnded)
    assert end.error_code is ErrorCode.CONTROL_UNKNOWN
    assert "does not know goals of spin" in end.message
    assert not Bold.made.goals
    made = adapter()
    assert made.tick(1).twist == Twist(0.2)
    made.set_goal(go(1))
    made.deactivate()
    output = made.tick(2)
    assert output.twist == Twist()
    assert ended(output) == [(1, Outcome.CANCELED)]
    made.activate()
    assert made.tick(3).twist == Twist(0.2)


def test_what_the_node_asks_beside_that_has_an_answer():
    made = adapter()
    assert made.pose_map == made.map_from_odom == HERE
    made.on_initial_pose(Pose(1.5, 1.0, 0.0))
    assert made.pose_map.x == 1.5
    assert len(made.variances()) == 3
    assert made.particles().shape == (1, 3)
    path = made.make_plan(None, [THERE])
    assert math.dist(path[-1], (THERE.x, THERE.y)) < 1e-6
    assert made.is_clear(made.smooth(path))
    assert made.global_costmap().cells.shape == made.local_costmap().cells.shape
    assert made.global_costmap().cells.max() == 254
    assert made.plan_map().shape == made.local_plan_map().shape == (0, 2)
    assert not made.is_pausing
    made.load_map(room(8.0, 8.0))
    assert made.global_costmap().cells.shape == (160, 160)
    made.steer(Twist(0.1))
    made.end_teleop()
    made.clear_costmap()
    made.clear_square(HERE, 1.0, False)
    made.on_speed_limit(0.1, is_percentage=False)
    made.reconfigure(NavConfig())


@pytest.mark.parametrize("method", ["on_odom", "set_goal", "status"])
def test_a_method_that_raises_costs_the_goal(method, monkeypatch):
    def fail(*_):
        raise ValueError("out of order")

    made = adapter()
    monkeypatch.setattr(Bold, method, fail, raising=False)
    made.set_goal(go(5))
    made.on_odom(Odometry(1, Pose(0.0, 0.0, 0.0), Twist()))
    made.status()
    output = made.tick(1)
    assert ended(output) == [(5, Outcome.ABORTED)]
    assert output.twist == Twist()
