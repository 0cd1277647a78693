"""Other robots and obstacles as costs of the search lattice."""

import numpy as np
import pytest

from swarm_common.model.beacon import FLAG_ACTIVE, FLAG_STUCK, MODE_PAUSE, MODE_YIELD
from swarm_common.model.records import Pose
from swarm_nav.planning.search_kernels import WALL
from swarm_nav.traffic import traffic_costs
from tests.fakes.navigation import beacon, hear, let_walk, robot_in, room

HALL = room(8.0, 8.0)
THERE = (5.0, 4.0)


def robot(*others):
    s = robot_in(HALL, Pose(2.0, 4.0, 0.0))
    hear(s, *others)
    return s


def cost_at(s, costs, x, y):
    node = s.planner.lattice.node_of(x, y)
    assert node is not None
    return float(costs.ravel()[node])


@pytest.mark.parametrize(
    ("fields", "cost"),
    [
        ({}, traffic_costs.STANDING),
        ({"twist": (0.2, 0.0)}, traffic_costs.PASSING),
        ({"twist": (0.2, 0.0), "mode": MODE_YIELD}, traffic_costs.PASSING),
        ({"flags": FLAG_ACTIVE | FLAG_STUCK}, traffic_costs.BARRED),
    ],
)
def test_a_robot_costs_by_what_it_does(fields, cost):
    s = robot(beacon(7, *THERE, **fields))
    costs = traffic_costs.congestion(s)
    assert cost_at(s, costs, *THERE) == pytest.approx(cost)
    assert cost_at(s, costs, 6.5, 6.5) == 0.0


@pytest.mark.parametrize(("mode", "is_wall"), [(MODE_PAUSE, True), (MODE_YIELD, False)])
def test_a_robot_that_is_served_is_a_wall_for_who_makes_way(mode, is_wall):
    s = robot(beacon(7, *THERE, mode=mode))
    costs = traffic_costs.refuge_costs(s, np.zeros(1, np.bool_), 0.0)
    assert (cost_at(s, costs, *THERE) >= WALL) == is_wall


def test_a_robot_costs_as_far_as_its_tubes_and_requests_reach():
    s = robot(beacon(7, *THERE))
    costs = traffic_costs.congestion(s)
    reach = s.reach(0)
    assert cost_at(s, costs, THERE[0] + reach - 0.1, THERE[1]) > 0.0
    assert cost_at(s, costs, THERE[0] + reach + 0.1, THERE[1]) == 0.0
    way = [(5.0, 4.0 + 0.1 * k) for k in range(1, 8)]
    s = robot(beacon(7, *THERE, wanted=way))
    assert cost_at(s, traffic_costs.congestion(s), 5.0, 5.0) == 0.0
    gone = robot_in(HALL, Pose(2.0, 4.0, 0.0))
    hear(gone, beacon(7, *THERE, wanted=way), tick=50)
    assert gone.neighbors.gone.all()
    assert cost_at(gone, traffic_costs.congestion(gone), 5.0, 5.0) > 0.0


def test_what_the_lidar_sees_and_where_somebody_walked_costs():
    s = robot(beacon(7, *THERE))
    s.obstacles.points = np.array((THERE,))
    assert cost_at(s, traffic_costs.congestion(s), *THERE) == traffic_costs.BARRED
    s = robot()
    let_walk(s, THERE)
    costs = traffic_costs.congestion(s)
    assert cost_at(s, costs, THERE[0] + 0.3, THERE[1]) == traffic_costs.PASSING
    assert cost_at(s, costs, 6.5, 6.5) == 0.0


@pytest.mark.parametrize(
    ("priority", "flags", "is_wall"),
    [(9, FLAG_ACTIVE, True), (8, FLAG_ACTIVE, False), (8, FLAG_ACTIVE | FLAG_STUCK, True)],
)
def test_who_makes_way_pushes_lower_robots_only(priority, flags, is_wall):
    s = robot(beacon(7, *THERE, priority=priority, flags=flags))
    costs = traffic_costs.refuge_costs(s, s.neighbors.priorities >= 9, 0.0)
    assert cost_at(s, costs, *THERE) == pytest.approx(WALL if is_wall else traffic_costs.STANDING)
