"""The global planner: shortest ways, walls, tolerance and Nav2's error codes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.grid import UNKNOWN, Grid
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import ErrorCode, PlanError
from swarm_nav.planning.planner import SPACING, Planner, path_length
from swarm_nav.planning.search_kernels import WALL
from swarm_nav.planning.terrain import terrain_for
from tests.fakes.navigation import config, room, waffle

BODY = 0.238
ROOM = room(6.0, 4.0, (2.5, 0.0, 2.65, 2.8))
SPLIT = room(6.0, 4.0, (2.5, 0.0, 2.65, 4.0))


def planner_for(grid, parameters=None):
    parameters = parameters or NavConfig()
    body = waffle().circumscribed_radius
    terrain = terrain_for(grid, parameters.planner, parameters.costmap, body)
    return Planner(terrain, parameters.planner)


def plan(planner, start, goal):
    return planner.plan(start, goal, planner.no_extra())


def test_ways_are_straight_through_points_and_equal_everywhere():
    path = plan(planner_for(room(16.0, 16.0)), (5.0, 8.0), (11.0, 8.6))
    assert path_length(path) == pytest.approx(math.hypot(6.0, 0.6), rel=0.02)
    assert np.allclose(path[[0, -1]], ((5.0, 8.0), (11.0, 8.6)))
    steps = np.hypot(*np.diff(plan(planner_for(ROOM), (1.0, 1.0), (5.0, 1.0)), axis=0).T)
    assert steps.max() < 1.25 * SPACING
    planner = planner_for(room(16.0, 16.0))
    points = [(5.0, 8.0), (9.0, 8.0), (9.0, 12.0)]
    path = planner.plan_through(points)
    assert all((np.hypot(*(path - point).T) < 1e-6).sum() == 1 for point in points)
    assert path_length(path) == pytest.approx(8.0, rel=0.02)
    assert planner.plan_through(points[:1]).shape == (0, 2)
    planner = planner_for(ROOM)
    first = plan(planner, (1.0, 1.0), (5.0, 1.0))
    again = plan(planner_for(ROOM), (1.0, 1.0), (5.0, 1.0))
    assert np.array_equal(first, again)


def test_places_are_free_reachable_and_outside_of_others():
    planner = planner_for(ROOM)
    taken, allowed = planner.no_extra(), np.zeros(planner.lattice.base.shape, np.uint8)
    taken[2, 3:5], allowed[2, 4:6] = 1.0, 2
    assert np.argwhere(planner.free_places(taken, allowed)).tolist() == [[2, 5]]
    assert planner.free_places(taken).sum() == taken.size - 2
    planner = planner_for(ROOM)
    places = np.zeros(planner.lattice.base.shape, np.uint8)
    places[10, 50] = 1
    assert planner.nearest((1.0, 1.0), planner.no_extra(), places, 1.0) is None
    path = planner.nearest((1.0, 1.0), planner.no_extra(), places, 20.0)
    assert np.allclose(path[-1], (5.05, 1.05))
    planner = planner_for(ROOM)
    extra = planner.no_extra()
    row, column = divmod(planner.lattice.node_of(1.0, 1.0) or 0, extra.shape[1])
    extra[row, column] = WALL
    node = planner.lattice.node_of(1.0, 1.0, extra)
    assert node is not None
    assert extra.ravel()[node] == 0.0


def clearances(planner, path):
    return np.array([planner.terrain.clearance(x, y) for x, y in path])


inside = st.tuples(st.floats(0.4, 5.6), st.floats(0.4, 3.6))


@settings(max_examples=40, deadline=None)
@given(inside, inside)
def test_every_path_keeps_the_robot_off_walls(start, goal):
    planner = planner_for(ROOM)
    ends = min(planner.terrain.clearance(*start), planner.terrain.clearance(*goal))
    if ends < BODY + 0.06:
        return
    path = plan(planner, start, goal)
    assert np.allclose(path[[0, -1]], (start, goal), atol=0.011)
    assert clearances(planner, path).min() > BODY + 0.01


@settings(max_examples=30, deadline=None)
@given(inside)
def test_a_goal_near_a_wall_is_moved_by_at_most_the_tolerance(goal):
    planner = planner_for(ROOM)
    path = plan(planner, (1.0, 1.0), goal)
    assert math.dist(path[-1], goal) <= NavConfig().planner.tolerance
    assert planner.terrain.clearance(*path[-1]) > BODY


def test_without_tolerance_a_goal_at_a_wall_is_occupied():
    strict = planner_for(ROOM, config(planner__tolerance=0.05))
    with pytest.raises(PlanError, match=r"no place within 0\.05 m has room .*on this map") as error:
        plan(strict, (1.0, 1.0), (5.0, 0.12))
    assert error.value.code is ErrorCode.GOAL_OCCUPIED


@pytest.mark.parametrize(
    ("start", "goal", "code", "reason"),
    [
        ((1.0, 1.0), (9.0, 1.0), ErrorCode.GOAL_OUTSIDE_MAP, r"goal \(9.00, 1.00\) lies outside"),
        ((-1.0, 1.0), (1.0, 1.0), ErrorCode.START_OUTSIDE_MAP, r"start \(-1.00, 1.00\) lies"),
        ((2.57, 1.0), (1.0, 1.0), ErrorCode.START_OCCUPIED, "the robot does not fit"),
        ((1.0, 1.0), (5.0, 1.0), ErrorCode.NO_VALID_PATH, "closed by walls on this map"),
    ],
)
def test_a_refusal_names_nav2s_code_and_the_reason(start, goal, code, reason):
    with pytest.raises(PlanError, match=reason) as error:
        plan(planner_for(SPLIT), start, goal)
    assert error.value.code is code


def test_a_goal_that_the_map_alone_closes_off_is_final_and_named_as_given():
    planner = planner_for(SPLIT)
    beside = (2.95, 1.0)  # too near to the wall: it is moved
    with pytest.raises(PlanError, match=r"to \(2.95, 1.00\)") as error:
        plan(planner, (1.0, 1.0), beside)
    assert error.value.is_final
    closed = planner.no_extra()
    node = planner.lattice.node_of(1.5, 1.0)
    assert node is not None
    middle = node % closed.shape[1]
    closed[:, middle - 1 : middle + 2] = WALL
    with pytest.raises(PlanError, match="closed by obstacles") as error:
        planner.plan((0.6, 1.0), (2.0, 1.0), closed)
    assert not error.value.is_final


def test_a_robot_in_a_pocket_may_still_recover():
    pocket = room(6.0, 4.0, (1.0, 0.0, 1.15, 1.0), (0.0, 0.95, 1.15, 1.1))
    with pytest.raises(PlanError, match="walls on this map") as error:
        plan(planner_for(pocket), (0.5, 0.5), (4.0, 2.0))
    assert not error.value.is_final


def test_a_goal_deep_in_a_thick_wall_is_occupied():
    planner = planner_for(room(6.0, 4.0, (2.0, 0.0, 4.0, 2.8)))
    with pytest.raises(PlanError) as error:
        plan(planner, (1.0, 1.0), (3.0, 1.0))
    assert error.value.code is ErrorCode.GOAL_OCCUPIED


def test_crowds_and_closed_cells_are_led_around():
    planner = planner_for(room(8.0, 6.0))
    extra = planner.no_extra()
    extra[20:40, 35:45] = 30.0
    path = planner.plan((2.0, 3.0), (6.0, 3.0), extra)
    inside = (np.abs(path - (4.0, 3.0)) < (0.4, 0.9)).all(axis=1)
    assert not inside.any()
    planner = planner_for(ROOM)
    extra = planner.no_extra()
    extra[:, 20:22] = WALL
    with pytest.raises(PlanError, match="every way is closed by obstacles") as error:
        planner.plan((1.0, 1.0), (5.0, 1.0), extra)
    assert error.value.code is ErrorCode.NO_VALID_PATH
    cells = room(6.0, 4.0).cells.copy()
    cells[:, 50:53] = UNKNOWN
    grid = Grid(cells, 0.05, 0.0, 0.0)
    assert len(plan(planner_for(grid), (1.0, 1.0), (5.0, 1.0))) > 2
    with pytest.raises(PlanError):
        plan(planner_for(grid, config(planner__allow_unknown=False)), (1.0, 1.0), (5.0, 1.0))
