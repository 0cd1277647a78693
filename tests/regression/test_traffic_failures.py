"""Each failure that cost a design of this kind a contact or a deadlock, as a test of its cure.

The first part was known before the first line was written, the second was met on the way.
"""

import math

import numpy as np
import pytest

from swarm_common.model.beacon import FLAG_ACTIVE, FLAG_STUCK
from swarm_common.model.records import Pose, Twist
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import GoalKind, Outcome
from swarm_nav.core.rank import CLASS_DRIVING, base_priority, inherited_by_holder
from swarm_nav.perception.neighbor_table_kernels import HELD
from swarm_nav.planning.planner import SPACING
from swarm_nav.reservation import tube_kernels
from swarm_nav.traffic.arbiter import Arbiter
from swarm_nav.traffic.held_space_rules import DropUnused
from swarm_nav.traffic.lease import Lease
from swarm_nav.traffic.right_of_way import RightOfWay, refuge_path, way_of
from swarm_nav.traffic.single_lanes import SingleLanes
from tests.fakes import aisle, doorway
from tests.fakes.decisions import act, push
from tests.fakes.navigation import RADIUS, Squad, beacon, config, hear, robot_in, room
from tests.fakes.protocol import Crowd, Schedule

REACH = 2 * RADIUS
HALL = room(8.0, 8.0)
AISLE = room(8.0, 1.8)
HIGH = base_priority(CLASS_DRIVING, 0, 2)


def priority_of(record):
    return int(record["priority"][0]) << 32 | int(record["priority"][1])


def path_of(s, *corners):
    """Give a robot a path through corners and let everybody know of it for long enough."""
    pieces = [np.array(s.stop_point)[None, :]]
    for corner in corners:
        start = pieces[-1][-1]
        count = round(math.dist(start, corner) / SPACING)
        pieces.append(start + np.linspace(0.0, 1.0, count + 1)[1:, None] * (corner - start))
    s.tube.adopt(np.vstack(pieces))
    for tick in range(s.tick - 5, s.tick):
        s.tube.publish(s.pose, tick)


def taken(s, *others):
    reservation = Arbiter(s, SingleLanes())
    hear(s, *others)
    before = s.tube.stop
    reservation.extend()
    return s.tube.stop - before


# 1 -------------------------------------------------------------------------------------------


def test_priorities_are_static_compared_as_published_and_broken_by_the_id():
    pair = Squad(AISLE, [Pose(1.0, 0.9, 0.0), Pose(7.0, 0.9, math.pi)])
    pair.send(0, Pose(7.0, 0.9, 0.0))
    pair.send(1, Pose(1.0, 0.9, 0.0))
    seen: list[set[int]] = [set(), set()]
    while not (pair.ended(0) or pair.ended(1)) and pair.tick < 600:
        pair.run(1)
        for index, record in enumerate(pair.beacons):
            assert priority_of(record) == pair.robots[index]._s.priority
            if not record["yields_for"]:
                seen[index].add(priority_of(record))
    # one before the goal counts, one while driving; waiting changes nothing
    assert [len(priorities) <= 2 for priorities in seen] == [True, True]
    granted = []
    for own_id, other_id in ((3, 9), (9, 3)):
        s = robot_in(HALL, Pose(3.0, 4.0, 0.0), own_id)
        s.priority = HIGH - 1
        path_of(s, (5.0, 4.0))
        contested = [(3.75 - 0.05 * k, 4.0) for k in range(4)]
        granted.append(taken(s, beacon(other_id, 3.8, 4.0, wanted=contested, priority=HIGH - 1)))
    assert granted[0] > granted[1]


# 2 -------------------------------------------------------------------------------------------


def test_of_two_heirs_of_one_priority_only_the_one_with_the_smaller_id_pushes():
    """Both had inherited from a robot that had waited for one's station, then for the other's.

    Each was blocked by the other's body, neither made way, and seven robots stood for 400 s.
    """
    for own_id, other_id in ((3, 9), (9, 3)):
        s = robot_in(HALL, Pose(4.0, 4.0, 0.0), own_id)
        s.own_priority = s.priority = inherited_by_holder(HIGH)
        patience = s.config.traffic.push_ticks
        equal = {
            "priority": inherited_by_holder(HIGH),
            "blocked_by": own_id,
            "blocked_ticks": patience,
        }
        hear(s, beacon(other_id, 3.2, 4.0, **equal))
        assert (RightOfWay().pusher(s) is not None) == (other_id < own_id)
        hear(s, beacon(other_id, 3.2, 4.0, **(equal | {"blocked_ticks": patience - 1})))
        assert RightOfWay().pusher(s) is None


def test_equal_priorities_never_let_two_tubes_meet():
    assert Crowd(Schedule(17, count=6, whims=0.05)).run().excess >= -0.0201


# 3 -------------------------------------------------------------------------------------------


def test_the_request_of_a_blocked_robot_does_not_block_who_makes_way():
    s = robot_in(HALL, Pose(4.0, 4.0, 0.0))
    s.donations.yields_for = 2
    path_of(s, (4.0, 5.0))
    through_us = [(3.35 + 0.05 * k, 4.0) for k in range(7)]
    pusher = beacon(2, 3.3, 4.0, wanted=through_us, priority=HIGH, blocked_by=1, blocked_ticks=9)
    assert taken(s, pusher) == 7


def test_a_robot_asks_for_nothing_while_its_blocker_makes_way():
    s = robot_in(HALL, Pose(4.0, 4.0, 0.0))
    path_of(s, (6.0, 4.0))
    assert taken(s, beacon(7, 4.6, 4.0, yields_for=s.robot_id)) == 0
    assert len(s.tube.publish(s.pose, s.tick)[1]) == 0
    assert len(s.tube.requests) == 0


# 4 -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("age", [4, 8, 16])
def test_a_silent_robot_is_waited_for_however_little_it_may_have_moved(age):
    s = robot_in(HALL, Pose(3.0, 4.0, 0.0))
    path_of(s, (5.0, 4.0))
    silent = beacon(7, 5.0, 4.0, tick=s.tick - age)
    silent["heard"][0] = s.robot_id << 16 | (s.tick - age - 1)
    s.neighbors.receive(np.array([silent]), 3.0, 4.0)
    s.neighbors.refresh(s.tick)
    Arbiter(s, SingleLanes()).extend()
    assert s.tube.stop == (0 if age > 4 else s.tube.stop)
    assert SPACING * s.tube.stop <= 2.0 - REACH


@pytest.mark.parametrize("seed", [1, 5, 7, 9])
def test_lossy_radio_never_lets_two_tubes_meet(seed):
    assert Crowd(Schedule(seed, loss=0.5, ticks=400)).run().excess >= -0.0201


# 5 -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("change", ["withdraw", "cut", "path", "priority"])
def test_a_withdrawn_request_restarts_the_confirmation(change):
    s = robot_in(HALL, Pose(3.0, 4.0, 0.0))
    path_of(s, (5.0, 4.0))
    match change:
        case "withdraw":
            s.tube.withdraw()
            s.tube.publish(s.pose, s.tick)
            s.tick += 1
        case "cut":
            s.tube.cut()
        case "path":
            s.tube.adopt(s.tube.points[s.tube.stop :] * (1.0, 1.0))
        case "priority":
            s.tube.forget_requests()
    assert s.tube.span[2] == -1
    assert taken(s) == 0


# 6 -------------------------------------------------------------------------------------------


def test_replanning_every_tick_is_never_granted_so_routes_pause_longer():
    s = robot_in(HALL, Pose(3.0, 4.0, 0.0))
    for _ in range(30):
        s.tick += 1
        path = np.column_stack((np.arange(3.0, 5.0, SPACING), np.full(40, 4.0)))
        s.tube.adopt(path)
        assert taken(s) == 0
        s.tube.publish(s.pose, s.tick)
    assert s.retry_ticks > s.config.traffic.confirmations + 2


def test_a_blocked_robot_replans_no_faster_than_it_can_be_granted():
    jam = Squad(room(6.0, 0.9), [Pose(1.0, 0.45, 0.0), Pose(3.0, 0.45, 0.0)])
    jam.robots[1].services.deactivate()
    jam.send(0, Pose(5.0, 0.45, 0.0))
    jam.run(200)
    assert jam.robots[0].status().replans <= 20.0 / NavConfig().traffic.retry_time + 1


# 7, 8 ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False))
@pytest.mark.parametrize("gap", [-0.012, -0.003, 0.0, 0.004, 0.02])
def test_a_refuge_path_is_granted_even_where_it_grazes_the_pusher(angle, gap):
    s = robot_in(HALL, Pose(4.03, 3.98, 0.0))
    x = 4.03 - (REACH + gap) * math.cos(angle)
    y = 3.98 - (REACH + gap) * math.sin(angle)
    way = [(x + 0.1 * k * math.cos(angle), y + 0.1 * k * math.sin(angle)) for k in range(20)]
    pusher = beacon(2, x, y, intent=way, wanted=way[1:4], priority=HIGH)
    pusher["blocked_by"], pusher["blocked_ticks"] = s.robot_id, 9
    leaves(s, pusher)


@pytest.mark.parametrize("y", [0.30, 0.34, 0.42, 0.6, 0.9])
def test_along_a_wall_a_refuge_is_found_and_granted(y):
    s = robot_in(AISLE, Pose(4.0, y, 0.0))
    way = [(3.35 + 0.1 * k, y) for k in range(20)]
    pusher = beacon(2, 3.35, y, intent=way, wanted=way[1:4], priority=HIGH)
    pusher["blocked_by"], pusher["blocked_ticks"] = s.robot_id, 9
    leaves(s, pusher)


def leaves(s, pusher):
    """Push a robot; fail unless it finds a way and is granted a part once the pusher waits."""
    hear(s, pusher)
    right = RightOfWay()
    push(right, s)
    assert not right.is_stuck
    assert len(s.tube.points) > 3
    for tick in range(s.tick - 5, s.tick):
        s.tube.publish(s.pose, tick)
    pusher["wanted_size"] = 0  # it saw that it is made way for
    assert taken(s, pusher) >= 3


# 9 -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("corner", [0.6, 1.2, 2.0, 2.8, math.pi])
def test_a_cusp_is_tracked_within_the_margin_and_left_soon(corner):
    one = Squad(HALL, [Pose(2.0, 4.0, 0.0)])
    tip = np.array((4.0, 4.0))
    back = tip + 1.5 * np.array((math.cos(corner), math.sin(corner)))
    path = np.vstack((np.linspace((2.0, 4.0), tip, 41), np.linspace(tip, back, 31)[1:]))
    one.run(20)
    one.send(0, kind=GoalKind.FOLLOW_PATH, path_map=path)
    worst = 0.0
    while not one.ended(0) and one.tick < 400:
        one.run(1)
        here = one.bodies[0].pose
        worst = max(worst, float(np.hypot(*(path - (here.x, here.y)).T).min()))
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert worst < 0.047 + SPACING / 2


def test_a_claim_that_is_not_driven_is_dropped_whatever_the_robot_does():
    s = robot_in(HALL, Pose(2.0, 4.0, 0.0))
    path_of(s, (5.0, 4.0))
    s.tube.stop = 7
    unused = DropUnused(s)
    dropped = False
    for _ in range(s.ticks(s.config.traffic.stuck_time) + 2):
        s.tick += 1
        s.twist = Twist(0.0, 0.0, 1.5)  # turns on the spot
        proposal = unused.propose(s)
        act(s, proposal)
        dropped = dropped or proposal is not None
    assert dropped
    assert len(s.tube.points) == 1


# 10 ------------------------------------------------------------------------------------------


def test_who_is_blocked_by_a_robot_without_a_refuge_steps_back():
    s = robot_in(AISLE, Pose(4.0, 0.9, 0.0))
    right = RightOfWay()
    s.blocked_by, s.blocked_ticks = 7, 30
    hear(s, beacon(7, 4.6, 0.9, flags=FLAG_STUCK | FLAG_ACTIVE))
    assert push(right, s)
    assert right.is_retreating
    assert math.dist(s.tube.points[-1], (4.0, 0.9)) > 0.9


def test_a_robot_at_the_end_of_a_blind_alley_gets_out():
    alley = room(7.0, 4.0, (3.0, 0.0, 7.0, 1.55), (3.0, 2.45, 7.0, 4.0))
    pair = Squad(alley, [Pose(6.4, 2.0, 0.0), Pose(4.0, 2.0, 0.0)])
    pair.send(0, Pose(1.0, 1.0, 0.0))
    pair.send(1, Pose(6.4, 2.0, 0.0))
    pair.run_until(lambda: bool(pair.ended(0) and pair.ended(1)), 3000)
    assert [pair.ended(k)[0].outcome for k in (0, 1)] == [Outcome.SUCCEEDED] * 2


# 11 ------------------------------------------------------------------------------------------


def test_without_a_gate_a_blind_aisle_fills_up_and_with_it_does_not():
    """A hundred robots without one jammed the aisle of the factory hall for good."""
    most = {}
    for density in (0.0, 0.05):
        census = aisle.Census()
        aisle.party(0, limit=70.0, holding__region_density=density).run(census.watch())
        most[density] = census.most
    assert most[0.0] >= len(aisle.HOMES) - 1
    assert most[0.05] < most[0.0]


# 12 ------------------------------------------------------------------------------------------


@pytest.mark.long
def test_more_leases_and_shorter_claims_are_no_cure_for_a_station_that_is_full():
    """They were within noise: what a station and a blind aisle allow is given by their shape."""
    defaults = aisle.party(0, count=4).run()
    assert defaults.is_flawless
    assert defaults.makespan is not None
    for changes in ({"holding__approach_slots": 5}, {"traffic__held_length": 0.25}):
        result = aisle.party(0, count=4, **changes).run()
        assert result.is_flawless
        assert result.makespan == pytest.approx(defaults.makespan, rel=0.15)


# 13 ------------------------------------------------------------------------------------------


def test_two_streams_pass_in_a_corridor_two_robots_wide():
    rows = [Pose(0.8 + 0.9 * k, 0.55, 0.0) for k in range(3)]
    rows += [Pose(9.2 - 0.9 * k, 1.25, math.pi) for k in range(3)]
    swarm = Squad(room(10.0, 1.8), rows, config(holding__request_distance=0.1))
    for index in range(6):
        swarm.send(index, rows[(index + 3) % 6])
    swarm.run_until(lambda: all(swarm.ended(k) for k in range(6)), 2500)
    assert all(swarm.ended(k)[0].outcome is Outcome.SUCCEEDED for k in range(6))


# 14 ------------------------------------------------------------------------------------------


def test_a_door_at_which_orca_jams_is_passed_by_all():
    """Who only avoids, gives way to nobody: opposing robots stop face to face."""
    opposing = doorway.party(0, each=3, limit=100.0)
    opposing.method = "orca"
    jammed = opposing.run()
    assert jammed.goals_reached < 6
    opposing.method = "ours"
    passed = opposing.run()
    assert passed.is_flawless


# met on the way ------------------------------------------------------------------------------


def asking(wanted, end):
    record = beacon(2, *end, wanted=wanted)
    return np.frombuffer(record.tobytes(), np.float32)


def test_requests_end_only_beside_who_would_be_denied():
    """Two yielding robots were granted the space beyond a point that only one held impassable."""
    held = np.array(((0.0, 0.0),), np.float32)
    wanted = np.array([(0.05 * k, REACH - 0.01) for k in range(-3, 4)], np.float32)
    words = asking(wanted, (-0.2, REACH - 0.01))
    for slack, points in ((0.02, 7), (0.0, 0)):
        size = tube_kernels.grantable_prefix(words, 7, HELD, held, 1, REACH, slack)
        assert (size == 7) == (points == 7)
    held = np.array(((0.0, 0.0),), np.float32)
    wanted = np.array([(0.5 + 0.05 * k, 0.0) for k in range(1, 8)], np.float32)
    words = asking(wanted, (0.5, 0.0))
    assert tube_kernels.grantable_prefix(words, 7, HELD, held, 1, REACH, 0.02) == 7


@pytest.mark.parametrize("seed", [0, 14])
def test_a_mute_robot_that_drives_on_is_noticed_by_itself(seed):
    """Its neighbours took it for dead where it was last heard, and drove into its space."""
    assert Crowd(Schedule(seed, mute=2, loss=0.2, ticks=400)).run().excess >= -0.0201


def test_a_robot_that_nobody_acknowledges_stands_and_says_so():
    pair = Squad(HALL, [Pose(2.0, 4.0, 0.0), Pose(3.0, 5.0, 0.0)])
    pair.run(20)
    pair.send(0, Pose(6.0, 4.0, 0.0))
    pair.run(40)
    assert pair.bodies[0].twist.vx > 0.1
    listener = beacon(9, 4.5, 4.8)  # says that it hears nobody
    for tick in range(pair.tick, pair.tick + 60):
        listener["tick"] = tick - 1
        neighbors = pair.robots[0]._s.neighbors
        here = pair.bodies[0].pose
        neighbors.receive(np.array([listener]), here.x, here.y)
        pair.run(1)
    assert pair.bodies[0].twist.vx == 0.0
    assert pair.robots[0].status().detail == "stands: Srobot9 does not hear it"


def test_what_a_lost_or_overtaken_beacon_said_is_past():
    """Twenty beacons may be lost before a death; the place must cover them."""
    for seed in (3, 8):
        outcome = Crowd(Schedule(seed, loss=0.8, deaths=0.003, deafness=0.003)).run()
        assert outcome.excess >= -0.0201
    s = robot_in(HALL, Pose(3.0, 4.0, 0.0))
    hear(s, beacon(7, 5.0, 4.0), tick=90)
    hear(s, beacon(7, 4.0, 4.0), tick=80)
    assert s.neighbors.beacons[0]["pose"][0] == 5.0


def blocked_by_us(x, robot, **fields):
    return beacon(
        robot, x, 4.0, **{"priority": HIGH, "blocked_by": 1, "blocked_ticks": 20} | fields
    )


def test_no_two_robots_push_each_other_nor_hand_on_for_ever():
    """Each made way for the other with the other's priority, which lived on by itself."""
    s = robot_in(HALL, Pose(4.0, 4.0, 0.0))
    hear(s, blocked_by_us(3.2, 2, yields_for=1))
    assert RightOfWay().pusher(s) is None
    hear(s, blocked_by_us(3.2, 2, yields_for=0))
    assert RightOfWay().pusher(s) == 0
    # In a circle of more than two it would outlive its source as well.
    s = robot_in(HALL, Pose(4.0, 4.0, 0.0))
    for hops, is_pushed in ((31, True), (32, False)):
        hear(s, blocked_by_us(3.2, 2, priority=HIGH - hops))
        assert (RightOfWay().pusher(s) is not None) == is_pushed


def test_who_has_the_station_ranks_above_all_who_wait_for_it():
    """A robot on the station was pushed about by those whom its leaving would have helped."""
    s = robot_in(HALL, Pose(4.0, 4.0, 0.0))
    lease = Lease()
    lease.aim(s, (4.5, 4.0))
    lease.update(s)
    s.tick += 20
    hear(s, beacon(2, 5.5, 4.0, priority=HIGH, station=(4.5, 4.0), station_tick=s.tick - 5))
    lease.update(s)
    assert lease.place == 0
    assert HIGH < s.donations.station < HIGH + 64


def test_a_thing_on_the_way_to_a_refuge_is_not_waited_for():
    """The smooth way cut a corner of it by 1 cm, for the LiDAR: thirteen robots stood for 600 s."""
    s = robot_in(HALL, Pose(4.0, 4.0, 0.0))
    right = RightOfWay()
    hear(s, blocked_by_us(3.2, 2, intent=[(3.3 + 0.1 * k, 4.0) for k in range(20)]))
    push(right, s)
    first = s.tube.points.copy()
    s.tick += s.ticks(s.config.traffic.stuck_time) + 1
    s.obstacle_ticks = s.ticks(s.config.traffic.stuck_time) + 1
    hear(s, blocked_by_us(3.2, 2, intent=[(3.3 + 0.1 * k, 4.0) for k in range(20)]))
    push(right, s)
    assert right.is_stuck
    assert not np.array_equal(first, s.tube.points)


def test_a_smooth_way_to_a_refuge_that_a_robot_bars_is_not_tried_again():
    """It kept off the wall and so led 1 cm nearer to the robot beside it: 35 stood for ever."""
    s = robot_in(HALL, Pose(4.0, 4.0, 0.0))
    right = RightOfWay()
    pusher = {"intent": [(3.3 + 0.1 * k, 4.0) for k in range(20)]}
    hear(s, blocked_by_us(3.2, 2, **pusher))
    push(right, s)
    first = s.tube.points.copy()
    for waited in (1, s.stuck_ticks + 1, s.retry_ticks, s.retry_ticks):
        s.tick += waited
        s.blocked_ticks += waited
        hear(s, blocked_by_us(3.2, 2, **pusher))
        push(right, s)
        is_the_same = np.array_equal(first, s.tube.points)
        assert is_the_same is (waited == 1)
    assert right.is_stuck


def test_refuge_search_is_deterministic():
    paths = []
    for _ in range(2):
        s = robot_in(HALL, Pose(4.0, 4.0, 0.0))
        hear(s, beacon(2, 3.3, 4.0, intent=[(3.3 + 0.1 * k, 4.0) for k in range(20)]))
        paths.append(refuge_path(s, s.stop_point, way_of(s, 0), s.reach(0), HIGH - 1))
    assert paths[0] is not None
    assert np.array_equal(paths[0], paths[1])
