"""The door of goals: any request becomes a goal on the map at hand, or is rejected."""

import itertools
import math

import numpy as np
import pytest
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import OccupancyGrid

from swarm_common.middleware.rejections import RejectedError
from swarm_common.middleware.ros_io import (
    grid_from_msg,
    grid_msg,
    map_digest,
    message_digest,
    pose_from_msg,
    start_text,
    time_msg,
    unpacked,
)
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_nav.core.goals import GoalKind
from swarm_nav.ros.nav2.goals import (
    ACTIONS,
    MOST_DELAY,
    MOST_POINTS,
    MOST_POSES,
    goal_from_request,
    start_tick,
)
from swarm_nav.ros.nav2.map_bounds import AROUND, MapBounds

GRID = Grid(np.zeros((300, 400), np.int8), 0.05, -10.0, -5.0)
REACH = MapBounds.of(GRID)
WALL_CLOCK = 17_953_695_850  # ticks of a client that stamps with the wall clock


def to_map(stamped):
    return REACH.check(pose_from_msg(stamped.pose))


def goal_of(kind, request):
    return goal_from_request(kind, 1, request, to_map, REACH)


def place(x, y=0.0, **turn):
    stamped = PoseStamped()
    stamped.pose.position.x, stamped.pose.position.y = x, y
    for name, value in (turn or {"w": 1.0}).items():
        setattr(stamped.pose.orientation, name, value)
    return stamped


def narrow(value):
    with np.errstate(over="ignore"):
        return float(np.float32(value))


numbers = st.floats(width=64) | st.sampled_from([1e308, -1e308, math.nan, math.inf, 1e9, 0.0])
durations = st.builds(
    Duration, sec=st.integers(-(2**31), 2**31 - 1), nanosec=st.integers(0, 2**32 - 1)
)


@settings(deadline=None)  # the first message loads its type
@given(x=numbers, y=numbers, z=numbers, w=numbers)
def test_any_pose_becomes_a_goal_near_the_map_or_is_rejected(x, y, z, w):
    request = ACTIONS[GoalKind.NAVIGATE].Goal(pose=place(x, y, z=z, w=w))
    try:
        goal = goal_of(GoalKind.NAVIGATE, request)
    except ValueError:
        return
    pose = goal.poses_map[0]
    assert REACH.check(pose) == pose
    assert abs(pose.yaw) <= math.pi
    GRID.cell_of(pose.x, pose.y)  # at b11a34e this raised OverflowError for 1e308


@settings(deadline=None)  # the first message loads its type
@given(x=numbers, speed=numbers, angle=numbers, duration=durations)
def test_any_behaviour_is_of_the_size_of_the_map_or_is_rejected(x, speed, angle, duration):
    """BackUp and DriveOnHeading of 1e9 m ended the navigator at b11a34e (MemoryError)."""
    for kind in (GoalKind.BACKUP, GoalKind.DRIVE_ON_HEADING, GoalKind.SPIN, GoalKind.WAIT):
        request = ACTIONS[kind].Goal()
        if kind is GoalKind.WAIT:
            request.time = duration
        else:
            request.time_allowance = duration
        if kind is GoalKind.SPIN:
            request.target_yaw = narrow(angle)
        elif kind is not GoalKind.WAIT:
            request.target.x, request.speed = x, narrow(speed)
        try:
            goal = goal_of(kind, request)
        except ValueError:
            continue
        assert 0.0 <= goal.distance <= REACH.diagonal
        assert abs(goal.angle) <= 1000.0
        assert goal.duration <= 1e6
        assert math.isfinite(goal.speed)


def behaviour(kind, x, speed):
    request = ACTIONS[kind].Goal(speed=speed)
    request.target.x = x
    return goal_of(kind, request)


def test_signs_say_where_to_drive_as_nav2_reads_them():
    """A negative way at a negative speed was driven ahead."""
    for x, speed, is_reverse in ((0.3, 0.1, False), (-0.3, -0.1, True)):
        goal = behaviour(GoalKind.DRIVE_ON_HEADING, x, speed)
        assert (goal.distance, goal.is_reverse) == (0.3, is_reverse)
        with pytest.raises(RejectedError, match="one sign"):
            behaviour(GoalKind.DRIVE_ON_HEADING, x, -speed)
    for x, speed in itertools.product((0.3, -0.3), (0.1, -0.1)):
        assert behaviour(GoalKind.BACKUP, x, speed).distance == 0.3


@pytest.mark.parametrize("points", [[(0.0, 0.0), (1e9, 0.0)], [(0.0, 0.0), (900.0, 0.0)] * 500])
def test_a_path_longer_than_any_on_the_map_is_rejected(points):
    request = ACTIONS[GoalKind.FOLLOW_PATH].Goal()
    request.path.poses = [place(x, y) for x, y in points]
    with pytest.raises(RejectedError):
        goal_of(GoalKind.FOLLOW_PATH, request)


def test_more_poses_than_anybody_means_are_rejected():
    follow = ACTIONS[GoalKind.FOLLOW_PATH].Goal()
    follow.path.poses = [place(0.0)] * (MOST_POINTS + 1)
    through = ACTIONS[GoalKind.THROUGH].Goal(poses=[place(0.0)] * (MOST_POSES + 1))
    around = ACTIONS[GoalKind.WAYPOINTS].Goal(poses=[place(0.0)], number_of_loops=2**32 - 1)
    for kind, request in (
        (GoalKind.FOLLOW_PATH, follow),
        (GoalKind.THROUGH, through),
        (GoalKind.WAYPOINTS, around),
    ):
        with pytest.raises(RejectedError):
            goal_of(kind, request)


def test_a_place_off_the_map_is_the_planners_to_refuse_an_absurd_one_the_doors():
    near = Pose(-10.0 - AROUND + 1.0, 0.0, 0.0)
    assert REACH.check(near) == near
    assert not REACH.has(near)
    assert REACH.has(Pose(9.9, 9.9, 0.0))
    with pytest.raises(RejectedError, match="off the map"):
        REACH.check(Pose(10.0 + AROUND + 1.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("tree", "begins"),
    [("", 101), ("start_at_tick 0", 101), ("start_at_tick 100", 101), ("start_at_tick 130", 130),
     ("navigate.xml", 101),
     (start_text(100 + MOST_DELAY), 100 + MOST_DELAY)],
)  # fmt: skip
def test_a_goal_begins_when_it_is_asked_to_and_not_at_its_stamp(tree, begins):
    for kind, poses in ((GoalKind.NAVIGATE, "pose"), (GoalKind.THROUGH, "poses")):
        stamped = place(1.0)
        for stamp in (0, 130, WALL_CLOCK):
            stamped.header.stamp = time_msg(stamp)
            request = ACTIONS[kind].Goal(behavior_tree=tree)
            setattr(request, poses, [stamped] if kind is GoalKind.THROUGH else stamped)
            assert start_tick(goal_of(kind, request), 100) == begins


# Maps


def changed(**values):
    message = grid_msg(GRID, 0)
    for name, value in values.items():
        if name in ("x", "y"):
            setattr(message.info.origin.position, name, value)
        else:
            setattr(message.info, name, value)
    return message


@pytest.mark.parametrize(
    "values",
    [{"resolution": 0.0}, {"resolution": math.nan}, {"resolution": -0.05}, {"resolution": 1e9},
     {"x": math.nan}, {"y": 1e308}, {"width": 0}, {"width": 2**32 - 1}, {"height": 1}],
)  # fmt: skip
def test_a_map_that_makes_no_sense_is_rejected(values):
    """One with a resolution of 0 or NaN ended every navigator at once."""
    with pytest.raises(RejectedError):
        grid_from_msg(changed(**values))


def test_the_digest_of_a_map_is_that_of_its_message_and_no_others():
    again = grid_msg(GRID, 77)
    assert message_digest(again) == map_digest(GRID)
    other = Grid(GRID.cells.copy(), GRID.resolution, GRID.origin_x, GRID.origin_y)
    other.cells[3, 4] = 100
    digests = {map_digest(other), map_digest(GRID), message_digest(changed(x=-9.0))}
    digests |= {message_digest(changed(resolution=0.1))}
    assert len(digests) == 4


@settings(deadline=None)  # the first message loads its type
@given(data=st.binary(max_size=400))
def test_any_bytes_become_a_message_or_are_rejected(data):
    for head in (b"", b"\x00\x01\x00\x00", b"\x00\x00\x00\x00"):
        for kind in (PoseStamped, OccupancyGrid):
            try:
                message = unpacked(head + data, kind)
            except RejectedError:
                continue
            assert isinstance(message, kind)
