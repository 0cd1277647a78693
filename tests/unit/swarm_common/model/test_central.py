"""Reports and orders are what they were, after they have been bytes."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.middleware.central_io import unwrapped, wrapped
from swarm_common.model.central import (
    MOST_SEEN,
    RobotReport,
    TeamOrder,
    places_seen,
    unpack_order,
    unpack_report,
)
from swarm_common.model.records import Pose

COUNTS = st.integers(0, 2**32 - 1)
NUMBERS = st.floats(-1e3, 1e3)
IDS = st.integers(1, 2**16 - 1)


PLACES = st.tuples(NUMBERS, NUMBERS)


@given(IDS, COUNTS, PLACES, COUNTS, st.booleans(), st.lists(PLACES, max_size=MOST_SEEN))
def test_a_report(robot_id, count, place, heard, arrived, seen):
    x, y = place
    report = RobotReport(
        robot_id=robot_id, tick=count, pose_map=Pose(x, y, 0.5), passed=3, heard=heard,
        goal_id=count, goal_map=(y, x), has_arrived=arrived, seen_map=tuple(seen),
    )  # fmt: skip
    data = report.packed()
    assert report.size == 39 + 8 * len(seen)  # on the air
    assert unpack_report(unwrapped(wrapped(data))) == report


@given(IDS, COUNTS, COUNTS, st.lists(st.tuples(NUMBERS, NUMBERS), max_size=12))
def test_an_order(robot_id, number, first, points):
    order = TeamOrder(robot_id=robot_id, number=number, first=first, points_map=tuple(points))
    data = order.packed()
    assert order.size == 11 + 8 * len(points)  # on the air
    assert unpack_order(unwrapped(wrapped(data))) == order


def test_a_robot_reports_the_nearest_things_that_it_sees():
    marks = np.array([(x, 0.01 * k) for x in range(30) for k in range(5)], float)
    seen = places_seen(marks, Pose(20.0, 0.0, 0.0))
    assert len(seen) == MOST_SEEN
    assert seen[0] == (20.0, 0.0)
    assert {abs(x - 20.0) <= 8.0 for x, _ in seen} == {True}
    assert places_seen(np.zeros((0, 2)), Pose(0.0, 0.0, 0.0)) == ()


@given(st.binary(max_size=60))
def test_other_bytes_are_refused_or_read(data):
    for read in (unpack_order, unpack_report):
        try:
            read(data)
        except ValueError:
            continue


@pytest.mark.parametrize("bad", [math.nan, math.inf, 1e30])
def test_numbers_that_are_no_places_are_refused(bad):
    order = TeamOrder(robot_id=1, number=1, first=0, points_map=((0.0, bad),))
    with pytest.raises(ValueError, match="of way"):
        unpack_order(order.packed())
    for pose, goal in ((Pose(bad, 0.0, 0.0), (0.0, 0.0)), (Pose(0.0, 0.0, 0.0), (0.0, bad))):
        report = RobotReport(
            robot_id=1, tick=0, pose_map=pose, passed=0, heard=0, goal_id=0, goal_map=goal,
            has_arrived=False,
        )  # fmt: skip
        with pytest.raises(ValueError, match="a report of"):
            unpack_report(report.packed())
    seen = RobotReport(
        robot_id=1, tick=0, pose_map=Pose(0.0, 0.0, 0.0), passed=0, heard=0, goal_id=0,
        goal_map=(0.0, 0.0), has_arrived=False, seen_map=((bad, 0.0),),
    )  # fmt: skip
    with pytest.raises(ValueError, match="a report of"):
        unpack_report(seen.packed())
