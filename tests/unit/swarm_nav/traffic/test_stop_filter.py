"""The stop filter: whatever a controller wants, braking ends in the robot's own space."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_nav.planning.distance_kernels import Frame
from swarm_nav.reservation.stop_filter_kernels import (
    SHARES,
    gap_to_line,
    last_to_keep,
    release_and_admit,
)
from swarm_nav.reservation.tube import TOLERANCE
from swarm_nav.reservation.tube_kernels import nearest_ahead

OPEN = np.full((2, 2), 100.0)
FRAME = Frame(-50.0, -50.0, 50.0)
NOTHING = np.zeros((0, 2))
AHEAD = np.column_stack((np.arange(0.0, 0.51, 0.05), np.zeros(11)))
ACCELERATIONS = (1.0, 1.0, 3.2)
MOST = 0.26
speeds = st.floats(-MOST, MOST)
rates = st.floats(-1.82, 1.82)


def share_of(
    wish, *, now=(0.0, 0.0, 0.0), pose=(0.0, 0.0, 0.0), held=10, field=OPEN, hits=NOTHING, floor=0.2
):
    around = (field, FRAME, hits, 0.0, floor)
    space = (AHEAD.copy(), 0, 0, held, TOLERANCE)
    share: float = release_and_admit(pose, now, wish, (*ACCELERATIONS, 0.1), space, around)[1]
    return share


def test_along_the_held_space_a_twist_passes_and_beside_it_only_back():
    assert share_of((MOST, 0.0, 0.0), now=(MOST, 0.0, 0.0)) == 1.0
    aside = (0.2, 0.08, -math.pi / 2)
    assert share_of((0.1, 0.0, 0.0), pose=aside) == 1.0
    assert share_of((-0.1, 0.0, 0.0), pose=aside) == 0.0


@pytest.mark.parametrize("wish", [(-MOST, 0.0, 0.0), (0.0, MOST, 0.0), (MOST, 0.0, 0.0)])
def test_a_robot_that_holds_its_place_only_does_not_leave_it(wish):
    x = 0.035 if wish[0] > 0.0 else -0.035
    pose = (x, 0.035 if wish[1] else 0.0, 0.0)
    assert share_of(wish, pose=pose, now=wish, held=0) == 0.0


@pytest.mark.parametrize("what", ["wall", "hit"])
def test_a_robot_does_not_brake_into_what_is_ahead(what):
    hits = np.array(((0.45, 0.0),)) if what == "hit" else NOTHING
    field = OPEN
    if what == "wall":  # at x = 0.45: distance falls linearly
        field = np.array(((25.45, -24.55), (25.45, -24.55)))
    near, far = (0.24, 0.0, 0.0), (0.0, 0.0, 0.0)
    now = (MOST, 0.0, 0.0)
    assert share_of(now, pose=near, now=now, field=field, hits=hits) == 0.0
    assert share_of(now, pose=far, now=now, field=field, hits=hits) == 1.0
    assert share_of((-MOST, 0.0, 0.0), pose=near, field=field, hits=hits) == 1.0


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(speeds, speeds, rates), min_size=10, max_size=60), st.integers(0, 10))
def test_no_sequence_of_wishes_leads_out_of_the_held_space(wishes, held):
    drive = Drive()
    for wish in wishes:
        share = share_of(wish, now=drive.twist, pose=drive.pose, held=held)
        assert share in (1.0, *SHARES, 0.0)
        drive.go((share * wish[0], share * wish[1], share * wish[2]))
        for x, y in drive.track:
            assert gap_to_line(AHEAD, 0, held, x, y) < TOLERANCE + 0.003


Twist3 = tuple[float, float, float]


class Drive:
    """A drive that ramps, in steps ten times finer than the filter's rollout."""

    def __init__(self, x=0.0, y=0.0, vx=0.0):
        self.pose: Twist3 = (x, y, 0.0)
        self.twist: Twist3 = (vx, 0.0, 0.0)
        self.track: list[tuple[float, float]] = []

    def go(self, goal):
        """Drive towards a twist for a period."""
        x, y, yaw = self.pose
        vx, vy, w = self.twist
        self.track = []
        for _ in range(20):
            step = 0.005
            vx, vy, w = (
                min(max(wish, speed - a * step), speed + a * step)
                for wish, speed, a in zip(goal, (vx, vy, w), ACCELERATIONS, strict=True)
            )
            yaw += w * step
            x += (vx * math.cos(yaw) - vy * math.sin(yaw)) * step
            y += (vx * math.sin(yaw) + vy * math.cos(yaw)) * step
            self.track.append((x, y))
        self.pose, self.twist = (x, y, yaw), (vx, vy, w)


class Space:
    """A held path whose ends are given up as far as braking allows."""

    def __init__(self, points, stop):
        self.points, self.tail, self.near, self.stop = points.copy(), 0, 0, stop
        self.path = points

    def filter(self, drive, wish):
        """Return what of a wish is admitted, after what is behind was given up."""
        gap = math.dist(self.path[self.near], drive.pose[:2])
        self.near = nearest_ahead(self.points, self.near, gap, self.stop, *drive.pose[:2])
        held = (self.points, self.tail, self.near, self.stop, TOLERANCE)
        around = (OPEN, FRAME, NOTHING, 0.0, 0.2)
        limits = (*ACCELERATIONS, 0.1)
        self.tail, share = release_and_admit(drive.pose, drive.twist, wish, limits, held, around)
        self.near = max(self.near, self.tail)
        return share * wish[0], share * wish[1], share * wish[2]

    def release(self, drive, last):
        held = (self.points, self.tail, self.stop, TOLERANCE)
        limits = (*ACCELERATIONS, 0.1)
        self.stop = last_to_keep(drive.pose, drive.twist, limits, held, max(last, self.near))

    def gap(self, x, y):
        """Return the distance [m] of a place to what is held."""
        return float(gap_to_line(self.points, self.tail, self.stop, x, y))


def test_the_first_held_point_follows_but_gives_no_space_behind():
    for x, tail in ((0.12, (2, 0.12)), (0.135, (2, 0.135)), (0.15, (3, 0.15))):
        space, drive = Space(AHEAD, 10), Drive(x, 0.01, MOST)
        space.filter(drive, (MOST, 0.0, 0.0))
        assert (space.tail, space.points[space.tail, 0]) == pytest.approx(tail)
    space, drive = Space(AHEAD, 10), Drive(0.2)
    space.filter(drive, (0.0, 0.0, 0.0))
    for _ in range(30):
        drive.go(space.filter(drive, (-MOST, 0.0, 0.0)))
    assert 0.2 - TOLERANCE - 0.003 < drive.pose[0] < 0.2


def test_space_in_which_the_robot_brakes_is_not_given_up():
    fast, way = 0.5, 0.125  # [m/s] and the way to stop
    space, drive = Space(AHEAD, 10), Drive(0.3, 0.0, -fast)
    space.filter(drive, (0.0, 0.0, 0.0))
    assert space.tail == 0
    drive = Drive(0.1, 0.0, fast)
    space.release(drive, 0)
    assert space.points[space.stop, 0] >= 0.1 + way - TOLERANCE
    assert space.points[space.stop - 1, 0] < 0.1 + way + 0.03


BEND = np.array([(0.05 * min(k, 6), 0.05 * max(0, k - 6)) for k in range(14)])
deeds = st.tuples(speeds, speeds, rates, st.sampled_from((None, None, None, 0, 2)))


@settings(max_examples=300, deadline=None)
@given(st.lists(deeds, min_size=20, max_size=80), st.integers(0, 13), st.booleans())
def test_no_sequence_of_wishes_and_releases_leads_out_of_what_is_left(wishes, stop, is_omni):
    space, drive = Space(BEND, stop), Drive()
    for vx, vy, wz, keep in wishes:
        if keep is not None:
            space.release(drive, space.near + keep)
        drive.go(space.filter(drive, (vx, vy if is_omni else 0.0, wz)))
        assert max(space.gap(x, y) for x, y in drive.track) < TOLERANCE + 0.003
