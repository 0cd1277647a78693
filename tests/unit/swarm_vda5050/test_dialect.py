"""Messages on the wire, against an independent implementation of the standard."""

import json

import pytest
from vda5050.model.order import Order as TheirOrder
from vda5050.validation import SchemaValidator

from swarm_describe.robots.loading import load_robot
from swarm_vda5050.dialect import Dialect
from swarm_vda5050.factsheet import factsheet
from swarm_vda5050.faults import OrderFault, OrderRejectedError
from tests.fakes.fleet_orders import OF_2, OF_3, Toy, action, along, header, node, order

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
    sheet = factsheet(load_robot(robot), OF_2.offered, 2)
    for topic, content in (
        ("factsheet", sheet),
        ("connection", {"connectionState": "ONLINE"}),
        ("connection", {"connectionState": OF_2.broken}),
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
    assert OF_3.broken == "CONNECTION_BROKEN"


def test_orders_of_version_3_are_read():
    content = along(0, 1, 1) | header("3.0.0")
    content["nodes"][1]["nodeDescriptor"] = "the end"
    ellipse = {"a": 0.5, "b": 0.2, "theta": 0.0}
    content["nodes"][1]["nodePosition"]["allowedDeviationXY"] = ellipse
    content["edges"][0]["maximumSpeed"] = 0.1
    read = Dialect(OF_3).read("order", encoded(content))
    assert read.nodes[1].node_position.allowed_deviation_xy == 0.2
    assert read.edges[0].max_speed == 0.1
    content["nodes"][1]["actions"] = [action("pick", "p") | {"retriable": True}]
    with pytest.raises(OrderRejectedError):
        Dialect(OF_3).read("order", encoded(content))


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
    assert caught.value.references["orderId"] == "X"
    assert "speed" in str(caught.value)
