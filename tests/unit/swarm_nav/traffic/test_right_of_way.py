"""Who ranks above whom, and the chain push, refuge, release, stuck, retreat."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.model.beacon import FLAG_ACTIVE, FLAG_STUCK
from swarm_common.model.records import Pose, Twist
from swarm_nav.core.rank import (
    CLASS_DONE,
    CLASS_DRIVING,
    CLASS_HOLDING,
    DEPTH_BITS,
    ID_BITS,
    base_priority,
)
from swarm_nav.core.states import MakingWay
from swarm_nav.traffic.arbiter import planned
from swarm_nav.traffic.right_of_way import REFUGE_MARGIN, RightOfWay, refuge_path, way_of
from tests.fakes.decisions import act, arbiter_of, push
from tests.fakes.navigation import RADIUS, beacon, hear, robot_in, room

REACH = 2 * RADIUS
HALL = room(8.0, 8.0)
CORRIDOR = room(8.0, 0.9)
MIDDLE = Pose(4.0, 4.0, 0.0)
STUCK = FLAG_STUCK | FLAG_ACTIVE
HIGH = base_priority(CLASS_DRIVING, 0, 2)
ticks = st.integers(0, 2**32 - 1)
ids = st.integers(1, 1000)


def test_classes_rank_before_seniority_and_seniority_before_the_id():
    ranked = [
        base_priority(CLASS_DRIVING, 100, 1),
        base_priority(CLASS_DRIVING, 100, 2),
        base_priority(CLASS_DRIVING, 500, 1),
        base_priority(CLASS_HOLDING, 0, 1),
        base_priority(CLASS_DONE, 0, 1),
    ]
    assert ranked == sorted(ranked, reverse=True)


@given(ticks, ids, ticks, ids)
def test_no_two_robots_have_the_same_priority(tick, robot, other_tick, other):
    a, b = (base_priority(CLASS_DRIVING, *pair) for pair in ((tick, robot), (other_tick, other)))
    assert (a == b) == ((tick, robot) == (other_tick, other))
    # sixty robots can inherit from each other below the next one's own priority
    assert abs(a - b) >= 64 or a == b
    assert 0 < a < 2**50


def pushing(x, y, robot=2, **changes):
    way = [(x + 0.1 * k, y) for k in range(31)]
    fields: dict = dict(intent=way, wanted=way[:4], priority=HIGH, blocked_by=1, blocked_ticks=20)
    return beacon(robot, x, y, **(fields | changes))


def pushed(pose=MIDDLE, *others, grid=HALL):
    s, right = robot_in(grid, pose), RightOfWay()
    s.priority = base_priority(CLASS_DONE, 0, 1)
    hear(s, *(others or (pushing(3.2, 4.0),)))
    push(right, s)
    return s, right


def test_a_robot_in_the_way_inherits_says_so_and_drives_to_a_refuge():
    s, right = pushed()
    assert right.is_yielding
    assert s.donations.push == HIGH - 1
    assert s.donations.yields_for == 2
    assert s.counters.pushes == 1
    refuge = s.tube.points[-1]
    way = s.neighbors.beacons[0]["intent"][:16]
    assert np.hypot(*(way - refuge).T).min() >= REACH
    assert np.hypot(*(refuge - (3.2, 4.0))) >= REACH + REFUGE_MARGIN - 1e-6


@pytest.mark.parametrize("speed", [0.0, 0.26])
def test_who_makes_way_gives_up_the_held_space_that_leads_the_other_way(speed):
    s, right = robot_in(HALL, MIDDLE), RightOfWay()
    s.tube.adopt(np.column_stack((np.arange(4.0, 3.0, -0.05), np.full(20, 4.0))))
    s.tube.stop, s.twist = 10, Twist(speed)
    hear(s, pushing(2.9, 4.0))
    push(right, s)
    assert right.state is MakingWay.LEAVING
    assert s.tube.stop == (s.brake_points if speed else 0)


def test_who_gives_up_space_does_not_ask_for_it_again():
    """Where the place that it stands on is its refuge, no other path replaces the old one."""
    s = robot_in(HALL, MIDDLE)
    s.tube.adopt(np.column_stack((np.arange(4.0, 3.0, -0.05), np.full(20, 4.0))))
    s.tube.stop = 10
    path = np.column_stack((np.arange(3.5, 4.5, 0.05), np.full(20, 4.0)))
    act(s, planned(s, lambda start: path if start == s.stop_point else None))
    assert s.tube.stop == 0
    assert s.tube.is_complete
    assert s.tube.span[1] == 0


def test_where_it_stands_in_the_way_is_no_refuge_though_the_nearest_node_is():
    """Crossing, seed 684: the node 3 cm away was free, the robot was not; both stood for 600 s."""
    s, right = robot_in(HALL, MIDDLE), RightOfWay()
    node = s.planner.lattice.point_of(s.planner.lattice.node_of(4.0, 4.0))
    reach = REACH + REFUGE_MARGIN
    # the way passes the node at a refuge's distance, the robot 2 cm nearer
    way = [(node[0] - 1.0 + 0.1 * k, node[1] + reach + 1e-3) for k in range(16)]
    s = robot_in(HALL, Pose(node[0], node[1] + 0.04, 0.0))
    hear(s, pushing(*way[0], intent=way, wanted=way[:1]))
    push(right, s)
    assert right.is_yielding
    gap = np.hypot(*(s.neighbors.beacons[0]["intent"][:16] - s.tube.points[-1]).T).min()
    assert gap >= REACH
    assert math.dist(s.tube.points[-1], (s.pose.x, s.pose.y)) > 0.05


def test_who_is_still_in_the_way_at_its_refuge_looks_for_one_farther_off():
    """Radio, seed 0: by its own reckoning it was out of the way; both waited for 500 s."""
    s, right = pushed()
    first = s.tube.points[-1]
    s.pose = Pose(float(first[0]), float(first[1]), 0.0)
    s.tube.reset(s.pose)
    run(s, right, 60, pushing(3.2, 4.0))
    assert not right.is_stuck
    assert math.dist(s.tube.points[-1], first) > 0.5 * REFUGE_MARGIN


@pytest.mark.parametrize(
    "changes",
    [
        {"blocked_by": 7},
        {"blocked_ticks": 2},
        {"priority": 0},
        {"priority": 1 << DEPTH_BITS},  # of no depth any more
    ],
)
def test_nobody_is_pushed_without_cause(changes):
    _, right = pushed(MIDDLE, pushing(3.2, 4.0, **changes))
    assert not right.is_yielding


@pytest.mark.parametrize(("ticks_blocked", "is_pushed"), [(3, False), (19, False), (20, True)])
def test_who_drives_on_is_left_alone_for_a_while(ticks_blocked, is_pushed):
    s, right = robot_in(HALL, MIDDLE), RightOfWay()
    s.twist = Twist(0.2, 0.0, 0.0)
    hear(s, pushing(3.2, 4.0, blocked_ticks=ticks_blocked))
    assert push(right, s) is is_pushed


def test_the_higher_pusher_counts_and_a_gone_one_pushes_nobody():
    higher = HIGH + (1 << ID_BITS + DEPTH_BITS)
    s, _ = pushed(MIDDLE, pushing(3.2, 4.0), pushing(4.0, 4.8, 3, priority=higher))
    assert s.donations.yields_for == 3
    assert s.donations.push == higher - 1
    s, right = pushed()
    higher = HIGH + (1 << ID_BITS + DEPTH_BITS)
    s.tick += 1
    s.priority = s.donations.push
    hear(s, pushing(3.2, 4.0), pushing(4.0, 4.8, 3, priority=higher))
    push(right, s)
    assert s.donations.yields_for == 3
    assert s.counters.pushes == 2
    s, right = robot_in(HALL, MIDDLE), RightOfWay()
    hear(s, pushing(3.2, 4.0), tick=50)
    assert s.neighbors.gone.all()
    assert not push(right, s)


def test_two_robots_pushed_by_one_inherit_the_same_and_are_walls_to_each_other():
    s, _ = pushed(MIDDLE, pushing(3.2, 4.0), beacon(5, 4.0, 4.6, priority=HIGH - 1))
    assert s.donations.push == s.neighbors.priorities[1] == HIGH - 1
    path = s.tube.points
    assert np.hypot(*(path[1:] - (4.0, 4.6)).T).min() >= REACH - 0.01


def run(s, right, count, *others):
    for _ in range(count):
        s.tick += 1
        hear(s, *others)
        push(right, s)
    return right.is_yielding


def test_a_robot_makes_way_until_nobody_has_pushed_it_for_the_retry_time():
    s, right = pushed()
    away = pushing(3.2, 4.0, blocked_by=0, blocked_ticks=0, intent=[(3.2, 4.0), (3.1, 4.0)])
    away["wanted_size"] = 0
    release = s.retry_ticks
    assert run(s, right, release, away)
    assert not run(s, right, 1, away)
    assert (s.donations.yields_for, s.donations.push, right.is_stuck) == (0, 0, False)
    assert s.tube.is_complete


@pytest.mark.parametrize(
    ("pusher", "own", "drives_on"),
    [
        ({}, {}, True),
        ({"blocked_ticks": 5, "blocked_by": 3}, {}, False),
        ({"priority": HIGH - 1}, {}, False),
        ({}, {"blocked_ticks": 1}, False),
        ({}, {"obstacle_ticks": 1}, False),
    ],
)
def test_who_makes_way_drives_on_to_its_refuge_while_the_pusher_comes_and_the_way_is_free(
    pusher, own, drives_on
):
    """Else it turned back to its own way after a second, to be pushed again two ticks later."""
    s, right = pushed()
    for name, value in own.items():
        setattr(s, name, value)
    coming = pushing(3.2, 4.0, **({"blocked_by": 0, "blocked_ticks": 0} | pusher))
    assert run(s, right, 3 * s.retry_ticks, coming) is drives_on
    s.tube.stop = len(s.tube.points) - 1
    assert not run(s, right, s.retry_ticks + 1, coming)


def in_a_dead_end():
    way = [(1.5 - 0.1 * k, 0.45) for k in range(15)]
    return pushed(
        Pose(0.5, 0.45, 0.0), pushing(1.2, 0.45, intent=way, wanted=way[:4]), grid=CORRIDOR
    )


def test_who_has_no_refuge_is_stuck_and_its_pusher_steps_back():
    s, right = in_a_dead_end()
    assert right.is_yielding
    assert right.is_stuck
    assert (
        refuge_path(s, s.stop_point, way_of(s, 0), s.reach(0) + REFUGE_MARGIN, s.donations.push)
        is None
    )
    s, right = blocked_by_a_stuck_one()
    assert right.is_retreating
    assert s.counters.retreats == 1
    assert s.donations.yields_for == 0
    assert np.hypot(*(s.tube.points[-1] - (4.0, 4.0))) >= 0.9


@pytest.mark.parametrize(
    ("place", "moves", "is_stuck"),
    [(MIDDLE, False, True), (MIDDLE, True, False), (Pose(4.05, 6.05, 0.0), False, False)],
)
def test_who_has_no_refuge_is_stuck_until_it_moves_or_stands_in_one(place, moves, is_stuck):
    s, right = pushed()
    right.state, s.has_grown = MakingWay.STUCK, moves
    s.pose = place
    s.tube.reset(place)
    is_elsewhere = place != MIDDLE
    s.tick += s.retry_ticks - (not is_elsewhere)  # in the middle just before the next search
    hear(s, pushing(3.2, 4.0))
    push(right, s)
    assert right.is_stuck == is_stuck


def test_who_is_blocked_on_the_way_to_its_refuge_for_long_is_stuck():
    s, right = pushed()
    s.priority = s.donations.push
    for _ in range(s.ticks(s.config.traffic.stuck_time) + 2):
        s.tick += 1
        s.blocked_ticks += 1
        s.blocked_by = 9
        hear(s, pushing(3.2, 4.0), beacon(9, 4.0, 5.0))
        push(right, s)
    assert right.is_stuck
    s.has_grown, s.blocked_ticks = True, 0
    s.tick += 1
    hear(s, pushing(3.2, 4.0))
    push(right, s)
    assert not right.is_stuck


@pytest.mark.parametrize(
    ("flags", "priority", "takes"),
    [(FLAG_ACTIVE, 5, True), (FLAG_ACTIVE, HIGH, False), (STUCK, 5, False)],
)
def test_in_a_full_room_the_place_of_a_lower_robot_is_a_refuge(flags, priority, takes):
    """No place was free, so nobody moved up, and the pusher came back for ever."""
    way = [(0.4 + 0.1 * k, 0.7) for k in range(7)]
    others = [
        beacon(robot, x, 0.7, flags=flags, priority=priority)
        for robot, x in ((7, 1.9), (8, 2.7), (9, 3.5))
    ]
    pusher = pushing(0.35, 0.7, intent=way, wanted=way[:4])
    s, right = pushed(Pose(0.95, 0.7, 0.0), pusher, *others, grid=room(4.0, 1.4))
    assert right.is_stuck is not takes
    if takes:
        assert s.tube.points[-1][0] > 1.5


def blocked_by_a_stuck_one(flags=STUCK, blocked=20):
    s, right = robot_in(HALL, MIDDLE), RightOfWay()
    s.blocked_by, s.blocked_ticks = 2, blocked
    hear(s, beacon(2, 4.7, 4.0, flags=flags))
    push(right, s)
    return s, right


@pytest.mark.parametrize(("flags", "blocked"), [(FLAG_ACTIVE, 50), (STUCK, 19)])
def test_nobody_steps_back_early_or_from_a_robot_that_can_move(flags, blocked):
    assert not blocked_by_a_stuck_one(flags, blocked)[1].is_yielding


@pytest.mark.parametrize(("behind", "steps_back"), [(7, True), (2, False)])
def test_an_equal_with_a_larger_id_does_not_bar_a_retreat(behind, steps_back):
    """Two that inherited one priority: the retreat of the highest must not be barred by rank."""
    lane = room(8.0, 4.0, (0.0, 0.0, 6.0, 1.5), (0.0, 2.4, 6.0, 4.0))  # blind to the left
    s, right = robot_in(lane, Pose(2.0, 1.95, 0.0), robot_id=5), RightOfWay()
    arbiter_of(s).announce_priorities(9, 9)
    s.blocked_by, s.blocked_ticks = 6, 20
    stuck = beacon(6, 1.3, 1.95, flags=STUCK)
    hear(s, stuck, beacon(behind, 2.7, 1.95, priority=9))
    push(right, s)
    assert right.is_retreating is steps_back


def test_a_retreat_lasts_for_its_time_unless_pushed():
    s, right = blocked_by_a_stuck_one()
    s.blocked_ticks = 0
    length = s.stuck_ticks
    stuck = beacon(2, 4.7, 4.0, flags=STUCK)
    assert run(s, right, length - 1, stuck)
    assert not run(s, right, 1, stuck)
    assert s.tube.is_complete
    s, right = blocked_by_a_stuck_one()
    s.tick += 1
    hear(s, beacon(2, 4.7, 4.0, flags=STUCK), pushing(3.2, 4.0, 3))
    push(right, s)
    assert not right.is_retreating
    assert s.donations.yields_for == 3


@pytest.mark.parametrize(("blocker", "times"), [(2, 2), (3, 1)])
def test_each_retreat_from_the_same_robot_is_farther_and_longer(blocker, times):
    """Beside a dead robot two others behind the stuck one had to step back before it: no time."""
    s, right = blocked_by_a_stuck_one()
    s.blocked_ticks = 0
    stuck = beacon(blocker, 4.7, 4.0, flags=STUCK)
    assert not run(s, right, s.stuck_ticks, stuck)
    s.blocked_by, s.blocked_ticks = blocker, 20
    assert run(s, right, 1, stuck)
    assert np.hypot(*(s.tube.points[-1] - s.stop_point)) >= 0.9 * times
    s.blocked_ticks = 0
    assert run(s, right, times * s.stuck_ticks - 1, stuck)
    assert not run(s, right, 1, stuck)


# two rooms of 4 m joined by a lane 8 m long and 0.9 m wide
LANE = room(16.0, 4.0, (4.0, 0.0, 12.0, 1.5), (4.0, 2.4, 12.0, 4.0))


def test_from_a_single_lane_a_refuge_is_in_the_room_behind_however_far():
    """Random hall 0 with 20 robots: idle ones in an aisle were pushed along it, and stuck."""
    idle = [beacon(robot, 6.5 + robot, 1.95) for robot in (3, 4, 5)]
    s, right = pushed(Pose(6.8, 1.95, 0.0), pushing(6.1, 1.95), *idle, grid=LANE)
    assert not right.is_stuck
    assert s.tube.points[-1][0] > 12.0


def test_in_a_blind_end_a_robot_looks_for_a_way_out_while_its_pusher_steps_back():
    """Random hall 9 with 20 robots: released as soon as it was not pushed, it stayed for ever."""
    s, right = in_a_dead_end()
    s.tick += s.retry_ticks + 2
    hear(s, beacon(2, 7.0, 0.45, priority=HIGH))  # the pusher has stepped back, and gives the way
    push(right, s)
    assert right.is_yielding
    assert s.tube.points[-1][0] > 2.0
    s.tick += s.stuck_ticks
    hear(s, beacon(2, 7.0, 0.45, priority=HIGH))
    assert not push(right, s)
