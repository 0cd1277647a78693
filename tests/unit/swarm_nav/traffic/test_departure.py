"""A robot without a goal leaves a narrow region or a dead end once it keeps others out."""

import numpy as np
import pytest

from swarm_common.model.records import Pose
from swarm_nav.core.rank import CLASS_DRIVING, CLASS_HOLDING, base_priority, inherited_by_holder
from swarm_nav.traffic.departure import Departure
from swarm_nav.traffic.gate import Gate, label_of
from swarm_nav.traffic.lease import Lease
from tests.fakes.decisions import leave
from tests.fakes.navigation import beacon, hear, let_walk, robot_in, room

HALL = room(9.0, 9.0)


def idle_robot(*others, x=4.5, grid=HALL):
    """Return a robot that stands in or beside a region, 4.0 < x < 5.0 m, and hears others."""
    s = robot_in(grid, Pose(x, 4.5, 0.0))
    region = np.zeros(s.planner.lattice.base.shape, np.int16)
    region[:, 40:50] = 1
    hear(s, *others)
    gate = Gate(region)
    return Departure(gate, Lease()), gate, s


def wait(departure, s, seconds):
    """Let it be idle for some time; return whether it leaves at the end."""
    leaves = False
    for _ in range(round(seconds * 10.0)):
        leaves = leave(departure, s, True)
        s.tick += 1
    return leaves


def test_who_stands_inside_leaves_for_a_place_outside():
    departure, gate, s = idle_robot(beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40))
    assert not wait(departure, s, s.config.traffic.wait_time - 0.2)
    assert wait(departure, s, 0.5)
    x, y = s.tube.points[-1]
    assert gate.region is not None
    assert not label_of(gate.region, s.planner.lattice.frame, x, y)
    asking = beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40)
    for x in (4.5, 6.5):
        departure, _, s = idle_robot(asking, x=x)
        departure._has_left = True
        assert wait(departure, s, s.config.traffic.wait_time + 0.5) is (x == 4.5)


@pytest.mark.parametrize(("x", "leaves"), [(4.5, True), (6.5, True), (10.0, False)])
def test_who_has_left_leaves_the_floor_before_the_region_as_well(x, leaves):
    """Twenty that were done stood in the way before an aisle, in the row two_loaders."""
    asking = beacon(2, 7.0, 4.5, gate_tick=50, priority=1 << 40)
    departure, gate, s = idle_robot(asking, x=x, grid=room(18.0, 9.0))
    # before the region it stays at its goal, also if it was pushed
    assert wait(departure, s, s.config.traffic.wait_time + 0.5) is (x == 4.5)
    leave(departure, s, False)
    s.tube.reset(s.pose)
    assert wait(departure, s, s.config.traffic.wait_time + 0.5) is (x == 4.5)
    departure._has_left = True
    assert wait(departure, s, s.config.traffic.wait_time + 0.5) is leaves
    assert gate.region is not None
    if leaves:
        forecourt = gate.forecourt(s.planner.lattice, s.config.holding.request_distance)
        assert forecourt is not None
        assert not label_of(forecourt, s.planner.lattice.frame, *s.tube.points[-1])
    s.blocked_ticks = s.wait_ticks + 1  # who is only before it does not rank above those that ask
    leave(departure, s, True)
    s.blocked_ticks = 0
    wait(departure, s, s.config.traffic.wait_time + 0.5)
    assert (s.donations.station > 0) is (x == 4.5)


def test_without_floor_wide_enough_to_park_it_leaves_for_a_place_where_others_get_past():
    s = robot_in(room(9.0, 2.4), Pose(4.5, 1.2, 0.0))
    assert not s.planner.lattice.parking.any()
    region = np.zeros(s.planner.lattice.base.shape, np.int16)
    region[:, 40:50] = 1
    hear(s, beacon(2, 2.0, 1.2, gate_tick=50, priority=1 << 40))
    assert wait(Departure(Gate(region), Lease()), s, 10.0)
    x, y = s.tube.points[-1]
    assert not label_of(region, s.planner.lattice.frame, x, y)


def test_nobody_leaves_unasked_or_outside():
    for gate_tick in (0, 1):
        departure, _, s = idle_robot(beacon(2, 2.0, 4.5, gate_tick=gate_tick, priority=1 << 40))
        assert not wait(departure, s, 10.0)
    asking = beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40)
    departure, gate, s = idle_robot(asking, x=6.5)
    assert not wait(departure, s, 10.0)
    departure, gate, s = idle_robot(asking)
    gate.region = None
    assert not wait(departure, s, 10.0)


def test_a_goal_or_a_pusher_or_its_place_ends_it():
    departure, _, s = idle_robot(beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40))
    assert wait(departure, s, s.config.traffic.wait_time + 0.5)
    assert not leave(departure, s, False)
    assert not wait(departure, s, s.config.traffic.wait_time - 0.2)
    departure, _, s = idle_robot(beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40))
    assert wait(departure, s, s.config.traffic.wait_time + 0.5)
    x, y = s.tube.points[-1]
    s.pose = Pose(float(x), float(y), 0.0)
    assert not leave(departure, s, True)


@pytest.mark.parametrize("why", ["blocked_ticks", "obstacle_ticks"])
def test_a_way_that_is_barred_for_long_is_given_up(why):
    """Random hall 127: before a dead robot, one stood on its way out for ever, above all others."""
    departure, _, s = idle_robot(beacon(2, 2.0, 4.5, gate_tick=50, priority=1 << 40))
    assert wait(departure, s, s.config.traffic.wait_time + 0.5)
    hear(s, beacon(2, 2.0, 4.5))  # so that it does not set off anew at once
    setattr(s, why, s.wait_ticks)
    assert leave(departure, s, True)
    setattr(s, why, s.wait_ticks + 1)
    assert not leave(departure, s, True)


def test_on_large_single_lanes_it_leaves_unasked_and_keeps_its_turn_until_it_is_out():
    """Nobody was heard deep in a blind aisle: 3 of 8 robots got to its end, then never another."""
    departure, lease, s = done_at_station(LONG_AISLE)
    for _ in range(60):
        lease.update(s)
        leaves = leave(departure, s, True)
        s.tick += 1
    assert leaves
    assert (lease.station, lease.is_leaving) == (STATION, True)
    assert s.tube.points[-1][1] > 9.0
    rank = base_priority(CLASS_HOLDING, 5, 2)
    hear(s, beacon(2, 1.85, 5.0, station=STATION, station_tick=50, priority=rank))
    lease.update(s)
    assert s.donations.station > inherited_by_holder(rank)
    hear(s, beacon(3, 1.85, 3.0), tick=1)
    s.blocked_ticks = s.wait_ticks + 1
    for blocker, goes_on in ((2, True), (3, False)):  # one that lives, one that does not
        s.blocked_by = blocker
        s.tick -= 20  # no other way is looked for
        assert leave(departure, s, True) is goes_on
        s.tick += 20
    s.pose = Pose(1.85, 11.0, 0.0)
    s.tube.reset(s.pose)
    lease.update(s)
    assert lease.station is None


def test_a_region_that_is_all_of_the_floor_does_not_keep_a_robot_on_single_lanes():
    """It was to leave the region, which it could not, and stood there: 6 of 96 goals in a hall."""
    departure, lease, s = done_at_station(LONG_AISLE)
    departure._gate.region = np.ones(s.planner.lattice.base.shape, np.int16)
    rank = base_priority(CLASS_HOLDING, 5, 2)
    hear(s, beacon(2, 1.85, 5.0, station=STATION, station_tick=50, priority=rank))
    leaves = False
    for _ in range(60):
        lease.update(s)
        leaves = leave(departure, s, True)
        s.tick += 1
    assert leaves
    assert s.tube.points[-1][1] > 9.0


@pytest.mark.parametrize(("station", "leaves"), [((4.5, 8.0), True), ((2.0, 8.0), False)])
def test_a_region_is_left_for_who_asks_for_a_station_in_it(station, leaves):
    """Eight that were done stood in a blind aisle and pushed nobody: random hall 372, 2,826 s."""
    rank = base_priority(CLASS_DRIVING, 5, 2)
    asking = beacon(2, 4.5, 7.0, station=station, station_tick=50, priority=rank)
    departure, _, s = idle_robot(asking)
    assert wait(departure, s, s.config.traffic.wait_time + 0.5) is leaves
    assert s.donations.station == 0
    s.blocked_ticks = s.wait_ticks + 1  # now it insists
    leave(departure, s, True)
    s.blocked_ticks = 0
    assert wait(departure, s, s.config.traffic.wait_time + 0.5) is leaves
    assert (s.donations.station > rank) is leaves


@pytest.mark.parametrize(("gap", "leaves"), [(0.6, True), (1.5, False)])
def test_who_stands_in_the_way_of_people_leaves_it(gap, leaves):
    """A person was penned in between two robots, on the station of a third, in hall 25."""
    departure, gate, s = idle_robot(x=6.5)
    gate.region = None
    let_walk(s, *((6.5 + gap, y) for y in np.linspace(2.5, 6.5, 20)))
    way = s.obstacles.walked(s.tick)
    assert wait(departure, s, s.config.traffic.wait_time + 0.5) is leaves
    if leaves:
        ends = np.hypot(*(way - s.tube.points[-1]).T)
        assert ends.min() > 1.5 * s.obstacle_clearance


ALCOVE = room(9.0, 9.0, (0.05, 0.05, 1.25, 4.0), (2.45, 0.05, 8.95, 4.0))
LONG_AISLE = room(9.0, 14.0, (0.05, 0.05, 1.35, 9.0), (2.35, 0.05, 8.95, 9.0))
STATION = (1.85, 0.5)


def done_at_station(grid):
    """Return a robot that has just reached its last station, at the end of a blind aisle."""
    s = robot_in(grid, Pose(*STATION, 0.0))
    lease = Lease()
    lease.aim(s, STATION)
    lease.update(s)
    lease.aim(s, None)
    return Departure(Gate(None), lease), lease, s


def in_alcove(*others):
    """Return a robot without a goal at the end of a blind aisle, where its last station was."""
    departure, lease, s = done_at_station(ALCOVE)
    for _ in range(40):
        lease.update(s)
        s.tick += 1
    hear(s, *others)
    return departure, s


def test_a_dead_end_is_left_for_who_wants_its_station():
    """The next robot pushed it, and stood in its way out: 38 of 48 goals in hall 161."""
    asking = beacon(2, 1.85, 5.0, station=STATION, station_tick=50, priority=base_priority(2, 5, 2))
    departure, s = in_alcove(asking)
    assert wait(departure, s, s.config.traffic.wait_time + 0.5)
    assert s.tube.points[-1][1] > 4.0
    departure, s = in_alcove()
    assert not wait(departure, s, s.config.traffic.wait_time + 0.5)
