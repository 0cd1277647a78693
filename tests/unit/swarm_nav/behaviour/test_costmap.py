"""Costmaps on Nav2's scale."""

import math

import numpy as np
import pytest

from swarm_common.model.grid import UNKNOWN, Grid
from swarm_common.model.records import Pose
from swarm_nav.behaviour import costmap as costmaps
from tests.fakes.navigation import beacon, hear, robot_in, room

HALL = room(6.0, 6.0)
MIDDLE = Pose(3.0, 3.0, 0.0)
INSCRIBED_RADIUS = 0.069


def inflated(resolution=0.05):
    lethal = np.zeros((41, 41), np.bool_)
    lethal[20, 20] = True
    return costmaps.inflate(lethal, resolution, 0.1, 0.55, 3.0)


@pytest.mark.parametrize("cells", range(0, 14))
def test_inflation_follows_nav2s_formula(cells):
    distance = 0.05 * cells
    cost = int(inflated()[20, 20 + cells])
    if cells == 0:
        assert cost == costmaps.LETHAL == 254
    elif distance <= 0.1:
        assert cost == costmaps.INSCRIBED == 253
    elif distance <= 0.55 + 1e-9:
        assert cost == int(252 * math.exp(-3.0 * (distance - 0.1)))
    else:
        assert cost == costmaps.FREE == 0


def test_inflation_is_the_same_in_all_directions_and_none_without_lethal_cells():
    costs = inflated()
    assert np.array_equal(costs, costs.T)
    assert np.array_equal(costs, costs[::-1])
    assert not costmaps.inflate(np.zeros((4, 4), np.bool_), 0.05, 0.1, 0.55, 3.0).any()


def test_the_global_costmap_has_walls_obstacles_and_neighbours():
    s = robot_in(HALL, MIDDLE)
    s.obstacles.points = np.array(((2.025, 2.025),))
    hear(s, beacon(2, 4.0, 3.0, held=[(4.0, 3.0), (4.05, 3.0)]))
    costs = costmaps.compose(s, INSCRIBED_RADIUS, None)
    assert costs.cells.shape == (HALL.height, HALL.width)
    assert (costs.resolution, costs.origin_x, costs.origin_y) == (0.05, 0.0, 0.0)

    def cost(x, y):
        row, column = HALL.cell_of(x, y)
        return int(costs.cells[row, column])

    assert cost(0.02, 3.0) == costmaps.LETHAL
    assert cost(2.025, 2.025) == costmaps.LETHAL
    assert cost(4.0, 3.25) == costmaps.LETHAL
    assert cost(4.3, 3.0) == costmaps.LETHAL
    assert 0 < cost(4.0, 3.45) < costmaps.INSCRIBED
    assert cost(1.0, 5.0) == costmaps.FREE


def test_the_local_costmap_rolls_and_unknown_cells_stay_unknown():
    s = robot_in(HALL, Pose(1.0, 3.0, 0.0))
    local = costmaps.compose(s, INSCRIBED_RADIUS, 3.0)
    assert local.cells.shape == (60, 60)
    assert local.origin_x == pytest.approx(-0.5, abs=0.051)
    assert local.origin_y == pytest.approx(1.5, abs=0.051)
    assert (local.cells[:, :5] == costmaps.NO_INFORMATION).all()
    assert (local.cells[30, 9:12] >= costmaps.INSCRIBED).any()
    cells = HALL.cells.copy()
    cells[60:80, 60:80] = UNKNOWN
    s = robot_in(Grid(cells, 0.05, 0.0, 0.0), MIDDLE)
    costs = costmaps.compose(s, INSCRIBED_RADIUS, None).cells
    assert (costs[60:80, 60:80] == costmaps.NO_INFORMATION).all()
