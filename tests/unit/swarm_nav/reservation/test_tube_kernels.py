"""Rules G1 to G5 of the reservation protocol against their slow twin."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.beacon import BEACON_DTYPE
from swarm_nav.core.config import TrafficConfig
from swarm_nav.perception.neighbor_table import NeighborTable
from swarm_nav.reservation import tube_kernels as kernels
from tests.fakes.navigation import RADIUS, beacon
from tests.oracles import tube as oracle

REACH = 2 * RADIUS
NOTHING = np.zeros((0, 2))
OWN_ID = 5
ALL_REQUESTS = np.array([(k, k) for k in range(100)])  # point k was requested since tick k
RULES = {kernels.REACHED: "", kernels.OBSTACLE: "obstacle", kernels.RIGHT_OF_WAY: "G5"}


def claims(others, tick=100):
    neighbors = NeighborTable(OWN_ID, TrafficConfig(lost_ticks=200))
    records = []
    for other in others:
        record = beacon(
            other.id, *other.held[0], held=other.held, wanted=other.wanted, intent=other.intent,
            priority=other.priority, blocked_ticks=other.blocked, radius=other.radius,
        )  # fmt: skip
        record["tick"] = tick - other.age
        record["heard"][0] = OWN_ID << 16 | max(0, other.acknowledged)
        records.append(record)
    neighbors.receive(np.array(records, BEACON_DTYPE), 0.0, 0.0)
    neighbors.refresh(tick)
    neighbors.gone = np.array([o.is_gone for o in sorted(others, key=lambda o: o.id)], np.bool_)
    return neighbors.claims()


def grow(
    path, span, own, others,
    obstacles = NOTHING, clearance = 0.5,
):  # fmt: skip
    published = np.array(own.published, np.float32)
    return kernels.extend(
        np.ascontiguousarray(path, np.float64), span,
        (own.radius, own.priority, own.id, own.yields_for), published, len(published),
        ALL_REQUESTS, (own.push_ticks, own.slack, oracle.HEARING),
        (np.ascontiguousarray(obstacles, np.float64), clearance), claims(others),
    )  # fmt: skip


STRAIGHT = np.column_stack((np.arange(0.0, 1.0, 0.05), np.zeros(20)))


def me(**changes):
    values: dict = dict(id=5, radius=RADIUS, priority=100, yields_for=0, published=[(0.0, 0.0)])
    return oracle.Own(**(values | changes))


def other(x, y=0.0, **changes):
    values: dict = dict(
        id=9, age=1, is_gone=False, priority=50, radius=RADIUS, blocked=0, held=[(x, y)]
    )
    return oracle.Other(**(values | changes))


def test_nobody_near_lets_it_grow_and_held_tubes_keep_the_sum_of_radii():
    assert grow(STRAIGHT, (0, 7, 7), me(), []) == (7, kernels.REACHED, -1)
    assert grow(STRAIGHT, (0, 7, 4), me(), []) == (4, kernels.UNCONFIRMED, -1)
    assert grow(STRAIGHT, (0, 7, -1), me(), []) == (0, kernels.UNCONFIRMED, -1)
    stop, reason, row = grow(STRAIGHT, (0, 7, 7), me(), [other(0.8)])
    assert (stop, reason, row) == (4, kernels.ROBOT, 0)
    assert 0.8 - STRAIGHT[stop, 0] >= REACH > 0.8 - STRAIGHT[stop + 1, 0]


@pytest.mark.parametrize(
    ("mine", "theirs", "my_id", "may"),
    [(100, 50, 5, True), (50, 100, 5, False), (70, 70, 5, True), (70, 70, 12, False)],
)
def test_g2_a_request_yields_to_the_higher_priority_and_then_to_the_smaller_id(
    mine, theirs, my_id, may
):
    contested = other(1.2, priority=theirs, wanted=[(0.9, 0.0), (0.85, 0.0)])
    stop, _, _ = grow(STRAIGHT, (0, 7, 7), me(priority=mine, id=my_id), [contested])
    assert (stop == 7) == may


@pytest.mark.parametrize("age", [1, 2, 5, 16])
def test_g2_the_age_of_a_beacon_does_not_matter(age):
    wanted = [(0.9, 0.0), (0.85, 0.0)]
    lower, higher = (other(1.2, age=age, priority=p, wanted=wanted) for p in (1, 900))
    assert grow(STRAIGHT, (0, 7, 7), me(), [lower])[0] == 7
    assert grow(STRAIGHT, (0, 7, 7), me(), [higher])[0] < 7


def test_g2_only_the_part_of_a_request_before_my_held_tube_counts():
    wanted = [(0.25, 0.3 + 0.05 * k) for k in range(6)]  # first point lies within my reach
    contested = other(0.25, 0.9, priority=900, wanted=wanted[::-1])
    through_me = other(0.25, 0.9, priority=900, wanted=wanted)
    held = [(0.05 * k, 0.0) for k in range(3)]
    path = (0, 4, 4)
    assert grow(STRAIGHT, path, me(published=held), [through_me])[0] == 4
    assert grow(STRAIGHT, path, me(published=[(0.0, -2.0)]), [through_me])[0] == 0
    assert grow(STRAIGHT, path, me(published=[(0.0, -2.0)]), [contested])[0] == 0


def test_g3_space_is_taken_when_all_in_hearing_have_acknowledged():
    for acknowledged in (-1, 0, 3, 6, 7):
        near = other(1.5, 1.0, acknowledged=acknowledged)
        stop, reason, _ = grow(STRAIGHT, (0, 7, 7), me(), [other(0.0, 1.0, id=2), near])
        assert stop == max(0, acknowledged)
        assert reason == (kernels.REACHED if stop == 7 else kernels.UNCONFIRMED)
    within = other(0.0, 5.5, acknowledged=-1)
    assert grow(STRAIGHT, (0, 7, 7), me(), [within]) == (0, kernels.UNCONFIRMED, -1)
    far = other(0.0, 5.6, acknowledged=-1)
    gone = other(0.0, 1.0, acknowledged=-1, is_gone=True, age=40)
    assert grow(STRAIGHT, (0, 7, 7), me(), [far])[0] == 7
    assert grow(STRAIGHT, (0, 7, 7), me(), [gone])[0] == 7


@pytest.mark.parametrize("ticks", [0, 2, 3, 50])
def test_g5_a_blocked_higher_robots_way_is_kept_clear(ticks):
    way = [(0.3, 1.2 - 0.1 * k) for k in range(20)]
    entitled = other(0.3, 1.2, priority=900, blocked=ticks, intent=way, wanted=[])
    stop, reason, _ = grow(STRAIGHT, (0, 7, 7), me(published=[(0.0, -1.0)]), [entitled])
    assert (reason == kernels.RIGHT_OF_WAY) == (ticks >= 3 and stop < 7)


def test_g5_spares_who_makes_way_by_the_slack_only():
    crossing = [(0.6, 0.4 - 0.1 * k) for k in range(8)]
    entitled = other(0.6, 1.2, priority=900, blocked=9, intent=crossing)
    assert grow(STRAIGHT, (0, 7, 7), me(), [entitled])[1] == kernels.RIGHT_OF_WAY
    assert grow(STRAIGHT, (0, 7, 7), me(yields_for=9), [entitled])[0] == 7
    assert grow(STRAIGHT, (0, 7, 7), me(priority=901), [entitled])[0] == 7
    assert grow(STRAIGHT + np.array((0.1, 0.0)), (0, 7, 7), me(), [entitled])[0] == 7
    near = other(0.3, REACH - 0.015)
    nearer = other(0.3, REACH - 0.025)
    assert grow(STRAIGHT, (0, 12, 12), me(), [near])[0] < 12
    assert grow(STRAIGHT, (0, 12, 12), me(yields_for=9), [near])[0] == 12
    assert grow(STRAIGHT, (0, 12, 12), me(yields_for=9), [nearer])[0] < 12


def test_a_gone_robot_keeps_its_space_and_who_stands_in_it_may_leave():
    wanted = [(0.95 - 0.05 * k, 0.0) for k in range(4)]
    gone = other(1.0, age=40, is_gone=True, priority=0, wanted=wanted)
    stop, reason, _ = grow(STRAIGHT, (0, 15, 15), me(), [gone])
    assert reason == kernels.ROBOT
    assert 0.8 - STRAIGHT[stop, 0] >= REACH - 1e-6
    assert stop == 4
    gone = other(-0.9, age=40, is_gone=True, priority=900, wanted=[(-0.4, 0.0), (-0.35, 0.0)])
    assert grow(STRAIGHT, (0, 7, 7), me(), [gone])[0] == 7
    ahead = other(0.9, age=40, is_gone=True, priority=900, wanted=[(0.4, 0.0), (0.35, 0.0)])
    assert grow(STRAIGHT, (0, 7, 7), me(), [ahead])[0] == 0


def test_growth_beside_too_near_tubes_and_obstacles():
    behind = other(-0.5)
    assert grow(STRAIGHT, (0, 7, 7), me(), [behind])[0] == 7
    ahead = other(0.5)
    assert grow(STRAIGHT, (0, 7, 7), me(), [ahead])[0] == 0
    wall = np.array(((0.8, 0.0),))
    stop, reason, _ = grow(STRAIGHT, (0, 7, 7), me(), [], wall)
    assert (stop, reason) == (6, kernels.OBSTACLE)
    assert grow(STRAIGHT, (0, 7, 7), me(), [], np.array(((-0.3, 0.0),)))[0] == 7


coordinate = st.floats(-1.5, 1.5).map(lambda value: round(value, 2) + 0.0031)
point = st.tuples(coordinate, coordinate)
line = st.builds(
    lambda start, yaw, count: [
        (start[0] + 0.05 * k * math.cos(yaw), start[1] + 0.05 * k * math.sin(yaw))
        for k in range(count)
    ],
    point, st.floats(-3.0, 3.0), st.integers(1, 8),
)  # fmt: skip
neighbor = st.builds(
    oracle.Other,
    id=st.sampled_from([one for one in range(1, 10) if one != OWN_ID]),
    age=st.integers(1, 16), is_gone=st.booleans(),
    priority=st.integers(1, 4), radius=st.just(RADIUS), blocked=st.integers(0, 5),
    held=line, wanted=st.one_of(st.just([]), line), intent=line, acknowledged=st.integers(0, 15),
)  # fmt: skip


@settings(max_examples=300, deadline=None)
@given(
    st.lists(neighbor, max_size=4, unique_by=lambda o: o.id), st.integers(1, 4),
    st.sampled_from((0, 3)), st.integers(0, 7), st.lists(point, max_size=2), st.integers(0, 14),
)  # fmt: skip
def test_growth_equals_its_slow_twin(
    others, priority, yields_for, stop,
    obstacles, confirmed,
):  # fmt: skip
    others = sorted(others, key=lambda o: o.id)
    for one in others:
        one.age = 20 + one.age if one.is_gone else one.age
    own = me(
        priority=priority, yields_for=yields_for,
        published=[tuple(p) for p in STRAIGHT[: stop + 1].tolist()],
    )  # fmt: skip
    span = (stop, 14, confirmed)
    got, reason, _ = grow(STRAIGHT, span, own, others, np.array(obstacles).reshape(-1, 2))
    path = [tuple(p) for p in STRAIGHT.tolist()]
    expected, rule = oracle.extend(path, *span, own, others, obstacles, 0.5)
    assert got == expected
    if reason == kernels.ROBOT:
        assert rule in ("G2 held", "G2 wanted")
    elif reason == kernels.UNCONFIRMED:
        assert rule == "G1 or G3"
    else:
        assert RULES[reason] == rule
