"""Where a robot waits for its turn."""

import math

import numpy as np
import pytest

from swarm_common.model.records import Pose
from swarm_nav.core.config import NavConfig
from swarm_nav.traffic.holding import PARKING_DISTANCE, HoldingPattern, parking_path
from tests.fakes.decisions import hold
from tests.fakes.navigation import RADIUS, beacon, config, hear, robot_in, room

HALL = room(12.0, 12.0)
STATION = (6.0, 1.0)
RING = ((3.0, 3.0), (9.0, 3.0), (9.0, 9.0), (3.0, 9.0))
NEAR = Pose(6.0, 2.8, 0.0)


def nowhere():
    """Keep nothing free."""


def pattern(with_circuit=True):
    return HoldingPattern({"ring": RING} if with_circuit else {}, [STATION])


def holding(mode, pose=NEAR, with_circuit=True, *others):
    parameters: NavConfig = config(holding__mode=mode)
    s, here = robot_in(HALL, pose, parameters=parameters), pattern(with_circuit)
    if others:
        hear(s, *others)
    here.enter(s)
    hold(here, s, nowhere)
    return s, here


def test_park_drives_to_a_place_off_lanes_and_stations():
    s, here = holding("park")
    assert not here.is_on_circuit
    assert not here.is_on_circuit
    assert here.target is not None
    assert math.dist(here.target, STATION) >= PARKING_DISTANCE
    assert math.dist(here.target, s.tube.points[-1]) < 1e-9
    node = s.planner.lattice.node_of(*here.target)
    assert node is not None
    assert s.planner.lattice.parking.ravel()[node] == 1


def test_a_parking_place_behind_an_obstacle_is_given_up():
    s, here = holding("park")
    first = here.target
    s.tick, s.obstacle_ticks = s.tick + 100, s.wait_ticks
    hold(here, s, nowhere)
    assert here.target is first
    s.obstacle_ticks += 1
    hold(here, s, nowhere)
    assert here.target is not first


def test_parked_robots_keep_apart_and_auto_joins_the_circuit():
    s = robot_in(HALL, NEAR)
    free = parking_path(s, [STATION])
    goal = tuple(free[-1])
    hear(s, beacon(2, *goal), beacon(3, 1.0, 11.0, target=(goal[0] + 0.7, goal[1])))
    path = parking_path(s, [STATION])
    assert math.dist(path[-1], goal) >= 2 * RADIUS + 0.1
    assert math.dist(path[-1], (goal[0] + 0.7, goal[1])) >= 2 * RADIUS + 0.1
    assert holding("auto")[1].is_on_circuit
    crowd = [beacon(k + 2, x, 3.0) for k, x in enumerate((4.0, 5.2, 7.0, 8.5, 9.0))]
    assert not holding("auto", NEAR, True, *crowd)[1].is_on_circuit


def test_the_circuit_is_driven_in_order_and_goes_on_before_its_plan_ends():
    s, here = holding("circuit", Pose(6.0, 3.0, 0.0))
    assert here.is_on_circuit
    assert here.is_on_circuit
    end = s.tube.points[-1]
    assert end[0] > 8.5  # east along the south side, as the points are given
    assert np.hypot(*np.diff(s.tube.points, axis=0).T).sum() > 2.5
    s, here = holding("circuit", Pose(6.0, 3.0, 0.0))
    s.tube.near = s.tube.stop = len(s.tube.points) - 10
    s.tick += 20
    hold(here, s, nowhere)
    assert s.tube.length_ahead() > 2.0


@pytest.mark.parametrize("mode", ["auto", "circuit"])
def test_without_a_circuit_a_robot_parks(mode):
    _, here = holding(mode, NEAR, False)
    assert not here.is_on_circuit
    assert here.target is not None


def test_a_circuit_that_cannot_be_reached_leads_to_a_parking_place():
    walled = room(12.0, 12.0, (0.0, 6.0, 12.0, 6.15))
    ring = ((3.0, 8.0), (9.0, 8.0), (9.0, 10.0))
    s = robot_in(walled, Pose(6.0, 2.8, 0.0), parameters=config(holding__mode="circuit"))
    here = HoldingPattern({"ring": ring}, [STATION])
    here.enter(s)
    for _ in range(5):
        hold(here, s, nowhere)
        s.tick += 20
    assert not here.is_on_circuit
    assert here.target is not None
