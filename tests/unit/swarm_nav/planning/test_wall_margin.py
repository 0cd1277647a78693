"""Every way keeps the nodes' margin from walls: smooth or plain, also where nodes are taken."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from swarm_common.model.grid import OCCUPIED
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import PlanError
from swarm_nav.planning.planner import Planner
from swarm_nav.planning.search_kernels import WALL
from swarm_nav.planning.terrain import NODE_MARGIN, terrain_for
from tests.fakes.navigation import room, waffle

ROUNDING = 0.0025  # [m] of interpolated distances, and of chords between points of a way
WIDTH, HEIGHT = 5.0, 4.0

boxes = st.lists(
    st.tuples(st.floats(0.5, 4.0), st.floats(0.5, 3.0), st.floats(0.05, 1.5), st.floats(0.05, 1.5)),
    min_size=1,
    max_size=5,
)
inside = st.tuples(st.floats(0.4, WIDTH - 0.4), st.floats(0.4, HEIGHT - 0.4))
beside = st.tuples(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8))


def wall_distances(planner, path):
    """Return the exact distance of each point (n, 2) to the nearest occupied square."""
    grid = planner.terrain.grid
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    x = grid.origin_x + (columns + 0.5) * grid.resolution
    y = grid.origin_y + (rows + 0.5) * grid.resolution
    half = grid.resolution / 2
    return np.array(
        [
            np.hypot(
                np.maximum(np.abs(x - px) - half, 0.0), np.maximum(np.abs(y - py) - half, 0.0)
            ).min()
            for px, py in path
        ]
    )


def offset(distance, angle):
    return distance * math.cos(angle), distance * math.sin(angle)


def dense(path):
    k = np.arange(0.0, len(path) - 1 + 1e-9, 0.1)
    return np.column_stack([np.interp(k, np.arange(len(path)), path[:, a]) for a in (0, 1)])


def check(walls, start, goal, others, is_smooth):
    grid = room(WIDTH, HEIGHT, *((x, y, x + w, y + h) for x, y, w, h in walls))
    parameters = NavConfig()
    body = waffle().circumscribed_radius
    terrain = terrain_for(grid, parameters.planner, parameters.costmap, body)
    planner = Planner(terrain, parameters.planner)
    floor = body + NODE_MARGIN
    ends = wall_distances(planner, np.array((start, goal)))
    if ends.min() < floor:
        return
    extra = planner.no_extra()
    rows, columns = np.indices(extra.shape)
    x = planner.lattice.origin_x + (columns + 0.5) * planner.lattice.step
    y = planner.lattice.origin_y + (rows + 0.5) * planner.lattice.step
    for dx, dy in others:
        extra[np.hypot(x - start[0] - dx, y - start[1] - dy) < 0.57] = WALL
    if is_smooth:
        try:
            path = planner.plan(start, goal, extra)
        except PlanError:
            return
    else:
        places = (np.hypot(x - goal[0], y - goal[1]) < 0.3).astype(np.uint8)
        found = planner.nearest(start, extra, places, 30.0, smooth=False)
        if found is None:
            return
        path = found
    assert wall_distances(planner, dense(path)).min() > floor - ROUNDING


@pytest.mark.parametrize("is_smooth", [False, True])
@pytest.mark.parametrize("count", [20, pytest.param(2000, marks=pytest.mark.long)])
def test_a_way_keeps_the_margin_of_the_nodes(is_smooth, count):
    @settings(max_examples=count, deadline=None)
    @given(boxes, inside, inside, st.lists(beside, max_size=3))
    def keeps(walls, start, goal, others):
        check(walls, start, goal, others, is_smooth)

    keeps()


@settings(max_examples=40, deadline=None)
@given(
    st.tuples(st.floats(1.5, 3.0), st.floats(1.5, 3.0), st.floats(0.1, 1.0), st.floats(0.1, 1.0)),
    st.tuples(st.floats(0.28, 0.4), st.floats(0.9 * math.pi, 1.6 * math.pi)),
    inside,
    st.lists(st.tuples(st.floats(0.2, 0.6), st.floats(0.0, 2.0 * math.pi)), min_size=1, max_size=2),
)
@example(
    (1.67, 1.73, 0.45, 0.26), (0.34, 3.04), (3.15, 2.91), [(0.41, 1.7)]
)  # 0.256 m from the corner when the way began at its second node
def test_a_robot_beside_a_corner_whose_nodes_are_taken_does_not_cut_it(
    box, from_corner, goal, others
):
    start = np.array(box[:2]) + offset(*from_corner)
    check([box], (float(start[0]), float(start[1])), goal, [offset(*o) for o in others], False)
