"""Orders as written in mission files, and what is refused of them."""

import pytest

from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_mission.mission import load_mission
from swarm_mission.orders.demand import check_demand, least_robots

GOOD = "{from: a, to: b, rate: 60}"


def load(folder, streams, more=""):
    path = folder / "orders.yaml"
    path.write_text(f"orders:\n  - {streams}\n{more}\n")
    return load_mission(str(path))


def test_groups_service_and_times_are_read_also_of_the_worlds(tmp_path):
    (tmp_path / "shift.csv").write_text("time,what\n1.5,x\n3,y\n")
    more = "groups: {ins: [a, inner], inner: [b]}\ncapacity: 2\ndispatch: fifo"
    service = "{from: 4, to: {uniform: [1, 3]}}"
    text = f"{{from: ins, to: out, times: shift.csv, batch: 2, service: {service}}}"
    plan = load(tmp_path, text, more).orders
    assert (plan.stations, plan.capacity, plan.dispatch) == (("a", "b", "out"), 2, "fifo")
    (stream,) = plan.streams
    assert (stream.loading.mean, stream.unloading.mean) == (4.0, 2.0)
    orders = [*plan.orders_from("a", 3), *plan.orders_from("b", 3)]
    assert sorted(order.created for order in orders) == [15, 15, 30, 30]
    assert all(order.load_ticks == 40 and 10 <= order.unload_ticks <= 30 for order in orders)
    sites = Sites(stations={"a_1": Pose(0, 0, 0), "a_2": Pose(1, 0, 0), "b": Pose(2, 0, 0)},
                  groups={"a": ("a_1", "a_2")})  # fmt: skip
    mission = load(tmp_path, GOOD).with_groups(sites)
    mission.check_stations(sites, "here")
    assert mission.stations == ("a_1", "a_2", "b")


@pytest.mark.parametrize(
    ("streams", "more", "message"),
    [
        ("{from: a, to: b}", "", "expected one of 'rate', 'every', 'shifts' and 'times'"),
        ("{from: a, to: b, rate: 1, every: 2}", "", "found rate and every"),


        ("{from: a, to: b, rate: 1e9}", "", "expected 0.1 s to"),


        ("{from: a, to: a, rate: 5}", "", "orders go from a to a"),

        ("{from: a, to: b, rate: 5, service: -1}", "", "service is -1; expected a number from 0"),
        ("{from: a, to: b, rate: 5, service: {triangular: [3, 9, 5]}}", "", "least, likeliest"),





        ("{from: a, to: b, times: none.csv}", "", "cannot read times from"),
        ("{from: a, to: b, times: ../x.csv}", "", "in the folder of the mission"),
        ("{from: a, to: b, shifts: [{begin: 5, end: 2, rate: 3}]}", "", "0 <= begin < end"),
        ("{from: a, to: b, shifts: [{rate: 3}, {begin: 5, rate: 3}]}", "", "before the one above"),
        (GOOD, "groups: {x: [y], y: [x]}", "groups: x > y > x: a group contains itself"),


        (GOOD, "route: [{home: true}]", "orders and a route"),
        (GOOD, "start_spread: 3", "'start_spread' is for a route"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_one_line(tmp_path, streams, more, message):
    with pytest.raises(ConfigError) as error:
        load(tmp_path, streams, more)
    assert message in str(error.value)
    assert str(tmp_path) in str(error.value)
    assert "\n" not in str(error.value)


def test_orders_that_no_swarm_can_serve_are_refused(tmp_path):
    sites = Sites(stations={"a": Pose(0, 0, 0), "bb": Pose(1, 0, 0)})
    with pytest.raises(ConfigError, match="unknown station 'b' in here; did you mean 'a' or 'bb'"):
        load(tmp_path, GOOD).check_stations(sites, "here")
    plan = load(tmp_path, "{from: a, to: b, rate: 400, service: {from: 10, to: 0}}").orders
    assert plan is not None
    with pytest.raises(ConfigError, match=r"a gets 400 orders/h .* busy for 111 %"):
        check_demand(plan, lambda a, b: 10.0, 0.5, 100)
    with pytest.raises(ConfigError, match="no way from a to b"):
        check_demand(plan, lambda a, b: float("inf"), 0.5, 100)
    plan = load(tmp_path, "{from: a, to: b, rate: 240}").orders
    assert plan is not None
    # 30 m there and 30 m back at 0.25 m/s: 240 s for each of 240 orders in 3600 s
    assert least_robots(plan, lambda a, b: 30.0, 0.25) == pytest.approx(16.0)
    assert check_demand(plan, lambda a, b: 30.0, 0.25, 16) == []
    (remark,) = check_demand(plan, lambda a, b: 30.0, 0.25, 15)
    assert remark.startswith("240 orders/h need at least 16 robots by distance alone")


def test_bursts_and_balanced_streams_are_fine(tmp_path):
    """It was taken for orders that come like that for ever."""
    shift = "shifts: [{begin: 9, end: 19, every: 0.5}]"
    burst = f"{{from: a, to: b, rate: 60}}\n  - {{from: a, to: b, {shift}}}"
    plan = load(tmp_path, burst).orders
    assert plan is not None
    (remark,) = check_demand(plan, lambda a, b: 30.0, 0.25, 20)
    assert remark.startswith("7260 orders/h need at least 4")
    endless = load(tmp_path, "{from: a, to: b, every: 0.5}").orders
    assert endless is not None
    with pytest.raises(ConfigError, match="a swarm has up to 200"):
        check_demand(endless, lambda a, b: 30.0, 0.25, 20)
    both = "{from: a, to: b, rate: 60}\n  - {from: b, to: a, rate: 60}"
    plan = load(tmp_path, both).orders
    assert plan is not None
    assert least_robots(plan, lambda a, b: 30.0, 0.25) == pytest.approx(120 * 120 / 3600)
