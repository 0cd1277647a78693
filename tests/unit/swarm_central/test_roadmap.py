"""The roadmap of a centre has the costs that its robots' planner has."""

import dataclasses

import numpy as np
import pytest

from swarm_central.roadmap import EAST, NORTH, Timing, build_roadmap
from swarm_common.model.grid import Grid
from swarm_nav.core.config import CostmapConfig, PlannerConfig
from swarm_nav.planning.terrain import KEEPOUT_COST, Terrain

TIMING = Timing(1.0, 2.0, 1.0)


def roadmap_of(grid):
    terrain = Terrain(grid, PlannerConfig(), CostmapConfig(), 0.2)
    return build_roadmap(terrain, 0.5, 0.25, TIMING, 0.25, np.zeros((0, 2)), 0.2)


def test_learned_lanes_cost_a_centre_what_they_cost_our_robots():
    cells = np.zeros((120, 120), np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = 100
    plain = Grid(cells, 0.05, 0.0, 0.0)
    lanes = np.zeros_like(cells)
    lanes[:, 60:] = 50  # the eastern half is dear
    learned = dataclasses.replace(plain, keepout=lanes)
    before, after = roadmap_of(plain), roadmap_of(learned)
    assert (before.points == after.points).all()
    change = (after.costs.edges - before.costs.edges) / 2.0  # 2 s of free driving
    ways = before.costs.neighbors >= 0
    west, east = before.points[:, 0] < 2.4, before.points[:, 0] > 3.1
    expected = 50 * KEEPOUT_COST / 99
    assert change[east & ways[:, NORTH], NORTH] == pytest.approx(expected, rel=1e-4)
    assert change[west & ways[:, EAST], EAST] == pytest.approx(0.0)
