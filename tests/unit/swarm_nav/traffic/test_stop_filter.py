"""The stop filter: whatever a controller wants, braking ends in the robot's own space."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_nav.planning.distance_kernels import Frame
from swarm_nav.reservation.stop_filter_kernels import SHARES, gap_to_line, largest_share

OPEN = np.full((2, 2), 100.0)
FRAME = Frame(-50.0, -50.0, 50.0)
NOTHING = np.zeros((0, 2))
AHEAD = np.column_stack((np.arange(0.0, 0.51, 0.05), np.zeros(11)))
ACCELERATIONS = (1.0, 1.0, 3.2)
TOLERANCE = 0.037
MOST = 0.26
speeds = st.floats(-MOST, MOST)
rates = st.floats(-1.82, 1.82)


def share_of(
    wish: tuple[float, float, float],
    *,
    now: tuple[float, float, float] = (0.0, 0.0, 0.0),
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
    held: int = 10,
    field: np.ndarray = OPEN,
    hits: np.ndarray = NOTHING,
    floor: float = 0.2,
) -> float:
    """Return the share of a wish that passes on a straight held path along x."""
    around = (field, FRAME, hits, 0.0, floor)
    return largest_share(
        pose, now, wish, (*ACCELERATIONS, 0.1), (AHEAD, 0, held, TOLERANCE), around
    )


def test_a_twist_along_the_held_space_passes_unchanged() -> None:
    assert share_of((MOST, 0.0, 0.0), now=(MOST, 0.0, 0.0)) == 1.0


@pytest.mark.parametrize("wish", [(-MOST, 0.0, 0.0), (0.0, MOST, 0.0), (MOST, 0.0, 0.0)])
def test_a_robot_that_holds_its_place_only_does_not_leave_it(
    wish: tuple[float, float, float],
) -> None:
    x = 0.035 if wish[0] > 0.0 else -0.035
    pose = (x, 0.035 if wish[1] else 0.0, 0.0)
    assert share_of(wish, pose=pose, now=wish, held=0) == 0.0


def test_a_robot_beside_its_space_may_only_come_back() -> None:
    aside = (0.2, 0.08, -math.pi / 2)
    assert share_of((0.1, 0.0, 0.0), pose=aside) == 1.0
    assert share_of((-0.1, 0.0, 0.0), pose=aside) == 0.0


@pytest.mark.parametrize("what", ["wall", "hit"])
def test_a_robot_does_not_brake_into_what_is_ahead(what: str) -> None:
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
def test_no_sequence_of_wishes_leads_out_of_the_held_space(
    wishes: list[tuple[float, float, float]], held: int
) -> None:
    x = y = yaw = vx = vy = w = 0.0
    for wish in wishes:
        share = share_of(wish, now=(vx, vy, w), pose=(x, y, yaw), held=held)
        assert share in (*SHARES, 0.0)
        for _ in range(20):  # the drive, ten times finer than the filter's rollout
            step = 0.005
            changes = (a * step for a in ACCELERATIONS)
            vx, vy, w = (
                min(max(share * goal, speed - most), speed + most)
                for goal, speed, most in zip(wish, (vx, vy, w), changes, strict=True)
            )
            yaw += w * step
            x += (vx * math.cos(yaw) - vy * math.sin(yaw)) * step
            y += (vx * math.sin(yaw) + vy * math.cos(yaw)) * step
            assert gap_to_line(AHEAD, 0, held, x, y) < TOLERANCE + 0.003
