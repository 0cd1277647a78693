"""Messages on the wire, against an independent implementation of the standard."""

import json

import pytest
from vda5050.model.order import Order as TheirOrder
from vda5050.validation import SchemaValidator

from swarm_describe.robots.loading import load_robot
from swarm_vda5050.dialect import Dialect
from swarm_vda5050.factsheet import factsheet
from swarm_vda5050.faults import OrderFault, OrderRejectedError
from tests.fakes.fleet_orders import OF_2, OF_3, Toy, action, along, header, node, on_wire, order

THEIRS = SchemaValidator()


def written(topic, content, identity=OF_2):
    return json.loads(Dialect(identity).write(topic, content))


def encoded(content):
    return json.dumps(content).encode()


def test_states_are_valid_for_others():
    toy = Toy()
    toy.send(order([node(0), node(1, action("pick", "p", loadId="crate")), node(2)]))
    toy.do("dance", "d")
    toy.send(along(5, 6, 6, "B"))
    assert THEIRS.errors("state", written("state", toy.state())) == []
    toy.drive()
    toy.wait(5.0)
    message = written("state", toy.state())
    assert THEIRS.errors("state", message) == []
    assert message["loads"] == [{"loadId": "crate"}]
    assert {a["actionId"] for a in message["actionStates"]} == {"p", "d"}


@pytest.mark.parametrize("robot", ["turtlebot3_waffle", "turtlebot3_burger"])
def test_other_messages_are_valid_for_others(robot):
    sheet = factsheet(load_robot(robot), OF_2.offered, "2.1")
    for topic, content in (
        ("factsheet", sheet),
        ("connection", {"connectionState": "ONLINE"}),
        ("connection", {"connectionState": "CONNECTIONBROKEN"}),
    ):
        assert THEIRS.errors(topic, written(topic, content)) == []


def test_orders_of_others_are_read():
    content = along(0, 1, 2)
    theirs = TheirOrder.model_validate(content).model_dump_json(by_alias=True, exclude_none=True)
    assert Dialect(OF_2).read("order", theirs.encode()).nodes[1].key == ("n1", 2)


def test_version_3_has_its_own_names():
    toy = Toy(OF_3)
    toy.do("stateRequest", "s")
    toy.send(along(0, 1, 1, "B"))
    assert set(toy.done) == {"s"}
    toy.do("clearInstantActions", "c")
    toy.do("cancelOrder", "x")
    toy.wait(0.1)
    toy.send(along(3, 4, 4))
    message = written("state", toy.state(), OF_3)
    assert [a["actionId"] for a in message["instantActionStates"]] == ["c", "x"]
    assert message["powerSupply"] == {"stateOfCharge": 100.0, "charging": False}
    assert message["safetyState"]["activeEmergencyStop"] == "NONE"
    assert message["errors"][0]["errorType"] == "START_NODE_OUT_OF_RANGE"
    broken = written("connection", {"connectionState": "CONNECTIONBROKEN"}, OF_3)
    assert broken["connectionState"] == "CONNECTION_BROKEN"


def test_orders_of_version_3_are_read():
    content = along(0, 1, 1)
    content["nodes"][1]["nodeDescription"] = "the end"
    ellipse = {"a": 0.5, "b": 0.2, "theta": 0.0}
    content["nodes"][1]["nodePosition"]["allowedDeviationXY"] = ellipse
    content["edges"][0]["maxSpeed"] = 0.1
    content["nodes"][1]["actions"] = [action("pick", "p", "SINGLE") | {"retriable": True}]
    read = Dialect(OF_3).read("order", on_wire("order", content, "3.0"))
    assert read.nodes[1].node_position.deviation == 0.2
    assert read.edges[0].max_speed == 0.1
    assert read.nodes[1].actions[0].retriable


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"no json",
        b"\xff\xfe",
        b"[]",
        b"null",
        b"[" * 100_000,
        b" " * 10_000_000,
        encoded(header()),
        encoded(along(0, 1, 1) | {"speed": 3}),
        encoded(along(0, 1, 1) | {"version": "1.1.0"}),
        encoded(along(0, 1, 1) | {"version": "3.0.0"}),
        encoded(along(0, 1, 1) | {"serialNumber": "Srobot2"}),
        encoded(along(0, 1, 1) | {"manufacturer": "else"}),
        encoded(along(0, 1, 1) | {"orderUpdateId": "0"}),
        encoded(order([node(0, x=float("nan"))])),
        encoded(order([node(0)])).replace(b"0.0", b"1e999"),
        encoded(order([node(0, action("wait", "w", "SINGLE", duration=1.0))])),
    ],
    ids=lambda data: repr(data[:20]),
)
def test_what_cannot_be_read_is_rejected(data):
    with pytest.raises(OrderRejectedError) as caught:
        Dialect(OF_2).read("order", data)
    assert caught.value.fault is OrderFault.VALIDATION


def test_a_message_that_cannot_be_read_is_still_named():
    with pytest.raises(OrderRejectedError) as caught:
        Dialect(OF_2).read("order", encoded(along(0, 1, 1, "X") | {"speed": 3}))
    names = {"topic": "order", "headerId": "7", "orderId": "X", "orderUpdateId": "0"}
    assert caught.value.references == names
    assert "speed" in str(caught.value)
    with pytest.raises(
        OrderRejectedError, match="instantActions: Input data was truncated"
    ) as caught:
        Dialect(OF_2).read("instantActions", b"{")
    assert caught.value.references == {"topic": "instantActions"}
