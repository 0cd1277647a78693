"""The beacon says what the robot holds, wants and means to do; its bytes survive the radio."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.beacon import (
    BEACON_DTYPE,
    BEACON_SIZE,
    FLAG_ACTIVE,
    FLAG_STUCK,
    MODE_DONE,
    MODE_DRIVE,
    MODE_HOLD,
    MODE_YIELD,
    blank_beacon,
    deserialize_beacon,
    pack_head,
    record_of,
    serialize_beacon,
    serialize_neighbors,
    word_of,
    words_of,
)
from swarm_common.model.records import Pose
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.announcement import compose_beacon, compose_status
from swarm_nav.behaviour.behaviors import Behavior
from swarm_nav.behaviour.goal_manager import GoalManager
from swarm_nav.behaviour.goal_progress import GoalProgress
from swarm_nav.behaviour.parts import Parts
from swarm_nav.behaviour.rules import Leave, WaitForTurn
from swarm_nav.behaviour.state_machine import StateMachine
from swarm_nav.core.goals import Goal, GoalKind
from swarm_nav.core.rank import CLASS_DONE, CLASS_DRIVING, CLASS_HOLDING, Donations, base_priority
from swarm_nav.core.states import Event, MakingWay, State
from swarm_nav.interfaces import Proposal
from swarm_nav.traffic.departure import Departure
from swarm_nav.traffic.gate import Gate
from swarm_nav.traffic.holding import HoldingPattern
from swarm_nav.traffic.lease import Lease
from swarm_nav.traffic.right_of_way import RightOfWay
from swarm_nav.traffic.senses import Senses
from tests.fakes.decisions import arbiter_of
from tests.fakes.navigation import RADIUS, robot_in, room, waffle
from tests.fakes.neighbors import deserialize_neighbors

HALL = room(6.0, 6.0)
STATION = (4.0, 4.0)


def driving():
    s = robot_in(HALL, Pose(1.0, 1.0, 0.5), robot_id=4)
    s.tube.adopt(np.column_stack((np.arange(1.0, 4.0, 0.05), np.full(60, 1.0))))
    s.tube.stop = 7
    return s


def parts_of(
    s, state, lease, gate = None,
    right = None, sites = None,
):  # fmt: skip
    """Return the parts of a robot in a state, whose rule for it won in this tick."""
    holding, arbiter = HoldingPattern({}, []), arbiter_of(s)
    right, gate = right or RightOfWay(), gate or Gate(None)
    state_machine = StateMachine(s, holding, arbiter)
    state_machine.state, state_machine.holding_since = state, 60
    state_machine.is_waiting = state is State.HOLDING
    goal_manager = GoalManager(s, state_machine, lease, right, arbiter)
    parts = Parts(
        s, sites or Sites(), state_machine, goal_manager, right, Departure(gate, lease), lease,
        gate, holding, Senses(s), arbiter,
    )  # fmt: skip
    winners = {State.HOLDING: WaitForTurn(parts)._wait, State.YIELDING: Leave(parts)._go_on}
    arbiter.winner = winners.get(state, Proposal())
    return parts


def announce(
    s, state = State.DRIVING, has_goal = True, is_active = True,
    right = None,
):  # fmt: skip
    rank = CLASS_HOLDING if state is State.HOLDING else CLASS_DRIVING
    base = base_priority(rank if has_goal else CLASS_DONE, 33, s.robot_id)
    arbiter_of(s).announce_priorities(s.donations.own(base), s.donations.published(base))
    s.tube.publish(s.pose, s.tick)
    parts = parts_of(s, state, Lease(STATION, 70, 1), right=right)
    parts.is_active = is_active
    return compose_beacon(parts, waffle())


def test_a_beacon_carries_the_claims_and_priority_of_its_tick_and_changes_nothing():
    record = announce(driving())
    assert (record["id"], record["tick"], record["sec"], record["nanosec"]) == (4, 100, 10, 0)
    assert record["radius"] == pytest.approx(RADIUS, abs=1e-3)
    assert (record["held_size"], record["wanted_size"], record["intent_size"]) == (8, 7, 27)
    assert np.allclose(record["held"][0], (1.0, 1.0))
    assert np.allclose(record["held"][7], (1.35, 1.0))
    assert np.allclose(record["wanted"][0], (1.40, 1.0))
    assert not record["held"][8:].any()
    assert np.allclose(record["station"], STATION)
    assert record["station_tick"] == 70
    assert record["footprint_size"] == 8
    s = driving()
    record = announce(s)
    published = (int(record["priority"][0]) << 32) | int(record["priority"][1])
    assert published == s.priority == base_priority(CLASS_DRIVING, 33, 4)
    announce(s, State.HOLDING)
    assert s.priority == base_priority(CLASS_HOLDING, 33, 4)
    s = driving()
    first = announce(s)
    told = parts_of(s, State.DRIVING, Lease(STATION, 70, 1))
    assert compose_beacon(told, waffle()).tobytes() == first.tobytes()


def test_who_waits_for_its_turn_ranks_so_until_a_new_goal():
    """It rose above the robot that pushed it, and stayed in its way."""
    told = parts_of(driving(), State.DRIVING, Lease(STATION, 70, 1))
    waits = []
    for event in (Event.PUSHED, Event.RELEASED, Event.STATION_TAKEN, Event.PUSHED, Event.RELEASED):
        told.state_machine.switch(event)
        waits.append(told.state_machine.is_waiting)
    assert waits == [False, False, True, True, False]
    told = parts_of(driving(), State.DRIVING, Lease(STATION, 70, 1))
    waits = []
    for event in (Event.STATION_TAKEN, Event.PUSHED, Event.FINISHED, Event.GOAL, Event.BEHAVIOR):
        told.state_machine.switch(event)
        waits.append(told.state_machine.is_waiting)
    assert told.state_machine.state is State.YIELDING
    assert waits == [True, True, False, False, True]


@pytest.mark.parametrize(
    ("state", "has_goal", "mode"),
    [
        (State.IDLE, False, MODE_DONE),
        (State.DRIVING, True, MODE_DRIVE),
        (State.HOLDING, True, MODE_HOLD),
    ],
)
def test_the_mode_follows_the_state(state, has_goal, mode):
    record = announce(driving(), state, has_goal)
    assert record["mode"] == mode
    assert np.isnan(record["target"]).all()


def test_who_follows_a_higher_robot_ranks_as_it_inherited_also_against_pushers():
    follows, pushed = Donations(lane=9), Donations(station=3, push=9)
    assert (follows.own(5), follows.published(5)) == (9, 9)
    assert (pushed.own(5), pushed.published(5)) == (5, 9)


def test_a_yielding_robot_announces_its_refuge_and_what_it_inherited():
    s, right = driving(), RightOfWay()
    s.donations.yields_for, right.state, s.donations.push = 9, MakingWay.STUCK, 2**50 - 1
    record = announce(s, State.YIELDING, right=right)
    assert record["mode"] == MODE_YIELD
    assert record["yields_for"] == 9
    assert int(record["flags"]) & FLAG_STUCK
    assert np.allclose(record["target"], s.tube.points[-1])
    assert s.priority == 2**50 - 1


def status(s, state, is_active=True, place=2, gate=None, is_full=False):
    sites = Sites(stations={"loader_1": Pose(*STATION, 0.0)})
    lease = Lease(STATION, 70, place, 9 if place else 0, is_full=is_full)
    parts = parts_of(s, state, lease, gate, sites=sites)
    parts.is_active = is_active
    return compose_status(parts)


def test_the_status_says_what_the_robot_waits_for():
    s = driving()
    shown = status(s, State.HOLDING)
    assert (shown.state, shown.station, shown.queue_place) == ("holding", "loader_1", 2)
    assert shown.detail == "parked, waits for Srobot9, 2 before it at loader_1"
    assert shown.holding_since_tick == 60
    s.blocked_ticks, s.blocked_by, s.blocked_why = 11, 7, "is in the way"
    assert (status(s, State.DRIVING).state, status(s, State.DRIVING).detail) == (
        "waiting", "for Srobot7, which is in the way",
    )  # fmt: skip
    s.donations.yields_for = 8
    waits = "makes way for Srobot8, waits for Srobot7, which is in the way"
    assert status(s, State.YIELDING).detail == waits
    s.blocked_ticks, s.obstacle_ticks = 0, 11
    assert status(s, State.DRIVING).detail == "before an obstacle"
    waits = "makes way for Srobot8, waits before an obstacle"
    assert status(s, State.YIELDING).detail == waits
    s.donations.yields_for = s.obstacle_ticks = 0
    assert status(s, State.YIELDING).detail == "leaves for others"
    assert status(s, State.HOLDING, place=0).detail == "parked, waits until loader_1 is free"
    waits = "parked, waits for room on the single lanes at loader_1"
    assert status(s, State.HOLDING, place=0, is_full=True).detail == waits
    assert status(s, State.DRIVING, is_active=False).state == "inactive"


@pytest.mark.parametrize("is_asked", [False, True])
def test_only_a_robot_with_a_goal_waits(is_asked):
    """Robots without a goal that could not drive were shown as waiting, for nobody."""
    s = driving()
    parts = parts_of(s, State.DRIVING if is_asked else State.IDLE, Lease())
    if is_asked:
        parts.goal_manager.task = GoalProgress(Goal(kind=GoalKind.NAVIGATE, poses_map=(s.pose,)), s)
    assert not parts.senses.update(is_lost=True)
    shown = compose_status(parts)
    assert (shown.state, shown.detail) == ("waiting" if is_asked else "idle", "stands: lost")


def test_a_robot_calls_others_by_the_names_of_the_run():
    s = driving()
    s.names = RobotNames(("ann", "bob"), "agv{}")
    s.blocked_ticks, s.blocked_why = 99, "is in the way"
    for number, name in ((2, "bob"), (7, "agv7")):
        s.blocked_by = number
        parts = parts_of(s, State.DRIVING, Lease())
        shown = compose_status(parts)
        assert shown.detail == f"for {name}, which is in the way"


def test_the_status_says_who_drives_and_who_waits_at_the_gate():
    s = driving()
    told = parts_of(s, State.BEHAVING, Lease())
    for is_by_hand, state in ((True, "driven by hand"), (False, "pausing")):
        kind = GoalKind.TELEOP if is_by_hand else GoalKind.WAIT
        told.goal_manager.behavior = Behavior(Goal(kind=kind), s)
        assert compose_status(told).state == state
    shown = status(driving(), State.HOLDING, gate=Gate(None, asked_tick=50, first=3))
    assert shown.detail == "parked, waits for Srobot3: the narrow region ahead is full"
    assert int(announce(driving())["gate_tick"]) == 0
    assert int(announce(driving())["flags"]) & FLAG_ACTIVE
    assert not int(announce(driving(), is_active=False)["flags"]) & FLAG_ACTIVE


words = st.integers(0, 2**32 - 1)


@settings(max_examples=40, deadline=None)
@given(st.binary(min_size=BEACON_SIZE, max_size=BEACON_SIZE))
def test_any_beacon_survives_its_encoding(data):
    record = np.frombuffer(data, BEACON_DTYPE)[0]
    assert deserialize_beacon(serialize_beacon(record)).tobytes() == data


@pytest.mark.parametrize("count", [0, 1, 3])
def test_a_batch_survives_its_encoding(count):
    batch = np.array([announce(driving()) for _ in range(count)], BEACON_DTYPE)
    sec, nanosec, back = deserialize_neighbors(serialize_neighbors(12, 300_000_000, batch))
    assert (sec, nanosec, len(back)) == (12, 300_000_000, count)
    assert back.tobytes() == batch.tobytes()


def test_old_beacons_are_read_and_words_are_those_of_any_buffer():
    record = announce(driving())
    record["sighted_id"] = 7  # in what is cut off
    read = deserialize_beacon(serialize_beacon(record)[: 4 + 4 * word_of("sighted_id")])
    assert not read["sighted_id"].any()
    record["sighted_id"] = record["sighted_tick"] = 0
    assert read.tobytes() == record.tobytes()
    batch = np.frombuffer(np.random.default_rng(0).bytes(3 * BEACON_SIZE + 1), np.uint8)
    for start in (0, 1):  # aligned and not
        beacons = batch[start : start + 3 * BEACON_SIZE].view(BEACON_DTYPE)
        words = words_of(beacons)
        assert words.tobytes() == beacons.tobytes()
        assert words.flags.writeable
        assert words.flags.aligned


def test_a_beacon_is_packed_in_the_order_of_its_members_without_padding():
    words = blank_beacon(((1.0, 2.0), (3.0, 4.0))).copy()
    pack_head(words, range(1, 28))
    record = record_of(words)
    names = BEACON_DTYPE.names or ()
    values = np.concatenate([np.ravel(record[name]) for name in names[: names.index("held")]])
    assert values.tolist() == list(range(1, 28))
    assert record["footprint"][:3].tolist() == [[1.0, 2.0], [3.0, 4.0], [0.0, 0.0]]
    assert not record["held"].any()
    assert BEACON_DTYPE.itemsize == sum(BEACON_DTYPE[name].itemsize for name in BEACON_DTYPE.names)
    assert math.isclose(BEACON_SIZE / 1024, 0.94, abs_tol=0.02)
    with pytest.raises(ValueError, match="expected"):
        deserialize_beacon(serialize_beacon(announce(driving()))[: 4 * word_of("sighted_id")])
