"""Long robots: discs that cover their outline, slots on a lattice, and twists beside walls."""

import functools
import itertools
import math

import numpy as np
import pytest
import shapely

from swarm_common.model.records import Pose, Twist
from swarm_describe.robots.loading import load_robot
from swarm_nav.core.config import NavConfig
from swarm_nav.planning.oblong import LEAST_GAP, MOUTH_BEND, RIM_SPACING, WALL_GAP, Oblong, cover
from swarm_nav.traffic.robot_state import terrain_of
from tests.fakes.navigation import room, waffle

NOTHING = np.zeros((0, 2))
ACCELERATION = (1.0, 2.0)


@functools.cache
def carrier():
    """1.2 x 0.6 m; the circle around it needs 1.34 m."""
    return load_robot("carrier")


@functools.cache
def outline():
    found = Oblong.of(carrier())
    assert found is not None
    return found


@functools.cache
def hall(gap):
    low, high = 2.5 - gap / 2, 2.5 + gap / 2
    walls = room(9.0, 5.0, (4.3, 0.0, 4.7, low), (4.3, high, 4.7, 5.0))
    return terrain_of(NavConfig(), carrier(), walls)


def slots(gap):
    found = hall(gap).lattice.slots
    assert found is not None
    return found


def test_what_is_a_slot_for_an_oblong_robot():
    assert Oblong.of(waffle()) is None
    found = slots(0.9)
    assert found.is_slot(np.array(((4.55, 2.55), (2.0, 2.5)))).tolist() == [True, False]
    assert not slots(0.9).is_slot(np.array(((-1.0, 2.5), (4.55, 99.0)))).any()


@pytest.mark.parametrize("gap", [LEAST_GAP, WALL_GAP])
def test_what_is_outside_polygon_and_discs_keeps_the_gap_but_for_the_rim_spacing(gap):
    discs = cover(outline().corners, gap)
    polygon = shapely.Polygon(outline().corners)
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (8000, 2))
    apart = np.hypot(*(points[:, None] - discs[None, :, :2]).transpose(2, 0, 1))
    distances = shapely.distance(polygon, shapely.points(points))
    is_outside = (apart > discs[:, 2]).all(axis=1) & (distances > 0.0)
    assert distances[is_outside].min() >= math.sqrt(gap**2 - (RIM_SPACING / 2.0) ** 2)


@pytest.mark.parametrize("gap", [0.5, 2.2])
def test_what_is_too_narrow_or_wide_enough_to_turn_in_is_none(gap):
    assert not slots(gap).is_slot(np.array(((4.55, 2.55), (4.45, 2.45)))).any()


def test_a_course_is_cut_where_it_enters_and_leaves_a_slot():
    course = np.column_stack((np.arange(2.05, 7.0, 0.1), np.full(50, 2.55)))
    pieces = slots(0.9).pieces(course)
    assert [is_straight for _, is_straight in pieces] == [False, True, False]
    for (one, _), (two, _) in itertools.pairwise(pieces):
        assert np.array_equal(one[-1], two[0])


def test_a_small_bend_is_turned_on_the_spot_at_a_mouth_only():
    found = slots(0.9)
    x = np.arange(2.05, 7.0, 0.05)
    inside = found.is_slot(np.column_stack((x, np.full(len(x), 2.55))))
    mouth = int(np.flatnonzero(inside)[0])

    def bent_at(k):
        path = np.column_stack((x, np.full(len(x), 2.55)))
        path[: k + 1, 1] -= 2.0 * MOUTH_BEND * (x[k] - x[: k + 1])
        return found.corners(path, 0.5).tolist()

    assert bent_at(mouth - 1)
    assert not bent_at(mouth - 20)


@pytest.mark.parametrize(("x", "expected"), [(3.0, 1.0), (3.6, 0.5), (3.68, 0.0)])
def test_no_twist_takes_the_outline_into_a_wall(x, expected):
    terrain, wish = hall(0.5), Twist(0.3)
    field = (terrain.distance, terrain.frame)
    pose = Pose(x, 1.0, 0.0)
    found = outline().admitted(field, NOTHING, pose, Twist(), wish, ACCELERATION)
    assert found.vx == pytest.approx(expected * wish.vx)


def test_a_thing_that_only_the_lidar_sees_stops_it_too():
    terrain = hall(0.5)
    field = (terrain.distance, terrain.frame)
    pose = Pose(2.0, 2.5, 0.0)
    nose = pose.x + outline().corners[:, 0].max()
    thing = np.array(((nose + 0.035, 2.5),))
    assert outline().admitted(field, thing, pose, Twist(), Twist(0.3), ACCELERATION) == Twist()
    away = outline().admitted(field, thing, pose, Twist(), Twist(-0.3), ACCELERATION)
    assert away == Twist(-0.3)
