"""Orders over a radio that loses and delays, among robots that die, fall silent and come back."""

import math
import random

from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.records import Pose
from swarm_mission.orders.arrivals import Arrivals
from swarm_mission.orders.order import OrderPlan, OrderStream
from swarm_mission.orders.service import ServiceTime
from tests.fakes.point_robots import PointSwarm

STATIONS = {"a": Pose(0.0, 0.0, 0.0), "b": Pose(8.0, 0.0, 0.0), "c": Pose(4.0, 6.0, 0.0)}
LAST = 60_000  # tick by which all must be done


def make_plan(dispatch, capacity):
    """Return 12 orders to and fro between three stations."""
    common = {"loading": ServiceTime("uniform", (0.0, 4.0)), "unloading": ServiceTime()}
    streams = (
        OrderStream(
            number=1, origins=("a", "b"), targets=("b", "c"),
            arrivals=Arrivals(listed=(0.0, 0.0, 5.0, 9.0), batch=2), **common,
        ),
        OrderStream(
            number=2, origins=("c",), targets=("a",), priority=1, due=20.0,
            arrivals=Arrivals(listed=(1.0, 30.0, 31.0, 60.0)), **common,
        ),
    )  # fmt: skip
    return OrderPlan(streams=streams, dispatch=dispatch, capacity=capacity)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10_000),
    robots=st.integers(2, 5),
    loss=st.sampled_from([0.0, 0.1, 0.3, 0.6]),
    delay=st.sampled_from([0.0, 0.3, 2.0]),
    dispatch=st.sampled_from(["claim", "claim", "claim", "nearest", "fifo", "central"]),
    capacity=st.sampled_from([1, 1, 2]),
    trouble=st.floats(0.0, 0.6),
)
def test_no_order_is_lost_and_none_is_done_twice(
    seed, robots, loss, delay, dispatch, capacity, trouble
):
    homes = {f"r{i}": Pose(float(i), -3.0, 0.0) for i in range(robots)}
    swarm = PointSwarm(
        make_plan(dispatch, capacity), STATIONS, homes, seed=seed, speed=1.0, loss=loss, delay=delay
    )
    rng = random.Random(seed)
    mortal = sorted(homes)[1:]  # one robot lives for ever
    while swarm.tick < LAST and not swarm.run.is_over:
        if swarm.tick % 50 == 0:
            is_late = swarm.tick > 3000  # then everybody stays as it is, but is heard again
            swarm.radio.mute = set() if is_late else {n for n in homes if rng.random() < trouble}
            if not is_late:
                swarm.dead = {name for name in mortal if rng.random() < trouble}
        swarm.advance()
        check_holders(swarm)
    records = swarm.run.book.records.values()
    assert len(records) == 12
    assert [r.id for r in records if r.receipts != 1] == []
    assert all(r.done is not None and r.created < r.done for r in records)


def check_holders(swarm):
    """No two robots hold one grant of an order: a station grants none twice."""
    holders = [
        (order, held.number)
        for courier in swarm.run.couriers.values()
        for order, held in courier.bidder.held.items()
    ]
    assert len(holders) == len(set(holders))
    for courier in swarm.run.couriers.values():
        assert len(courier.bidder.held) <= 2


def test_a_robot_with_goods_that_comes_back_does_not_deliver_twice():
    stream = OrderStream(number=1, origins=("a",), targets=("b",), arrivals=Arrivals(listed=(0.0,)))
    homes = {"r1": Pose(0.0, -1.0, 0.0), "r2": Pose(0.0, -20.0, 0.0)}
    swarm = PointSwarm(OrderPlan(streams=(stream,)), STATIONS, homes, speed=0.5)
    while not swarm.run.couriers["r1"].has_goods:
        swarm.advance()
    swarm.dead = {"r1"}
    while not swarm.run.couriers["r2"].has_goods:
        swarm.advance()
    swarm.dead = set()
    swarm.radio.mute = {"r2"}  # so that both go on with the goods
    swarm.run_until(swarm.tick + 400)
    swarm.radio.mute = set()
    swarm.run_until(LAST)
    (record,) = swarm.run.book.records.values()
    assert record.taken_back == 1
    assert record.receipts == 1
    assert math.isclose(swarm.run.results(swarm.tick / 10.0)["done"], 1)
