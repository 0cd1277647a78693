"""Leases in the order of request."""

import math

import numpy as np
import pytest

from swarm_common.model.beacon import SIGHTED_ASKS
from swarm_common.model.records import CONTROL_PERIOD, Pose
from swarm_nav.core.config import HoldingConfig
from swarm_nav.core.rank import CLASS_HOLDING, base_priority
from swarm_nav.perception.dynamic_obstacles import WALKED_TICKS
from swarm_nav.traffic.lease import Lease
from tests.fakes.decisions import arbiter_of
from tests.fakes.navigation import beacon, config, hear, let_walk, robot_in, room, seen

HALL = room(12.0, 12.0)
STATION = (6.0, 1.0)
NEAR = Pose(6.0, 2.8, 0.0)


def waiting(robot, tick, station=STATION):
    return beacon(robot, 2.0, 10.0, station=station, station_tick=tick)


def lease_of(s, *others):
    lease = Lease()
    lease.aim(s, STATION)
    hear(s, *others) if others else None
    lease.update(s)
    return lease


def test_a_lease_is_asked_for_near_the_station_not_behind_a_wall():
    s = robot_in(HALL, Pose(6.0, 1.1 + HoldingConfig().request_distance, 0.0))
    lease = lease_of(s)
    assert lease.tick == 0
    s.pose = NEAR
    s.tick = 150
    lease.update(s)
    assert lease.tick == 150
    s.tick = 200
    lease.update(s)
    assert lease.tick == 150
    # A robot in the next room would get its turn and then drive a long way through the queue.
    two_rooms = room(12.0, 12.0, (0.0, 4.0, 11.0, 4.2))
    behind = robot_in(two_rooms, Pose(2.0, 5.0, 0.0))
    before = robot_in(two_rooms, Pose(2.0, 3.0, 0.0))
    for s, is_near in ((behind, False), (before, True)):
        lease = Lease()
        lease.aim(s, (2.0, 1.5))
        lease.update(s)
        assert (lease.tick > 0) is is_near


def test_the_place_is_the_number_of_earlier_requests_of_the_living():
    s = robot_in(HALL, NEAR, robot_id=5)
    lease = lease_of(
        s,
        waiting(2, 50),
        waiting(3, 100),  # the same tick, smaller id
        waiting(7, 100),  # the same tick, larger id
        waiting(8, 101),
        waiting(9, 0),  # has not requested yet
        waiting(10, 40, (6.0, 9.0)),  # another station
    )
    assert lease.place == 2
    s = robot_in(HALL, NEAR, robot_id=5)
    hear(s, waiting(2, 50), tick=60)
    lease = Lease()
    lease.aim(s, STATION)
    lease.update(s)
    assert lease.place == 0


def test_all_contenders_agree_on_one_order():
    requests = {2: 90, 3: 70, 4: 90, 5: 80}
    places = {}
    for robot, tick in requests.items():
        s = robot_in(HALL, NEAR, robot_id=robot)
        s.tick = tick
        lease = lease_of(s)
        s.tick = 100
        hear(s, *(waiting(other, t) for other, t in requests.items() if other != robot))
        lease.update(s)
        places[robot] = lease.place
    assert places == {3: 0, 5: 1, 2: 2, 4: 3}


def test_who_has_no_turn_inherits_nothing():
    """One that had lost its turn kept the priority: it stood in single lanes and was not pushed."""
    s = robot_in(HALL, NEAR, 5, config(holding__approach_slots=1))
    rank = base_priority(CLASS_HOLDING, 0, 7)
    later = beacon(7, 2.0, 10.0, station=STATION, station_tick=150, priority=rank)
    lease = lease_of(s, later)
    assert s.donations.station > rank
    s.tick += 1
    hear(s, later, waiting(2, 50))
    lease.update(s)
    assert lease.place == 1
    assert s.donations.station == 0


def test_a_new_target_gives_the_lease_back_and_the_same_one_keeps_it():
    s = robot_in(HALL, NEAR)
    lease = lease_of(s)
    lease.aim(s, STATION)
    assert lease.tick == 100
    lease.aim(s, (1.0, 1.0))
    assert (lease.tick, lease.place) == (0, 0)
    lease.aim(s, None)
    assert lease.station is None


@pytest.mark.parametrize(("place", "slots", "turn"), [(0, 1, True), (1, 1, False), (2, 3, True)])
def test_as_many_as_there_are_slots_may_approach(place, slots, turn):
    lease = Lease(STATION, 10, place)
    assert lease.is_turn(HoldingConfig(approach_slots=slots)) is turn


@pytest.mark.parametrize(("ahead", "holds"), [(2, False), (6, False), (30, True)])
def test_a_long_queue_holds_farther_from_the_station(ahead, holds):
    s = robot_in(HALL, Pose(6.0, 4.9, 0.0), robot_id=60)
    lease = lease_of(s, *(waiting(robot, 50) for robot in range(1, ahead + 1)))
    assert lease.place == ahead
    assert lease.is_too_near(s) is holds
    free = lease.kept_free(s)
    assert free.ravel()[s.planner.lattice.node_of(*s.stop_point)] == holds


ALCOVE = room(8.0, 8.0, (1.2, 6.4, 1.3, 8.0))  # 1.2 m wide and 1.6 m deep, in a corner
DEAD_END = (0.45, 7.5)


def in_alcove(robot, *others, pose):
    s = robot_in(ALCOVE, pose, robot_id=robot)
    hear(s, *others) if others else None
    lease = Lease()
    lease.aim(s, DEAD_END)
    lease.update(s)
    return s, lease


def test_a_dead_end_belongs_to_one_robot():
    first = waiting(2, 50, DEAD_END)
    s, lease = in_alcove(5, first, pose=Pose(0.9, 5.0, 0.0))
    assert lease.place == 1
    assert not lease.is_turn(s.config.holding)
    s.pose = Pose(0.65, 6.6, 0.0)
    s.tube.reset(s.pose)
    assert lease.is_too_near(s)
    assert lease_of(robot_in(HALL, NEAR, robot_id=5), waiting(2, 50)).is_turn(s.config.holding)


@pytest.mark.parametrize(("ahead", "holds"), [(0, False), (12, True)])
def test_a_queue_for_a_dead_end_holds_at_a_distance(ahead, holds):
    """Robots without a turn came up to its mouth: a crowd that kept out whose turn it was."""
    others = (waiting(robot, 50, DEAD_END) for robot in range(20, 20 + ahead))
    s, lease = in_alcove(5, *others, pose=Pose(1.5, 5.2, 0.0))
    assert lease.place == ahead
    assert lease.is_too_near(s) is holds


@pytest.mark.parametrize("following", [(6.0, 2.0), None])
def test_a_dead_end_is_given_back_once_the_robot_is_out(following):
    """Given back at the goal, the next robot would meet the one that leaves in the dead end."""
    s, lease = in_alcove(5, pose=Pose(*DEAD_END, 0.0))
    lease.aim(s, None)
    lease.aim(s, following)
    s.tick = 120
    lease.update(s)
    assert (lease.station, lease.tick) == (DEAD_END, 100)
    assert lease.is_turn(s.config.holding)
    if following is None:
        s.tick = 200  # nobody waits longer for a robot that has nothing to do
    else:
        s.pose = Pose(4.0, 3.0, 0.0)
        s.tube.reset(s.pose)
    lease.update(s)
    assert (lease.station, lease.tick > 0) == (following, following is not None)


@pytest.mark.parametrize("station", [STATION, DEAD_END])
def test_a_robot_that_is_served_keeps_its_station(station):
    if station == DEAD_END:
        s, lease = in_alcove(5, pose=Pose(*DEAD_END, 0.0))
    else:
        s = robot_in(HALL, Pose(*STATION, 0.0), robot_id=5)
        lease = lease_of(s)
    lease.aim(s, None)
    lease.keep(s)
    s.tick = 700
    rank = base_priority(CLASS_HOLDING, 0, 2)
    other = beacon(2, 2.0, 10.0, station=station, station_tick=150, priority=rank)
    hear(s, other)
    lease.update(s)
    assert (lease.station, lease.tick, lease.place) == (station, 100, 0)
    assert s.donations.station > 0  # who waits for it lends it its rank
    lease.aim(s, (9.0, 9.0))
    s.pose = Pose(9.0, 9.0, 0.0)
    s.tube.reset(s.pose)
    lease.update(s)
    assert lease.station == (9.0, 9.0)


def test_a_robot_that_left_its_station_does_not_keep_it():
    s = robot_in(HALL, NEAR, robot_id=5)
    lease = lease_of(s)
    lease.aim(s, None)
    lease.keep(s)
    assert lease.station is None


# aisles 1.6 m wide: a blind one, 5 m deep, and one that is open on both sides
BLIND = room(12.0, 9.0, (0.0, 0.0, 5.0, 4.0), (0.0, 5.6, 5.0, 9.0))
OPEN = room(16.0, 9.0, (4.0, 0.0, 9.0, 4.0), (4.0, 5.6, 9.0, 9.0))


def in_aisle(grid, deep, *others):
    s = robot_in(grid, Pose(deep + 1.0, 4.8, 0.0), robot_id=5)
    s.stations = ((deep, 4.8), (deep + 1.5, 4.8))
    hear(s, *others) if others else None
    lease = Lease()
    lease.aim(s, s.stations[0])
    lease.update(s)
    return s, lease


@pytest.mark.parametrize(("grid", "deep", "is_blind"), [(BLIND, 0.6, True), (OPEN, 5.8, False)])
def test_the_stations_of_a_blind_aisle_share_its_room(grid, deep, is_blind):
    """Three at each of two stations did not get out of each other's way in a blind aisle."""
    here = waiting(2, 50, (deep, 4.8)), waiting(3, 60, (deep + 1.5, 4.8))
    s, lease = in_aisle(grid, deep, *here)
    assert lease.place == (2 if is_blind else 1)
    assert lease.is_shared is is_blind
    assert lease.is_turn(s.config.holding) is not is_blind
    assert lease.is_too_near(s) is is_blind
    assert in_aisle(grid, deep, here[1])[1].is_turn(s.config.holding)


def test_a_small_closed_room_is_no_blind_aisle():
    """Its last corner counted as a mouth: one robot at a time drove, and the others parked."""
    closet = room(3.0, 1.65)  # 8 robots started in it
    s = robot_in(closet, Pose(2.4, 0.5, 0.0), robot_id=5)
    s.stations = ((0.55, 0.55), (1.9, 1.1))
    hear(s, waiting(2, 50, s.stations[1]))
    lease = Lease()
    lease.aim(s, s.stations[0])
    lease.update(s)
    assert not lease.is_shared
    assert lease.place == 0


def test_a_blind_aisle_is_given_back_once_the_robot_is_out():
    s, lease = in_aisle(BLIND, 0.6)
    lease.aim(s, (9.0, 2.0))
    lease.update(s)
    assert lease.is_leaving
    s.pose = Pose(8.0, 4.8, 0.0)
    s.tube.reset(s.pose)
    lease.update(s)
    assert lease.station == (9.0, 2.0)


def test_who_leaves_a_blind_aisle_ranks_above_who_goes_in_whoever_asked_first():
    rank = base_priority(CLASS_HOLDING, 0, 7)
    late = beacon(7, 8.0, 2.0, station=(0.6, 4.8), station_tick=150, priority=rank)
    goes_in, _ = in_aisle(BLIND, 0.6, late)
    s, lease = in_aisle(BLIND, 0.6, late, waiting(2, 50, (2.1, 4.8)))
    assert (lease.place, s.donations.station) == (1, 0)
    lease.aim(s, (9.0, 2.0))
    lease.update(s)
    assert lease.is_leaving
    assert s.donations.station > goes_in.donations.station > rank


LONG = room(14.0, 9.0, (0.0, 0.0, 8.0, 4.0), (0.0, 5.0, 8.0, 9.0))  # 1 m wide, 8 m deep, blind
END = (0.8, 4.5)


def before_long_aisle(*others, x=10.0):
    """Return a robot whose station is out of its radio's range, and its lease."""
    s = robot_in(LONG, Pose(x, 4.5, math.pi), robot_id=5)
    way = np.arange(x, END[0], -0.05)
    s.tube.adopt(np.column_stack((way, np.full(len(way), 4.5))))
    hear(s, *others) if others else None
    lease = Lease()
    lease.aim(s, END)
    lease.update(s)
    return s, lease


def on_the_way(asks, x=2.0):
    (teller,) = seen(95, (x, 4.5))
    teller["sighted_id"][0] |= SIGHTED_ASKS if asks else 0
    return teller


def test_long_single_lanes_are_asked_for_and_waited_for_in_time():
    s, lease = before_long_aisle()
    assert s.distance_to(*END) > s.config.traffic.radio_range
    assert lease.tick == 100
    assert lease.is_turn(s.config.holding)

    def too_near(ahead):
        others = (waiting(robot, 50, END) for robot in range(20, 20 + ahead))
        s, lease = before_long_aisle(*others, x=11.0)
        return lease.is_too_near(s)

    assert [too_near(ahead) for ahead in (1, 12)] == [False, True]


@pytest.mark.parametrize(("asks", "x"), [(True, 2.0), (False, 2.0), (True, 10.0)])
def test_who_asked_and_was_seen_on_single_lanes_out_of_hearing_takes_room(asks, x):
    """Seven robots were in an aisle for one, which is longer than those outside hear."""
    rank = base_priority(CLASS_HOLDING, 0, 7)
    later = beacon(7, 12.0, 2.0, station=END, station_tick=150, priority=rank)
    s, lease = before_long_aisle(on_the_way(asks, x), later)
    assert lease.place == 0
    is_there = asks and x < 8.0
    assert lease.is_turn(s.config.holding) is not is_there
    assert (lease.kept_free(s) is not None) is is_there  # it does not park there meanwhile
    assert (s.donations.station == 0) is is_there  # and ranks below who has to come out
    s.pose = Pose(7.0, 4.5, math.pi)  # who is on the lanes goes on, above those who wait
    s.tube.reset(s.pose)
    lease.update(s)
    assert lease.is_turn(s.config.holding)
    assert s.donations.station > 0


def test_who_gets_its_goal_on_single_lanes_holds_them_until_it_is_out():
    """One that started deep in a blind aisle was pushed back by who came for a station there."""
    rank = base_priority(CLASS_HOLDING, 0, 7)
    s = robot_in(LONG, Pose(2.0, 4.5, 0.0), robot_id=5)
    hear(s, beacon(7, 12.0, 2.0, station=END, station_tick=50, priority=rank))
    lease, elsewhere = Lease(), (12.0, 8.0)
    lease.aim(s, elsewhere)
    lease.update(s)
    s.tick += 1
    lease.update(s)
    assert (lease.station, lease.is_leaving) == ((2.0, 4.5), True)
    later = beacon(7, 12.0, 2.0, station=END, station_tick=150, priority=rank)
    goes_in = before_long_aisle(later)[0]
    assert s.donations.station > goes_in.donations.station > rank
    s.pose = Pose(10.0, 4.5, 0.0)
    s.tube.reset(s.pose)
    lease.update(s)
    assert (lease.station, lease.is_leaving) == (elsewhere, False)
    lease.aim(s, END)  # on the lanes for which it has a goal it is none that leaves
    s.pose = Pose(2.0, 4.5, 0.0)
    s.tube.reset(s.pose)
    lease.update(s)
    assert (lease.station, lease.is_leaving) == (END, False)


def test_a_smaller_margin_that_leaves_no_single_lanes_is_taken():
    """The look-up of lanes that are not there any more ended the process."""
    wider = room(20.0, 9.0, (0.0, 0.0, 8.0, 4.0), (0.0, 5.4, 8.0, 9.0))
    s = robot_in(wider, Pose(18.0, 5.0, math.pi), parameters=config(traffic__safety_margin=0.1))
    lease = Lease()
    lease.aim(s, (1.5, 5.0))
    for margin in (0.1, 0.05):
        arbiter_of(s).configure(config(traffic__safety_margin=margin))
        lease.update(s)
    assert lease.tick == 0


THROUGH = room(20.0, 9.0, (4.0, 0.0, 15.0, 4.0), (4.0, 5.0, 15.0, 9.0))  # 1 m wide, 11 m long
AT_WEST_END = (5.0, 4.5)


def test_the_queue_for_large_single_lanes_begins_beyond_all_of_their_mouths():
    """Nine robots that waited before the far mouth kept in those that came out."""
    s = robot_in(THROUGH, Pose(16.3, 4.5, math.pi), robot_id=60)
    s.tube.adopt(np.column_stack((np.arange(16.3, 5.0, -0.05), np.full(226, 4.5))))
    hear(s, *(waiting(robot, 50, AT_WEST_END) for robot in range(1, 7)))
    lease = Lease()
    lease.aim(s, AT_WEST_END)
    lease.update(s)
    assert lease.place == 6
    assert lease.is_too_near(s)
    free = lease.kept_free(s)
    assert free.ravel()[s.planner.lattice.node_of(*s.stop_point)]


def watch(s, lease, seconds, *marks):
    s.obstacles.points = np.array(marks).reshape(-1, 2)
    for _ in range(s.ticks(seconds)):
        s.tick += 1
        lease.update(s)


ON_IT, BESIDE_IT = (6.0, 1.1), (6.0, 1.3)


def test_what_the_lidar_sees_on_a_station_for_long_bars_it():
    s = robot_in(HALL, NEAR, 1, config(holding__station_patience=20.0))
    lease = lease_of(s)
    watch(s, lease, 30.0, BESIDE_IT)
    assert not lease.is_barred(s)
    watch(s, lease, 19.0, ON_IT)
    assert not lease.is_barred(s)
    watch(s, lease, 2.0, ON_IT)
    assert lease.is_barred(s)
    watch(s, lease, 2.0)
    assert not lease.is_barred(s), "it is free again"


def test_somebody_who_walks_over_a_station_does_not_bar_it():
    s = robot_in(HALL, NEAR, 1, config(holding__station_patience=20.0))
    lease = lease_of(s)
    for _ in range(30):
        watch(s, lease, 3.0, ON_IT)
        watch(s, lease, 1.5)
        assert not lease.is_barred(s)


def test_who_walks_to_and_fro_on_a_station_does_not_bar_it():
    """Somebody penned in between two robots was told to be something that does not move."""
    s = robot_in(HALL, NEAR, 1, config(holding__station_patience=20.0))
    lease = lease_of(s)
    for _ in range(30):
        let_walk(s, BESIDE_IT)
        watch(s, lease, 1.0, ON_IT)
    assert not lease.is_barred(s)
    watch(s, lease, WALKED_TICKS * CONTROL_PERIOD, ON_IT)
    assert not lease.is_barred(s)
    watch(s, lease, 21.0, ON_IT)
    assert lease.is_barred(s), "nobody has walked there for a while"


def test_another_try_does_not_wait_anew_for_a_station_that_was_not_seen_free():
    s = robot_in(HALL, NEAR, 1, config(holding__station_patience=20.0))
    lease = lease_of(s)
    watch(s, lease, 21.0, ON_IT)
    lease.aim(s, None)
    watch(s, lease, 1.0, ON_IT)
    lease.aim(s, STATION)
    watch(s, lease, 0.1, ON_IT)
    assert lease.is_barred(s)
    lease.aim(s, (6.0, 9.0))
    watch(s, lease, 0.1, ON_IT)
    assert not lease.is_barred(s)
