"""Lanes, parking places and clearances that follow from a map alone."""

import math

import numpy as np
import pytest

from swarm_common.files.map_io import load_map, map_path
from swarm_common.files.sites_io import load_sites
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_describe.worlds.world_file import find_world
from swarm_nav.core.config import NavConfig
from swarm_nav.planning.planner import Planner
from swarm_nav.planning.search_kernels import WALL
from swarm_nav.planning.terrain import Terrain, terrain_for
from tests.fakes.navigation import config, room, waffle


def terrain(grid):
    parameters = NavConfig()
    body = waffle().circumscribed_radius
    return terrain_for(grid, parameters.planner, parameters.costmap, body)


def plan(grid, start, goal):
    parameters = NavConfig()
    planner = Planner(terrain(grid), parameters.planner)
    return planner.plan(start, goal, planner.no_extra())


def test_the_clearance_ends_at_the_face_of_a_wall_and_nodes_where_the_robot_does_not_fit():
    here = terrain(room(6.0, 4.0))
    assert here.clearance(1.025, 2.025) == pytest.approx(0.975, abs=0.011)
    assert here.clearance(3.0, 0.02) == pytest.approx(0.0, abs=0.011)
    lattice = terrain(room(6.0, 4.0)).lattice
    closed = lattice.base >= WALL
    assert (lattice.clearance[closed] < 0.238 + 0.036).all()
    assert (lattice.clearance[~closed] >= 0.238 + 0.034).all()
    assert terrain(room(3.0, 3.0)) is terrain(room(3.0, 3.0))
    assert terrain(room(3.0, 3.0)) is not terrain(room(3.0, 3.1))


def test_lanes_keep_right_in_corridors_and_around_islands():
    corridor = room(12.0, 1.8)
    middle = slice(40, -40)
    east = plan(corridor, (0.6, 0.9), (11.4, 0.9))[middle]
    west = plan(corridor, (11.4, 0.9), (0.6, 0.9))[middle]
    assert east[:, 1].max() < 0.9 - 0.25
    assert west[:, 1].min() > 0.9 + 0.25
    assert west[:, 1].min() - east[:, 1].max() > 2 * 0.285  # two robots pass
    path = plan(room(8.0, 8.0, (3.0, 3.0, 5.0, 5.0)), (1.5, 4.0), (6.5, 4.0))
    middle = path[np.abs(path[:, 0] - 4.0) < 0.5, 1]
    if middle[0] > 4.0:  # clockwise, with the island on the right
        assert middle.max() < 6.5
    else:
        assert middle.max() < 1.5


def slanted_corridor(angle):
    """Return a corridor 2.2 m wide and 12 m long at an angle, through (7, 7)."""
    rows, columns = np.indices((280, 280))
    x, y = (columns + 0.5) * 0.05 - 7.0, (rows + 0.5) * 0.05 - 7.0
    along = x * math.cos(angle) + y * math.sin(angle)
    across = -x * math.sin(angle) + y * math.cos(angle)
    is_free = (np.abs(across) < 1.1) & (np.abs(along) < 6.0)
    return Grid(np.where(is_free, 0, OCCUPIED).astype(np.int8), 0.05, 0.0, 0.0)


@pytest.mark.parametrize("degrees", [17, 30, 45, 110])
def test_lanes_follow_a_slanted_wall(degrees):
    angle = math.radians(degrees)
    grid = slanted_corridor(angle)
    direction = np.array((math.cos(angle), math.sin(angle)))
    left = np.array((-direction[1], direction[0]))
    ends = [tuple(7.0 + s * 5.0 * direction) for s in (-1, 1)]
    for start, goal, side in ((ends[0], ends[1], -1), (ends[1], ends[0], 1)):
        path = plan(grid, start, goal)[30:-30]
        offset = (path - 7.0) @ left
        assert (side * offset).min() > 0.2


def test_lanes_are_where_two_robots_do_not_fit():
    lattice = terrain(room(12.0, 12.0)).lattice
    middle = (slice(50, 70), slice(50, 70))
    assert not lattice.lane[middle].any()
    assert (lattice.base[middle] == 1.0).all()
    grid = room(12.0, 1.8)
    body = waffle().circumscribed_radius
    light, heavy = (
        Terrain(grid, c.planner, c.costmap, body).lattice.lane.max()
        for c in (config(planner__lane_weight=1.0), config(planner__lane_weight=6.0))
    )
    assert heavy == pytest.approx(6.0 * light)


def test_robots_park_in_halls_and_on_wide_median_strips_only():
    hall = terrain(room(12.0, 12.0)).lattice
    assert hall.parking[60, 60] == 1
    assert hall.parking[60, 8] == 0
    corridor = terrain(room(12.0, 1.8)).lattice
    assert not corridor.parking.any()
    aisle = terrain(room(12.0, 3.1)).lattice
    parked = np.flatnonzero(aisle.parking[:, 60]) * 0.1
    assert len(parked) > 0
    assert np.abs(parked - 1.5).max() < 0.3


def test_every_station_of_the_factory_hall_is_reached_from_every_other():
    grid = load_map(map_path("slim_blockage"))
    sites = load_sites(find_world("slim_blockage", "sites.yaml"))
    stations = list(sites.stations.values())
    here = terrain(grid)
    for goal in stations:
        node = here.lattice.node_of(goal.x, goal.y)
        assert node is not None
        cost = here.cost_to_go(node)
        for start in stations:
            row, column = divmod(here.lattice.node_of(start.x, start.y) or 0, cost.shape[1])
            assert np.isfinite(cost[row, column])


def test_costs_of_driving_look_at_each_node_about_once_however_large_the_hall():
    """Beyond 64 m rounding made nodes cheaper than themselves: up to 40 s in a hall of 130 m."""
    racks = [(x, y, x + 12.0, y + 1.2) for x in range(9, 60, 16) for y in range(6, 89, 4)]
    here = terrain(room(130.0, 95.0, *racks))
    node = here.lattice.node_of(1.5, 2.0)
    assert node is not None
    costs, taken = here.search._costs_and_effort(node)
    reached = int(np.isfinite(costs).sum())
    assert costs[np.isfinite(costs)].max() > 128.0
    assert reached <= taken < 1.01 * reached


def test_costs_that_somebody_holds_are_not_worked_out_again():
    """A hundred robots in a large hall worked them out for each other, in turn."""
    here = terrain(room(5.0, 5.0))
    node = here.lattice.node_of(2.5, 2.5)
    assert node is not None
    costs = here.cost_to_go(node)
    here._cost_to_go.cache_clear()  # more goals than are kept
    assert here.cost_to_go(node) is costs
