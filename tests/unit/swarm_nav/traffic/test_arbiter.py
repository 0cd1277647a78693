"""The claim: when the held space grows, shrinks and is given up."""

import numpy as np
import pytest

from swarm_common.model.records import Pose, Twist
from swarm_nav.traffic.arbiter import MARGIN_STEP, Arbiter
from swarm_nav.traffic.held_space_rules import OVERLAP_SLACK, DropUnused
from swarm_nav.traffic.single_lanes import SingleLanes
from tests.fakes.decisions import act, arbiter_of, guard
from tests.fakes.navigation import beacon, hear, robot_in, room

HALL = room(8.0, 8.0)
START = Pose(2.0, 4.0, 0.0)


def on_a_path(held=0):
    """Return a robot on a path of 2 m eastwards that has requested its first points long enough."""
    s = robot_in(HALL, START)
    s.tube.adopt(np.column_stack((np.arange(2.0, 4.0, 0.05), np.full(40, 4.0))))
    s.tube.stop = held
    for _ in range(s.config.traffic.confirmations):
        s.tube.publish(s.pose, s.tick)
    return s, Arbiter(s, SingleLanes())


def test_requested_space_that_nobody_holds_is_taken_and_no_more():
    s, reservation = on_a_path()
    reservation.extend()
    assert s.tube.stop > 0
    assert s.has_grown
    # A robot without a refuge said so in one tick of ten, and did not look for one in
    # between.
    s, reservation = on_a_path()
    reservation.extend()
    s.tube.stop = len(s.tube.points) - 1
    reservation.extend()
    assert not s.has_grown
    s, reservation = on_a_path()
    s.listening_since = s.tick - s.config.traffic.listen_ticks + 1
    reservation.extend()
    assert s.tube.stop == 0


def test_a_robot_ahead_blocks_and_is_named():
    s, reservation = on_a_path()
    for count in (1, 2):
        hear(s, beacon(7, 2.6, 4.0))
        reservation.extend()
        assert (s.blocked_by, s.blocked_ticks) == (7, count)
    assert s.tube.stop <= 1
    hear(s, beacon(7, 7.9, 4.0))
    reservation.extend()
    assert (s.blocked_by, s.blocked_ticks) == (0, 0)


def test_held_space_ends_before_what_the_lidar_sees_but_for_what_it_stands_beside():
    s, _ = on_a_path(held=30)
    s.obstacles.points = np.array(((3.0, 4.0),))
    guard(s)
    end = s.tube.points[s.tube.stop, 0]
    assert 0.0 <= 3.0 - s.obstacle_clearance - end < 0.11
    assert s.obstacle_ticks == 1
    s, _ = on_a_path(held=30)
    s.obstacles.points = np.array(((1.8, 4.0),))
    guard(s)
    assert s.tube.stop == 30


def test_a_radius_that_grows_gives_up_what_is_too_near_to_others():
    s, _ = on_a_path(held=30)
    reach = s.radius + 0.285
    hear(s, beacon(7, 3.0, 4.0 + reach))
    guard(s)
    assert s.tube.stop == 30
    arbiter_of(s).announce_margin(s.radius - s.body_radius + 0.15)
    assert s.tube.span[2] == -1  # what was requested is requested anew
    guard(s)
    assert 0 < s.tube.stop < 20
    gaps = np.hypot(*(s.tube.points[: s.tube.stop + 1] - (3.0, 4.0 + reach)).T)
    assert gaps.min() >= s.radius + 0.285 - OVERLAP_SLACK


def test_a_robot_that_was_not_heard_before_gets_back_what_is_too_near_to_its_space():
    s, _ = on_a_path(held=30)
    hear(s, beacon(7, 3.5, 4.0, held=[(3.5, 4.0), (3.0, 4.0)]))
    guard(s)
    assert 0 < s.tube.stop < 20
    assert 3.0 - s.tube.points[s.tube.stop, 0] >= s.radius + 0.285 - OVERLAP_SLACK


def test_the_announced_margin_grows_in_steps_and_shrinks_late():
    s, _ = on_a_path()
    least = s.radius
    arbiter_of(s).announce_margin(0.0)
    assert s.radius == least
    arbiter_of(s).announce_margin(least - s.body_radius + 0.001)
    assert s.radius == pytest.approx(least + MARGIN_STEP)
    arbiter_of(s).announce_margin(0.0)
    assert s.radius == pytest.approx(least + MARGIN_STEP)
    arbiter_of(s).announce_margin(0.5)
    arbiter_of(s).announce_margin(0.0)
    assert s.radius == least


def test_a_claim_without_motion_is_dropped_and_one_in_use_is_kept():
    s, _ = on_a_path(held=5)
    unused = DropUnused(s)
    patience = s.ticks(s.config.traffic.stuck_time)
    s.tick += patience
    assert unused.propose(s) is None
    s.tick += 1
    act(s, unused.propose(s))
    assert len(s.tube.points) == 1
    s, _ = on_a_path(held=20)
    unused = DropUnused(s)
    for _ in range(100):
        s.tick += 1
        s.pose = Pose(s.pose.x + 0.005, 4.0, 0.0)
        assert unused.propose(s) is None


def test_a_retracted_claim_is_what_stopping_needs_and_asks_for_nothing():
    s, reservation = on_a_path(held=30)
    s.twist = Twist(0.26)
    reservation.retract()
    assert s.tube.stop == s.brake_points
    _, wanted, _ = s.tube.publish(s.pose, s.tick)
    assert len(wanted) == 0
    s.twist = Twist()
    reservation.retract()
    assert len(s.tube.points) == 1


def test_who_is_not_heard_for_a_moment_keeps_path_and_request():
    """A door over a radio with 0.3 s of delay and 30 % of loss: 2 of 12 arrived, now all do."""
    s, reservation = on_a_path(held=10)
    s.neighbors.deaf_neighbor = 7
    s.tube.publish(s.pose, s.tick)
    reservation.retract()
    assert s.tube.stop == s.tube.near
    path = len(s.tube.points)
    for _ in range(10):
        s.tick += 1
        s.tube.publish(s.pose, s.tick)
        reservation.retract()
    assert len(s.tube.points) == path > 10
    assert len(s.tube.requests) == 10
    for _ in range(40):
        s.tick += 1
        reservation.retract()
    assert len(s.tube.points) == 1
