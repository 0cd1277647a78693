"""Orders by hand and by formula: one robot, two stations."""

import math
import statistics

import pytest

from swarm_common.model.records import Pose
from swarm_mission.orders.arrivals import Arrivals, Shift
from swarm_mission.orders.order import OrderPlan, OrderStream
from swarm_mission.orders.service import ServiceTime
from tests.fakes.point_robots import PointSwarm

STATIONS = {"a": Pose(0.0, 0.0, 0.0), "b": Pose(10.0, 0.0, 0.0)}


def one_stream(arrivals, load, unload, **more):
    stream = OrderStream(
        number=1, origins=("a",), targets=("b",), arrivals=arrivals, loading=load, unloading=unload,
        **more,
    )  # fmt: skip
    return OrderPlan(streams=(stream,))


def test_lead_times_of_one_robot_between_two_stations_are_those_by_hand():
    """Grant after 5 ticks, goal after 6; each arrival is answered after 2; 0.05 m in a tick."""
    plan = one_stream(
        Arrivals(listed=(0.0, 1.0, 100.0)),
        ServiceTime("constant", (3.0,)),
        ServiceTime("constant", (2.0,)),
        due=60.0,
    )
    swarm = PointSwarm(plan, STATIONS, {"r1": Pose(0.0, 5.0, 0.0)})
    swarm.run_until(3000)
    results = swarm.run.results(swarm.tick / 10.0)
    first, second, third = results["orders"]
    # grant 0.6, 5 m in 10 s, 0.2 to be answered, 3 s, 10 m in 20 s, 0.2, 2 s
    assert first["done"] == pytest.approx(0.6 + 10.0 + 0.2 + 3.0 + 20.0 + 0.2 + 2.0)
    assert first["waiting"] == 0.5
    assert first["driving"] == pytest.approx(0.1 + 10.0 + 20.0)  # a tick for the grant
    assert first["handover"] == pytest.approx(0.4)
    assert first["service"] == 5.0
    # the robot is free at 36.0 and bids at once: granted at 36.4, sets off at 36.5 for 10 m
    assert second["waiting"] == pytest.approx(36.4 - 1.0)
    assert second["done"] == pytest.approx(36.5 + 20.0 + 0.2 + 3.0 + 20.0 + 0.2 + 2.0)
    assert second["lateness"] == pytest.approx(second["done"] - 1.0 - 60.0)
    # home from b: set off at 82.9, granted at 100.5, seen at 100.6; way left by Pythagoras
    way = math.hypot(10.0, 5.0)
    driven = (100.6 - 82.9) * 0.5
    x, y = 10.0 - 10.0 * driven / way, 5.0 * driven / way
    drive = math.ceil(math.hypot(x, y) / 0.05 - 1e-6) / 10.0
    assert third["done"] == pytest.approx(100.6 + drive + 0.2 + 3.0 + 20.0 + 0.2 + 2.0, abs=0.11)
    for order in results["orders"]:
        parts = [order[name] for name in ("waiting", "driving", "handover", "service")]
        assert order["lead_time"] == pytest.approx(sum(parts))
    shares = results["robots"]["r1"]
    assert sum(shares.values()) == pytest.approx(swarm.tick / 10.0, abs=0.6)
    assert results["stations"]["a"]["utilisation"] == pytest.approx(
        9.0 / (swarm.tick / 10.0), abs=1e-3
    )


def test_waiting_times_are_those_of_a_queue_with_one_server():
    """Pollaczek and Khinchine: mean wait of Poisson arrivals is rate E[S²] / (2 (1 - load))."""
    rate, load_mean, deviation = 180.0, 4.0, 2.0
    waits = []
    for seed in range(6):
        plan = one_stream(
            Arrivals(shifts=(Shift(rate=rate, end=5000.0),)),
            ServiceTime("lognormal", (load_mean, deviation)),
            ServiceTime(),
        )
        swarm = PointSwarm(plan, STATIONS, {"r1": STATIONS["b"]}, seed=seed, speed=5.0)
        swarm.run_until(10**6)
        orders = swarm.run.results(swarm.tick / 10.0)["orders"]
        waits.append(statistics.fmean(order["waiting"] for order in orders))
    # bid and grant 0.5, two ways of 2 s, two handovers of 0.2 s
    constant = 0.5 + 2.0 * 2.0 + 2.0 * 0.2
    mean = constant + load_mean
    square = mean**2 + deviation**2
    per_second = rate / 3600.0
    expected = 0.45 + per_second * square / (2.0 * (1.0 - per_second * mean))
    half = 2.57 * statistics.stdev(waits) / math.sqrt(len(waits))  # 95 %, 5 degrees of freedom
    assert half < 0.3 * expected
    assert abs(statistics.fmean(waits) - expected) < half


def test_orders_are_the_same_whatever_the_number_of_robots():
    plan = one_stream(
        Arrivals(shifts=(Shift(rate=200.0, end=200.0),)),
        ServiceTime("triangular", (1.0, 2.0, 4.0)),
        ServiceTime(),
    )
    runs = []
    for count in (1, 3):
        homes = {f"r{i}": Pose(float(i), 5.0, 0.0) for i in range(count)}
        swarm = PointSwarm(plan, STATIONS, homes, seed=7)
        swarm.run_until(20_000)
        runs.append([(o["id"], o["created"], o["from"]) for o in swarm.run.results(1e4)["orders"]])
    assert runs[0] == runs[1]
    assert len(runs[0]) > 3


@pytest.mark.parametrize("dispatch", ["claim", "nearest", "fifo", "central", f"{__name__}:Last"])
def test_every_dispatch_serves_all_orders(dispatch, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, __name__, sys.modules.get(__name__) or _this_module())
    plan = OrderPlan(
        streams=one_stream(
            Arrivals(shifts=(Shift(every=10.0, end=100.0),)), ServiceTime(), ServiceTime()
        ).streams,
        dispatch=dispatch,
    )
    homes = {f"r{i}": Pose(0.0, 2.0 * i, 0.0) for i in range(3)}
    swarm = PointSwarm(plan, STATIONS, homes, speed=1.0, loss=0.1)
    swarm.run_until(5000)
    results = swarm.run.results(swarm.tick / 10.0)
    assert (results["created"], results["done"]) == (10, 10)


def test_a_run_is_not_over_before_the_last_robot_has_been_unloaded():
    for seed in range(60):
        half = ServiceTime("constant", (0.5,))
        plan = one_stream(Arrivals(listed=(0.0,)), half, half)
        swarm = PointSwarm(
            plan, STATIONS, {"r1": STATIONS["a"]}, speed=1.0, loss=0.4, delay=0.2, seed=seed
        )
        swarm.run_until(5000)
        assert swarm.run.results(swarm.tick / 10.0)["done"] == 1, seed


class Last:
    """A dispatcher of one's own: the last robot by name."""

    def assign(self, tick, offers, bids):
        taken = set()
        for offer in offers:
            free = [bid for bid in bids.get(offer.order, ()) if bid.robot not in taken]
            if free:
                best = max(free, key=lambda bid: bid.robot)
                taken.add(best.robot)
                yield best


def _this_module():
    import types

    module = types.ModuleType(__name__)
    module.Last = Last
    return module
