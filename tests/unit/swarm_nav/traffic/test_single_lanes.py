"""Single-lane passages: where they are, and whose turn it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import Pose
from swarm_describe.robots.loading import load_robot
from swarm_nav.core.config import NavConfig
from swarm_nav.core.rank import OWN_DEPTH
from swarm_nav.planning import search_kernels
from swarm_nav.traffic import single_lane_kernels as kernels
from swarm_nav.traffic.robot_state import initial_state
from swarm_nav.traffic.single_lanes import SingleLanes, passing_areas, single_lanes
from tests.fakes.navigation import beacon, hear, robot_in, room

HALL = room(8.0, 8.0)


def with_door(width=0.7):
    """Return the hall with a wall across its middle and a door in it."""
    cells = HALL.cells.copy()
    middle = cells.shape[1] // 2
    half = round(width / 2 / HALL.resolution)
    cells[:, middle - 2 : middle + 2] = OCCUPIED
    cells[cells.shape[0] // 2 - half : cells.shape[0] // 2 + half, middle - 2 : middle + 2] = 0
    return Grid(cells, HALL.resolution, HALL.origin_x, HALL.origin_y)


DOOR = with_door()


def test_half_the_width_of_a_corridor_is_found_anywhere_in_it():
    step, half = 0.1, 0.65
    centre = (np.arange(40) + 0.5) * step
    clearance = np.maximum(0.0, half - np.abs(centre - 2.0))[:, None].repeat(60, axis=1)
    out = np.empty_like(clearance)
    kernels.half_width(clearance, step, out)
    inside = clearance[:, 30] > 0.15
    assert np.allclose(out[inside, 30], half, atol=0.1)


@settings(max_examples=60, deadline=None)
@given(width=st.floats(1.0, 1.5), offset=st.floats(0.0, 0.1), is_upright=st.booleans())
def test_all_of_an_aisle_is_a_single_lane_or_none_of_it(width, offset, is_upright):
    """An aisle a little too narrow for two was a lane on one side and a room on the other."""
    low = 3.0 + offset
    walls = [(0.0, 0.0, 6.0, low), (0.0, low + width, 6.0, 6.0)]
    boxes = [(y, x, v, u) for x, y, u, v in walls] if is_upright else walls
    s = robot_in(room(6.0, 6.0, *boxes), Pose(3.0, 3.0 + width / 2, 0.0))
    is_open = s.planner.lattice.base < search_kernels.WALL
    is_wide = passing_areas(*s.passing)[is_open]
    assert is_wide.all() or not is_wide.any()


@pytest.mark.parametrize(("width", "is_room"), [(0.85, False), (1.05, True)])
def test_where_two_smooth_paths_do_not_fit_beside_each_other_is_a_single_lane(width, is_room):
    """Paths keep 0.3 m from walls: in an aisle of 0.85 m all small robots drove in the middle."""
    grid = room(6.0, 6.0, (0.0, 0.0, 6.0, 2.0), (0.0, 2.0 + width, 6.0, 6.0))
    s = initial_state(NavConfig(), load_robot("turtlebot3_burger"), grid, 1, Pose(3.0, 2.4, 0.0))
    is_open = s.planner.lattice.base < search_kernels.WALL
    assert bool(passing_areas(*s.passing)[is_open].any()) is is_room


def test_doors_are_single_lanes_and_halls_are_not():
    open_hall, walled = robot_in(HALL, Pose(1, 4, 0)), robot_in(DOOR, Pose(1, 4, 0))
    assert single_lanes(open_hall.terrain, open_hall.radius) is None
    labels = single_lanes(walled.terrain, walled.radius)
    assert labels is not None
    frame = walled.planner.lattice.frame
    assert kernels.label_at(labels, frame, 4.0, 4.0) > 0
    assert kernels.label_at(labels, frame, 1.0, 4.0) == 0
    assert kernels.label_at(labels, frame, -5.0, 4.0) == 0
    # Labels dilated by the mouths made one lane of 45 m² of two doors, which a robot barred.
    grid = room(8.0, 8.0, (4.0, 0.0, 4.2, 2.9), (4.0, 3.8, 4.2, 4.6), (4.0, 5.5, 4.2, 8.0))
    s = robot_in(grid, Pose(2.3, 3.3, 0.0))
    labels = single_lanes(s.terrain, s.radius)
    assert labels is not None
    doors = {int(kernels.label_at(labels, s.planner.lattice.frame, 4.1, y)) for y in (3.35, 5.05)}
    assert len(doors) == 2
    assert 0 not in doors


def approaching(priority):
    s = robot_in(DOOR, Pose(2.3, 4.0, 0.0))
    s.tube.adopt(np.column_stack((np.arange(2.3, 7.0, 0.05), np.full(94, 4.0))))
    s.priority = priority
    return s


def westward(priority, x=6.3):
    way = [(x - 0.1 * k, 4.0) for k in range(31)]
    return beacon(2, x, 4.0, intent=way, priority=priority)


def eastward(priority):
    way = [(3.5 + 0.1 * k, 4.0) for k in range(31)]
    return beacon(2, 3.5, 4.0, intent=way, priority=priority)


@pytest.mark.parametrize(
    ("other", "is_waited_for"),
    [
        (westward(9), True),  # it ranks above and comes the other way
        (westward(1), False),  # it ranks below and is not inside
        (westward(1, 4.2), False),  # it ranks below: it makes way, wherever it is
        (eastward(9), False),  # it goes the same way
    ],
)
def test_who_ranks_below_waits_before_the_mouth(other, is_waited_for):
    s = approaching(5)
    hear(s, other)
    last, row = SingleLanes().barrier(s, s.tube.stop + 7)
    assert (row == 0) == is_waited_for
    assert (last < s.tube.stop + 7) == is_waited_for


def test_who_makes_way_or_has_no_lane_ahead_goes_on():
    s = approaching(5)
    s.donations.yields_for = 3
    hear(s, westward(9))
    assert SingleLanes().barrier(s, s.tube.stop + 7) == (s.tube.stop + 7, -1)
    s = robot_in(HALL, Pose(2.0, 4.0, 0.0))
    assert SingleLanes().barrier(s, 5) == (5, -1)


def leader(x, ahead=0.1, priority=128 + OWN_DEPTH):
    way = [(x + ahead * k, 4.0) for k in range(31)]
    return beacon(2, *way[0], held=way[:6], intent=way[5:], priority=priority)


@pytest.mark.parametrize(
    ("other", "inherited"),
    [
        (leader(3.6), 127 + OWN_DEPTH),  # in the passage ahead, the same way
        (leader(3.6, -0.1), 0),  # the other way
        (leader(6.5), 0),  # through already
        (leader(3.6, priority=OWN_DEPTH), 0),  # it ranks below
        (leader(3.6, priority=128), 0),  # at the end of a chain
    ],
)
def test_who_goes_through_behind_a_higher_robot_inherits_its_rank(other, inherited):
    s, lanes = approaching(5 + OWN_DEPTH), SingleLanes()
    s.own_priority = s.priority
    hear(s, other)
    lanes.barrier(s, s.tube.stop + 7)
    assert s.donations.lane == inherited


def test_who_follows_into_a_blind_end_inherits_nothing():
    """It would keep the rank, and keep in those that come out."""
    s, lanes = approaching(5 + OWN_DEPTH), SingleLanes()
    s.tube.adopt(np.column_stack((np.arange(2.3, 4.5, 0.05), np.full(44, 4.0))))
    s.own_priority = s.priority
    hear(s, leader(3.6))
    lanes.barrier(s, s.tube.stop + 7)
    assert s.donations.lane == 0


def test_who_follows_keeps_the_rank_until_it_is_out():
    s, lanes = approaching(5 + OWN_DEPTH), SingleLanes()
    s.own_priority = s.priority
    hear(s, leader(3.6))
    lanes.barrier(s, s.tube.stop + 7)
    inherited = s.donations.lane
    hear(s, leader(6.5), tick=2)
    for stop, x, expected in ((30, 2.8, inherited), (64, 4.5, inherited), (70, 5.8, 0)):
        s.tube.stop, s.pose = stop, Pose(x, 4.0, 0.0)
        lanes.barrier(s, s.tube.stop + 3)
        assert s.donations.lane == expected
