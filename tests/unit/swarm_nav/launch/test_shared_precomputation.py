"""What is worked out before the fork is what each robot would work out."""

import numpy as np
import pytest

from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_common.model.zones import KeepoutZone, Zones
from swarm_describe.robots.loading import load_robot
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_nav.launch import shared_precomputation
from swarm_nav.launch.shared_precomputation import MANY_PROCESSES, prepare
from swarm_nav.planning import terrain as terrain_module
from swarm_nav.planning.terrain import Terrain
from swarm_nav.ros.settings import FIXED, NodeSettings
from swarm_nav.traffic.gate import narrow_region
from swarm_nav.traffic.robot_state import initial_state, terrain_of
from swarm_nav.traffic.single_lanes import single_lanes

STATIONS = {"a": Pose(1.5, 2.0, 0.5), "b": Pose(7.0, 2.0, -3.0), "outside": Pose(-5.0, 0.0, 0.0)}


@pytest.fixture
def grid():
    cells = np.zeros((80, 190), np.int8)
    cells[0, :] = cells[-1, :] = cells[:, 0] = cells[:, -1] = OCCUPIED
    cells[20:40, 60:70] = OCCUPIED
    return Grid(cells, 0.05, 0.0, 0.0)


@pytest.fixture
def robots(monkeypatch):
    monkeypatch.setattr(NodeSettings, "sites", Sites(stations=STATIONS))
    spec = load_robot("turtlebot3_waffle")
    names = ["Srobot1", "Srobot2", "Srobot3"]
    return [NodeSettings(n, NavConfig(), spec, FIXED | {"robot_id": int(n[-1])}) for n in names]


def plans(robot, grid):
    robot_in = initial_state(robot.config, robot.spec, grid, 1, STATIONS["a"])
    planner = robot_in.planner
    ways = [
        planner.plan((4.5, 3.0), (pose.x, pose.y), planner.no_extra(), pose.yaw)
        for pose in list(STATIONS.values())[:2]
    ]
    return [way.tobytes() for way in ways]


def test_ways_are_found_once_and_are_the_same(grid, robots):
    terrain = terrain_of(robots[0].config, robots[0].spec, grid)
    alone = Terrain(grid, robots[0].config.planner, robots[0].config.costmap, terrain.radius)
    fresh = initial_state(robots[0].config, robots[0].spec, grid, 1, STATIONS["a"]).planner
    fresh.terrain = alone
    fields = [fresh.cost_to_go((p.x, p.y), p.yaw) for p in list(STATIONS.values())[:2]]
    expected = plans(robots[0], grid)
    terrain._cost_to_go.cache_clear()

    prepare(robots, grid, MANY_PROCESSES)
    assert terrain._cost_to_go.cache_info().misses == 2
    assert plans(robots[2], grid) == expected
    planner = initial_state(robots[0].config, robots[0].spec, grid, 1, STATIONS["a"]).planner
    for field, pose in zip(fields, STATIONS.values(), strict=False):
        assert planner.cost_to_go((pose.x, pose.y), pose.yaw).tobytes() == field.tobytes()
    assert planner.terrain is terrain
    assert terrain._cost_to_go.cache_info().misses == 2, "nobody has had to find them again"


def test_regions_are_found_once(grid, robots):
    prepare(robots, grid, 1)
    known = narrow_region.cache_info().misses, single_lanes.cache_info().misses
    prepare(robots, grid, 1)
    assert (narrow_region.cache_info().misses, single_lanes.cache_info().misses) == known


def test_costs_of_many_stations_are_not_all_kept(grid, robots, monkeypatch):
    terrain = terrain_of(robots[0].config, robots[0].spec, grid)
    monkeypatch.setattr(terrain, "most_goals", 2)
    terrain._cost_to_go.cache_clear()
    shared_precomputation.prepare(robots, grid, MANY_PROCESSES)
    assert terrain._cost_to_go.cache_info().misses == 1


def test_conditions_are_those_of_the_goals_that_are_known(grid, robots, monkeypatch):
    cells = grid.cells.copy()
    cells[30:34, 80:] = OCCUPIED  # a blind aisle for one robot along the lower wall
    cells[:14, 80:] = OCCUPIED
    aisle = Grid(cells, grid.resolution, grid.origin_x, grid.origin_y)
    assert "single lanes" not in str(prepare(robots, aisle, 1))
    inside = {robot.name: [(8.5, 1.1)] for robot in robots}
    found = prepare(robots, aisle, 1, inside)
    assert "3 have goals there" in str(found)
    alone = prepare(robots, aisle, 1, inside | {"Srobot2": [], "Srobot3": []})
    outside = "no room for the robot at the goal (-5.00, 0.00)"  # a station: these may go there
    assert alone.findings == (outside,)


def test_keepout_zones_are_on_the_shared_map(grid, robots, monkeypatch):
    """The navigators' own terrain is the one that was made before the fork."""
    zone = KeepoutZone("across", ((4.0, 0.0), (4.4, 0.0), (4.4, 4.0), (4.0, 4.0)))
    sites = Sites(stations=STATIONS, zones=Zones(keepout=(zone,)))
    monkeypatch.setattr(NodeSettings, "sites", sites)
    monkeypatch.setattr(NodeSettings, "initial_pose_map", STATIONS["a"])
    found = prepare(robots, grid, 1, {robot.name: [(7.0, 2.0)] for robot in robots})
    assert "no way to the goal (7.00, 2.00)" in str(found)
    made = terrain_module._shared.cache_info().misses
    robot = robots[0]
    Navigator(robot.config, robot.spec, grid, sites, 1, robot.initial_pose_map)
    assert terrain_module._shared.cache_info().misses == made
