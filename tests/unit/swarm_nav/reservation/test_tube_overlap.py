"""Which part of a held tube is given up when a radius has grown."""

import math

import numpy as np
import pytest

from swarm_common.model.records import Pose
from swarm_nav.reservation.tube_kernels import first_overlap
from tests.fakes.navigation import RADIUS, beacon, hear, robot_in, room

HALL = room(8.0, 8.0)
PATH = np.column_stack((np.arange(2.0, 5.0, 0.05), np.full(60, 4.0)))
STOP = 40
SLACK = 0.06


def overlap(other, radius=RADIUS, tick=None):
    s = robot_in(HALL, Pose(2.0, 4.0, 0.0))
    hear(s, other, tick=tick)
    return int(first_overlap(PATH, 0, STOP, radius, SLACK, s.neighbors.claims()))


def by_hand(other, radius):
    reach = radius + RADIUS - SLACK
    gaps = [math.dist(point, other) for point in PATH[: STOP + 1]]
    near = [k for k in range(1, STOP + 1) if gaps[k] < reach and gaps[k] < gaps[0]]
    return near[0] if near else STOP + 1


@pytest.mark.parametrize("other", [(3.0, 4.4), (3.7, 4.3), (3.0, 4.9), (2.3, 4.3), (7.0, 7.0)])
@pytest.mark.parametrize("radius", [RADIUS, RADIUS + 0.1, RADIUS + 0.3])
def test_the_first_point_that_is_too_near_is_found(other, radius):
    assert overlap(beacon(7, *other), radius) == by_hand(other, radius)


def test_who_overlaps_may_drive_away_and_who_is_silent_takes_nothing():
    assert overlap(beacon(7, 1.8, 4.0), RADIUS + 0.2) == STOP + 1
    near = beacon(7, 3.0, 4.2)
    assert overlap(near) <= STOP
    assert overlap(near, tick=50) == STOP + 1
