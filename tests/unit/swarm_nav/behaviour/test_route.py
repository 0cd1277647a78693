"""The route: when a plan is due, and where it starts."""

import numpy as np
import pytest

from swarm_common.model.records import Pose, Twist
from swarm_nav.behaviour.goal_manager import GoalManager
from swarm_nav.behaviour.route import BARRED_PATIENCE, BARRED_RADIUS, BARRED_TIME, Route
from swarm_nav.behaviour.state_machine import StateMachine
from swarm_nav.core.goals import ErrorCode, Goal, GoalEnded, GoalKind
from swarm_nav.core.states import State
from swarm_nav.traffic.holding import HoldingPattern
from swarm_nav.traffic.lease import Lease
from swarm_nav.traffic.right_of_way import RightOfWay
from tests.fakes.decisions import arbiter_of, drive
from tests.fakes.navigation import beacon, hear, robot_in, room

HALL = room(8.0, 8.0)
QUIET = 101  # a tick that is not the robot's turn of periodic plans


def driving(x=6.0):
    """Return a robot at x = 2 m with a fresh plan to a goal."""
    s = robot_in(HALL, Pose(2.0, 4.0, 0.0))
    state_machine = StateMachine(s, HoldingPattern({}, []), arbiter_of(s))
    goal_manager = GoalManager(s, state_machine, Lease(), RightOfWay(), arbiter_of(s))
    goal_manager.set_goal(Goal(kind=GoalKind.NAVIGATE, poses_map=(Pose(x, 4.0, 0.0),)))
    goal_manager.begin_pending()
    assert state_machine.state is State.DRIVING
    assert goal_manager.task is not None
    route = Route(s)
    s.tick = QUIET
    drive(route, s, goal_manager)
    return s, route, goal_manager


def replans(s, route, manager, since):
    route.last_plan_tick = s.tick - since
    drive(route, s, manager)
    return route.last_plan_tick == s.tick


def test_a_goal_without_a_way_or_off_the_map_ends_without_a_recovery():
    s = robot_in(room(8.0, 8.0, (4.0, 0.0, 4.15, 8.0)), Pose(2.0, 4.0, 0.0))
    state_machine = StateMachine(s, HoldingPattern({}, []), arbiter_of(s))
    goal_manager = GoalManager(s, state_machine, Lease(), RightOfWay(), arbiter_of(s))
    goal_manager.set_goal(Goal(kind=GoalKind.NAVIGATE, poses_map=(Pose(6.0, 4.0, 0.0),)))
    goal_manager.begin_pending()
    assert goal_manager.task is not None
    drive(Route(s), s, goal_manager)
    (end,) = [event for event in state_machine.pop_events() if isinstance(event, GoalEnded)]
    assert (end.error_code, s.counters.recoveries) == (ErrorCode.NO_VALID_PATH, 0)
    assert "to (6.00, 4.00): every way is closed by walls on this map" in end.message
    _, _, manager = driving(50.0)
    events = manager._state_machine.pop_events()
    ends = [event for event in events if isinstance(event, GoalEnded)]
    assert [end.error_code for end in ends] == [ErrorCode.GOAL_OUTSIDE_MAP]


def test_the_first_plan_is_kept_where_robots_live_or_the_way_is_open():
    s, _, manager = driving()
    assert manager.task.is_planned
    assert np.allclose(s.tube.points[[0, -1]], ((2.0, 4.0), (6.0, 4.0)))
    assert s.counters.replans == 0
    assert not replans(*driving(), since=18)
    s, route, manager = driving()
    hear(s, beacon(7, 4.0, 1.0))
    s.blocked_ticks, s.blocked_by = s.ticks(BARRED_PATIENCE), 7
    replans(s, route, manager, since=s.retry_ticks)
    assert aside(s) < 0.1


@pytest.mark.parametrize("reason", ["robot", "obstacle", "end"])
def test_a_plan_that_leads_nowhere_is_renewed_after_a_pause(reason):
    s, route, manager = driving()
    s.blocked_ticks = s.retry_ticks if reason == "robot" else 0
    s.obstacle_ticks = s.retry_ticks if reason == "obstacle" else 0
    if reason == "end":
        s.tube.cut()
    pause = s.retry_ticks
    assert not replans(s, route, manager, since=pause - 1)
    assert replans(s, route, manager, since=pause)
    assert s.counters.replans == (reason == "end")  # the others keep a path that is as good


@pytest.mark.parametrize("reason", ["obstacle", "silent robot"])
def test_who_waits_in_vain_tries_another_way_and_forgets_after_a_while(reason):
    s, route, manager = driving()
    patience, pause = s.ticks(BARRED_PATIENCE), s.retry_ticks
    if reason == "obstacle":
        s.obstacle_ticks = patience
    else:
        hear(s, beacon(7, 4.0, 1.0), tick=s.tick - 17)
        assert s.neighbors.immovable.all()
        s.blocked_ticks, s.blocked_by = patience, 7
    assert aside(s) < 0.1
    replans(s, route, manager, since=pause)
    assert aside(s) > BARRED_RADIUS - s.planner.lattice.step
    s.obstacle_ticks = s.blocked_ticks = 0
    s.tick += s.ticks(BARRED_TIME)
    manager.replan()
    drive(route, s, manager)
    assert aside(s) < 0.1


def aside(s):
    """Return how far [m] the path leads off the line from start to goal."""
    return float(np.abs(s.tube.points[:, 1] - 4.0).max())


def test_robots_take_turns_with_periodic_plans():
    s, route, manager = driving()
    period = s.ticks(s.config.planner.replan_period)
    turns = []
    for _ in range(3 * period):
        s.tick += 1
        if replans(s, route, manager, since=period):
            turns.append(s.tick)
    assert len(turns) == 3
    assert all((turn + 7 * s.robot_id) % period == 0 for turn in turns)


def test_a_plan_back_along_held_space_starts_where_the_robot_can_stop():
    s, route, manager = driving(1.0)
    s.tube.reset(s.pose)
    s.tube.adopt(np.column_stack((np.arange(2.0, 4.0, 0.05), np.full(40, 4.0))))
    s.tube.stop, s.twist = 30, Twist(0.26)
    manager.replan()
    drive(route, s, manager)
    assert s.tube.stop == s.brake_points
    assert np.allclose(s.tube.points[-1], (1.0, 4.0))
