"""Property: a robot twice as long as wide gets through passages narrower than its circle, and no
pose that it takes puts its outline into a wall."""

import functools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

from swarm_common.model.grid import OCCUPIED
from swarm_common.model.records import Pose
from swarm_describe.robots.loading import load_robot
from swarm_nav.core.goals import Outcome
from tests.fakes.navigation import Squad, room, without_lidar

WIDTH, DEPTH = 9.0, 5.0  # [m] of the hall that a wall with a gap divides


@functools.cache
def carrier():
    """1.2 x 0.6 m; the circle around it needs 1.34 m."""
    return load_robot("carrier")


@dataclass(frozen=True)
class Gap:
    """A wall of some thickness across the hall, and the gap in it; metres."""

    middle: float
    width: float
    thickness: float

    def grid(self):
        left, right = 4.5 - self.thickness / 2, 4.5 + self.thickness / 2
        below, above = self.middle - self.width / 2, self.middle + self.width / 2
        return room(WIDTH, DEPTH, (left, 0.0, right, below), (left, above, right, DEPTH))


def walls_of(grid):
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    step = grid.resolution
    return unary_union([box(c * step, r * step, (c + 1) * step, (r + 1) * step)
                        for r, c in zip(rows, columns, strict=True)])  # fmt: skip


def outline(pose):
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return Polygon(
        [(pose.x + cos * x - sin * y, pose.y + sin * x + cos * y) for x, y in carrier().footprint]
    )


def drive(gap, start, goal, ticks=1500):
    """Drive one carrier; return the run, and how near its outline came to a wall [m]."""
    grid = gap.grid()
    walls = walls_of(grid)
    squad = Squad(grid, [start], without_lidar(), spec=carrier())
    squad.send(0, goal)
    nearest = math.inf
    for _ in range(ticks):
        squad.run(1)
        nearest = min(nearest, outline(squad.bodies[0].pose).distance(walls))
        if squad.ended(0):
            break
    return squad, nearest


@settings(max_examples=15, deadline=None)
@given(
    middle=st.floats(1.2, 3.8),
    width=st.floats(0.9, 1.4),
    thickness=st.floats(0.1, 2.0),
    start=st.tuples(st.floats(0.8, 2.2), st.floats(0.9, 4.1), st.floats(-3.1, 3.1)),
    goal=st.tuples(st.floats(6.8, 8.2), st.floats(0.9, 4.1), st.floats(-3.1, 3.1)),
)
def test_a_long_robot_passes_straight_and_touches_nothing(middle, width, thickness, start, goal):
    squad, nearest = drive(Gap(middle, width, thickness), Pose(*start), Pose(*goal))
    assert nearest > 0.0
    assert [end.outcome for end in squad.ended(0)] == [Outcome.SUCCEEDED]


@pytest.mark.parametrize("width", [0.4, 0.55])
def test_a_gap_narrower_than_the_robot_is_no_way(width):
    squad, nearest = drive(
        Gap(2.5, width, 0.5), Pose(1.5, 2.5, 0.0), Pose(7.5, 2.5, 0.0), ticks=600
    )
    assert squad.bodies[0].pose.x < 4.0
    assert nearest > 0.0


def test_a_long_robot_that_starts_in_a_gap_backs_out_of_it():
    squad, nearest = drive(Gap(2.5, 1.0, 2.0), Pose(4.4, 2.52, 0.03), Pose(1.5, 1.5, 0.0))
    assert nearest > 0.0
    assert [end.outcome for end in squad.ended(0)] == [Outcome.SUCCEEDED]
