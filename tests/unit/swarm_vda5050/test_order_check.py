"""What is wrong with an order in itself."""

import contextlib
import math

import msgspec
import pytest

from swarm_vda5050.faults import OrderFault, OrderRejectedError
from swarm_vda5050.messages import DriveOrder
from swarm_vda5050.order_check import DrivingArea, check_order
from swarm_vda5050.ways import is_followed
from tests.fakes.fleet_orders import MAP, action, along, node, nurbs, order


def fault_of(content):
    ground = DrivingArea(MAP, lambda x, _: "in a wall" if x > 50.0 else "")
    try:
        check_order(msgspec.convert(content, DriveOrder), ground, turn_rate=1.0)
    except OrderRejectedError as error:
        return error.fault
    return None


def test_orientations_along_the_way_are_taken_and_others_named():
    content = along(0, 1, 1)
    for more in ({"orientation": 0.1}, {"orientation": 0.0, "orientationType": "GLOBAL"}):
        content["edges"][0] |= more | {"rotationAllowed": False, "maxRotationSpeed": 2.0}
        assert fault_of(content) is None
    for orientation, may_back, word in ((1.6, True, "or backwards only"), (3.14, False, "behind")):
        content["edges"][0] |= {"orientation": orientation}
        told = msgspec.convert(content, DriveOrder)
        with pytest.raises(OrderRejectedError, match=word):
            check_order(told, DrivingArea(MAP), turn_rate=1.0, may_back=may_back)


@pytest.mark.parametrize("kind", ["GLOBAL", "TANGENTIAL"])
def test_an_orientation_against_the_way_is_taken(kind):
    content = along(0, 1, 1)
    content["edges"][0] |= {"orientation": -3.0, "orientationType": kind}
    assert fault_of(content) is None
    bent = content["edges"][0] | {"trajectory": nurbs((0.0, 0.0), (1.0, 1.0), (2.0, 0.0))}
    content["edges"][0] = bent
    expected = OrderFault.UNSUPPORTED if kind == "GLOBAL" else None  # partly across
    assert fault_of(content) is expected


@pytest.mark.parametrize(
    ("direction", "turn", "word"),
    [
        ("left", 1.57, ""), ("left", 0.1, ""), ("left", -0.8, "turns by -0.80 rad"),
        ("right", -1.57, ""), ("right", 1.57, "turns by 1.57 rad"),
        ("straight", 0.3, ""), ("straight", 1.57, "turns by 1.57 rad"),
        ("580 Hz", 0.0, "knows left, straight, right only"),
    ],
)  # fmt: skip
def test_a_direction_is_that_in_which_the_line_turns_off_or_refused_by_name(direction, turn, word):
    """It was dropped without a word."""
    place = {"x": 2.0 + math.cos(turn), "y": math.sin(turn)}
    content = order([node(0), node(1), node(2, **place)])
    content["edges"][1]["direction"] = direction
    told = msgspec.convert(content, DriveOrder)
    assert is_followed(told.edges[1])
    with contextlib.nullcontext() if not word else pytest.raises(OrderRejectedError, match=word):
        check_order(told, DrivingArea(MAP))
    content["edges"][0]["direction"] = "left"  # off a line that the message does not have
    assert fault_of(content) is (OrderFault.UNSUPPORTED if word else None)


def test_a_good_order_passes_and_one_with_too_many_nodes_does_not():
    assert fault_of(along(0, 2, 4)) is None
    assert fault_of(order([node(0)])) is None
    assert fault_of(along(0, 10_000, 10_000)) is OrderFault.VALIDATION


@pytest.mark.parametrize(
    "change",
    [
        lambda o: o["nodes"].clear(),
        lambda o: o["edges"].pop(),
        lambda o: o["nodes"][1].update(sequenceId=4),
        lambda o: o["nodes"][0].update(sequenceId=-2),
        lambda o: o["edges"][0].update(sequenceId=2),
        lambda o: o["edges"][0].update(endNodeId="n9"),
        lambda o: o["nodes"][0].update(released=False),
        lambda o: o["edges"][0].update(released=False),
        lambda o: o["edges"][0].update(maxSpeed=0.0),
        lambda o: o["nodes"][1]["nodePosition"].update(x=-1e308),
        lambda o: o["edges"][0].update(corridor={"leftWidth": 1e308, "rightWidth": 1.0}),
        lambda o: o["edges"][0].update(trajectory=nurbs((0.0, 0.0), (1.0, 1.0))),
        lambda o: o["edges"][0].update(trajectory=nurbs((0.0, 0.0), (2.0, 0.0), degree=2)),
        lambda o: o["edges"][0].update(trajectory=nurbs((0.0, 0.0), (2.0, 0.0), knots=[0.0, 1.0])),
        lambda o: [n["actions"].append(action("wait", "w", duration=1.0)) for n in o["nodes"]],
    ],
)
def test_a_broken_structure_is_invalid(change):
    content = along(0, 2, 2)
    change(content)
    assert fault_of(content) is OrderFault.VALIDATION


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda o: o["nodes"][1].pop("nodePosition"), OrderFault.UNSUPPORTED),
        (lambda o: o["edges"][0].update(orientation=1.0), OrderFault.UNSUPPORTED),
        (
            lambda o: o["edges"][0].update(orientation=1.57, orientationType="GLOBAL"),
            OrderFault.UNSUPPORTED,
        ),
        (lambda o: o["edges"][0].update(maxRotationSpeed=0.5), OrderFault.UNSUPPORTED),
        (lambda o: o["nodes"][1]["nodePosition"].update(mapId="moon"), OrderFault.UNKNOWN_MAP),
        (lambda o: o["nodes"][1]["nodePosition"].update(x=60.0), OrderFault.NO_ROUTE),
        (
            lambda o: o["nodes"][1]["actions"].append(action("dance", "d")),
            OrderFault.UNKNOWN_ACTION,
        ),
        (lambda o: o["nodes"][1]["actions"].append(action("wait", "d")), OrderFault.UNKNOWN_ACTION),
        (
            lambda o: o["nodes"][1]["actions"].append(action("wait", "d", duration=float("nan"))),
            OrderFault.UNKNOWN_ACTION,
        ),
    ],
)
def test_what_robots_cannot_do_is_rejected(change, fault):
    content = along(0, 2, 2)
    change(content)
    assert fault_of(content) is fault
