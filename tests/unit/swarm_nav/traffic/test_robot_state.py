"""What the parts of a navigator share: derived facts, new maps, parameters and priorities."""

import dataclasses

import numpy as np
import pytest

from swarm_common.model.records import Pose, Twist
from swarm_nav.interfaces import Proposal
from swarm_nav.planning.planner import SPACING
from swarm_nav.reservation.tube import TOLERANCE
from swarm_nav.traffic.robot_state import FEWEST_BRAKE_POINTS, ticks_of
from swarm_nav.traffic.zone import lane_at
from tests.fakes.decisions import arbiter_of
from tests.fakes.navigation import beacon, hear, robot_in, room

HALL = room(8.0, 8.0)


def standing():
    return robot_in(HALL, Pose(2.0, 4.0, 0.0))


def on_a_path():
    s = standing()
    s.tube.adopt(np.column_stack((np.arange(2.0, 5.0, SPACING), np.full(60, 4.0))))
    s.tube.publish(s.pose, s.tick)
    return s


@pytest.mark.parametrize(("seconds", "ticks"), [(0.0, 1), (0.04, 1), (1.0, 10), (2.26, 23)])
def test_a_duration_is_at_least_one_tick(seconds, ticks):
    assert ticks_of(seconds) == ticks


def test_robots_wait_longer_over_a_slow_radio():
    s = standing()
    s.radio.extra = 7
    assert (s.retry_ticks, s.wait_ticks, s.stuck_ticks) == (17, 27, 47)
    assert s.ticks(2.0) == 20


@pytest.mark.parametrize(("speed", "points"), [(0.0, FEWEST_BRAKE_POINTS), (0.26, 2), (1.0, 12)])
def test_a_robot_keeps_the_points_that_it_needs_to_stop(speed, points):
    s = standing()
    assert s.config.controller.acc_lim_x == 1.0
    s.twist = Twist(-speed)
    assert s.brake_points == points


@pytest.mark.parametrize(("twist", "stands"), [(Twist(0.01), True), (Twist(0.03), False),
                                               (Twist(0.0, 0.0, 0.2), False)])  # fmt: skip
def test_a_robot_that_turns_does_not_stand(twist, stands):
    s = standing()
    s.twist = twist
    assert s.is_standing is stands


def test_a_new_map_or_priority_is_requested_anew():
    s = on_a_path()
    arbiter_of(s).announce_priorities(5, 7)
    assert (s.own_priority, s.priority) == (5, 7)
    assert len(s.tube.requests) == 0
    s.tube.publish(s.pose, s.tick)
    arbiter_of(s).announce_priorities(6, 7)  # as published before
    assert s.own_priority == 6
    assert len(s.tube.requests) == 1
    s = on_a_path()
    s.tube.stop = 7
    arbiter_of(s).load_map(room(6.0, 6.0))
    assert s.terrain.grid.width == 120
    assert s.planner.terrain is s.terrain
    assert len(s.tube.points) == 8


def test_parameters_reach_every_layer():
    s = on_a_path()
    before = s.terrain
    traffic = dataclasses.replace(s.config.traffic, safety_margin=0.1, held_length=0.2)
    arbiter_of(s).configure(dataclasses.replace(s.config, traffic=traffic))
    assert s.radius == pytest.approx(s.body_radius + 0.1)
    assert s.tube.span[1] == 4
    assert s.terrain is before  # which they do not concern
    planner = dataclasses.replace(s.config.planner, lane_weight=0.0)
    arbiter_of(s).configure(dataclasses.replace(s.config, planner=planner))
    assert s.terrain is not before


def of_size(radius, robot=2):
    other = beacon(robot, 5.0, 5.0)
    other["footprint"][:2] = (radius, 0.0), (0.0, -radius)
    return other


def test_where_two_robots_pass_is_told_by_the_largest_robot_heard():
    """Small robots queued where two of them pass, which larger ones take for a single lane."""
    aisle = room(12.0, 8.0, (4.0, 0.0, 9.0, 3.2), (4.0, 4.8, 9.0, 8.0))  # 1.6 m wide
    s = robot_in(aisle, Pose(2.0, 4.0, 0.0))
    is_single = []
    for robot, radius in enumerate((s.body_radius, 0.4, 0.2), 2):
        hear(s, of_size(radius, robot))
        s.record_bodies()
        is_single.append(lane_at(s, (6.5, 4.0)) > 0)
    assert is_single == [False, True, True]
    assert s.passing[0].lattice is s.terrain.lattice
    arbiter_of(s).load_map(room(12.0, 8.0))
    assert s.passing[0].lattice is s.terrain.lattice
    assert lane_at(s, (6.5, 4.0)) == 0


@pytest.mark.parametrize("radius", [np.nan, np.inf, 1e30])
def test_a_body_of_absurd_size_is_no_larger_robot(radius):
    s = standing()
    hear(s, of_size(radius))
    s.record_bodies()
    assert s.passing == (s.terrain, s.usual_radius)


@pytest.mark.parametrize(("ahead", "aside", "stop"), [(0.02, 0.0, 2), (0.02, 0.034, 3)])
def test_a_robot_that_stands_keeps_the_space_that_it_stands_beside(ahead, aside, stop):
    """After braking without data it may be ahead of the point nearest to it, and aside."""
    s = on_a_path()
    s.tube.stop = 7
    s.pose = Pose(2.0 + 2 * SPACING + ahead, 4.0 + aside, 0.0)
    arbiter_of(s).apply(Proposal(keep_ahead=0))
    assert s.tube.stop == stop
    assert s.tube.gap(s.pose) <= TOLERANCE
