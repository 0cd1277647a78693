"""Orders, updates, actions and cancels of one vehicle, as the standard has them."""

import math
from pathlib import Path

import pytest

from swarm_describe.robots.loading import load_robot
from swarm_vda5050.factsheet import factsheet
from swarm_vda5050.process import ground_of
from swarm_vda5050.tally import in_numbers
from tests.fakes.fleet_orders import (
    MAP,
    OF_2,
    OF_3,
    OF_20,
    Toy,
    action,
    along,
    edge,
    node,
    nurbs,
    order,
)

MAPS = Path(__file__).resolve().parents[3] / "maps"


def test_an_order_is_driven_to_the_end_of_its_base_and_goes_on():
    toy = Toy()
    toy.send(along(0, 2, 2))
    assert toy.vehicle.last_node == ("n0", 0)
    assert [state.node_id for state in toy.vehicle.node_states] == ["n1", "n2"]
    assert [n.node_id for n in toy.vehicle.leg.nodes] == ["n1", "n2"]
    toy.drive()
    assert toy.vehicle.last_node == ("n2", 4)
    assert not toy.vehicle.is_busy
    assert toy.faults == []
    toy = Toy()
    toy.send(along(0, 1, 3))
    toy.drive()
    assert toy.vehicle.last_node == ("n1", 2)
    assert toy.vehicle.is_busy
    assert toy.vehicle.wants_base
    toy.send(along(1, 3, 3, update=1))
    toy.drive()
    assert toy.vehicle.last_node == ("n3", 6)
    toy = Toy()
    toy.send(along(0, 1, 1))
    toy.drive()
    toy.send(along(1, 2, 2, update=1))
    toy.drive()
    assert toy.vehicle.last_node == ("n2", 4)


def test_an_update_replaces_the_horizon():
    toy = Toy()
    toy.send(along(0, 1, 5))
    toy.send(along(1, 2, 3, update=1))
    assert [s.node_id for s in toy.vehicle.node_states] == ["n1", "n2", "n3"]
    assert [s.released for s in toy.vehicle.node_states] == [True, True, False]


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (along(0, 2, 2, "B"), "OTHER_ORDER"),
        (along(0, 1, 1, update=0), "SAME_UPDATE"),
        (along(1, 3, 3, update=1), "NO_CONTINUATION"),
        (along(3, 4, 4, update=1), "NO_CONTINUATION"),
    ],
)
def test_what_does_not_fit_the_running_order_is_rejected(content, fault):
    toy = Toy()
    toy.send(along(0, 2, 4))
    before = toy.vehicle.node_states
    toy.send(content)
    assert toy.faults == [fault]
    assert toy.vehicle.node_states == before
    toy.drive()
    assert toy.vehicle.last_node == ("n2", 4)


def test_an_outdated_update_is_rejected_and_the_same_one_discarded():
    toy = Toy()
    toy.send(along(0, 1, 1))
    toy.send(along(1, 2, 2, update=3))
    toy.send(along(1, 2, 2, update=3))
    assert toy.faults == []
    toy.send(along(0, 1, 1))
    assert toy.faults == ["OUTDATED"]


def test_an_order_is_not_done_twice_or_from_elsewhere():
    toy = Toy()
    toy.send(along(0, 1, 1, "A"))
    toy.drive()
    toy.send(along(1, 2, 2, "B"))
    toy.drive()
    toy.send(along(2, 3, 3, "A"))
    assert toy.faults == ["USED_ORDER"]
    assert toy.vehicle.order_id == "B"
    toy = Toy()
    toy.send(along(3, 4, 4))
    assert toy.faults == ["START_FAR"]
    toy.send(order([node(0, allowedDeviationXY=0.1, x=0.2), node(1)]))
    assert toy.faults == ["START_FAR", "START_FAR"]
    toy.send(along(0, 1, 1))
    assert toy.faults == []


def test_a_cancelled_order_is_gone_once_the_robot_stands():
    toy = Toy()
    toy.send(order([node(0), node(1), node(2, action("wait", "w", duration=1.0))]))
    toy.sense(is_standing=False)
    toy.do("cancelOrder", "c")
    assert toy.vehicle.leg is None
    assert toy.done == {"w": "FAILED", "c": "RUNNING"}
    assert toy.vehicle.node_states
    toy.wait(1.0)
    assert toy.done["c"] == "FINISHED"
    assert toy.vehicle.node_states == toy.vehicle.edge_states == ()
    toy.send(along(2, 3, 3, update=1))
    assert toy.faults == ["CANCELLED"]
    toy.send(along(0, 1, 1, "B"))
    assert toy.faults == []
    toy.drive()
    assert toy.vehicle.last_node == ("n1", 2)


def test_orders_are_counted_with_the_time_without_one():
    toys = [Toy(), Toy(), Toy()]
    assert in_numbers([toy.vehicle.tally for toy in toys])["done_per_hour"] is None
    for toy in toys[:2]:
        toy.now = 100.0
        toy.sense()
        toy.send(along(0, 2, 2))
        toy.drive()
        toy.wait(10.0)
        toy.send(order([node(2), node(3)], "B"))
        toy.sense()
    toys[0].do("cancelOrder")
    toys[0].wait(6.0)
    numbers = in_numbers([toy.vehicle.tally for toy in toys])
    assert (numbers["done"], numbers["given_up"], numbers["open"]) == (2, 1, 1)
    assert numbers["done_per_hour"] == pytest.approx(2 * 3600 / 18.0)
    assert numbers["share_of_time_without_order"] == pytest.approx(26.0 / 30.0, abs=1e-3)


def test_blocking_actions_hold_the_robot_and_others_do_not():
    toy = Toy()
    hard = action("wait", "h", "HARD", duration=3.0)
    none = action("wait", "n", "NONE", duration=3.0)
    toy.send(order([node(0), node(1, none), node(2, hard, none | {"actionId": "m"}), node(3)]))
    assert len(toy.vehicle.leg.nodes) == 2
    toy.step()
    assert toy.done["n"] == "RUNNING"
    toy.step()
    assert toy.vehicle.leg is None
    assert (toy.done["h"], toy.done["m"]) == ("WAITING", "WAITING")  # `n` is not done yet
    toy.wait(3.0)
    assert (toy.done["n"], toy.done["h"], toy.done["m"]) == ("FINISHED", "RUNNING", "WAITING")
    toy.wait(3.0)
    assert (toy.done["h"], toy.done["m"]) == ("FINISHED", "RUNNING")
    assert toy.vehicle.leg is not None


def test_edge_actions_block_before_and_end_with_their_edge():
    toy = Toy()
    content = order([node(0), node(1), node(2)])
    content["edges"][1] = edge(1, action("wait", "s", "SOFT", duration=2.0))
    toy.send(content)
    toy.drive()
    assert toy.vehicle.last_node == ("n1", 2)
    toy.wait(2.0)
    toy.drive()
    assert toy.vehicle.last_node == ("n2", 4)
    assert toy.done == {"s": "FINISHED"}
    toy = Toy()
    content = order([node(0), node(1)])
    content["edges"][0] = edge(0, action("wait", "s", "NONE", duration=99.0))
    toy.send(content)
    toy.drive()
    assert toy.done == {"s": "FAILED"}


def test_loads_are_picked_and_dropped():
    toy = Toy()
    toy.send(order([node(0, action("pick", "p", loadId="crate"))]))
    toy.wait(5.0)
    assert toy.vehicle.load.load_id == "crate"
    toy.send(order([node(0, action("drop", "q", loadId="box"))], "B"))
    assert toy.done == {"q": "FAILED"}
    assert toy.faults == ["ACTION"]
    toy.send(order([node(0, action("drop", "d"))], "C"))
    toy.wait(5.0)
    assert toy.done == {"d": "FINISHED"}
    assert toy.vehicle.load is None


def test_a_pause_stops_driving_and_the_clock_of_actions():
    toy = Toy()
    toy.send(order([node(0, action("wait", "w", "NONE", duration=2.0)), node(1)]))
    toy.do("startPause", "s")
    assert toy.vehicle.leg is None
    assert toy.done == {"w": "PAUSED", "s": "FINISHED"}
    toy.wait(60.0)
    toy.do("stopPause", "t")
    assert toy.done["w"] == "RUNNING"
    assert toy.vehicle.leg is not None
    toy.wait(2.0)
    assert toy.done["w"] == "FINISHED"


def test_charging_begins_with_the_current():
    toy = Toy()
    toy.sense(is_charging=False)
    toy.do("startCharging", "a")
    assert toy.done["a"] == "RUNNING"
    toy.sense(is_charging=False)
    assert toy.done["a"] == "RUNNING"
    toy.sense(is_charging=True)
    assert toy.done["a"] == "FINISHED"
    toy.sense(is_charging=False)
    toy.do("startCharging", "b")
    toy.now += 11.0
    toy.sense(is_charging=False)
    assert toy.done["b"] == "FAILED"


def test_requests_and_instant_actions_are_done_once():
    toy = Toy()
    toy.do("stateRequest", "s")
    toy.do("factsheetRequest", "f")
    toy.do("initPosition", "p", x=1, y=2.0, theta=0.5, mapId="hall", lastNodeId="n9")
    requests = toy.vehicle.take_requests()
    assert (requests.state, requests.factsheet) == (True, True)
    assert requests.initial_pose_map.x == 1.0
    assert toy.vehicle.last_node[0] == "n9"
    assert not toy.vehicle.take_requests().state
    toy = Toy()
    toy.send(along(0, 1, 1))
    toy.do("cancelOrder", "c")
    toy.wait(0.1)
    toy.send(along(0, 1, 1, "B"))
    toy.do("cancelOrder", "c")
    assert toy.vehicle.is_busy is True


@pytest.mark.parametrize(
    ("kind", "parameters"),
    [("dance", {}), ("pick", {}), ("initPosition", {"x": 1.0}), ("stateRequest", {"why": "x"})],
)
def test_an_instant_action_that_cannot_be_done_fails(kind, parameters):
    toy = Toy()
    toy.do(kind, "i", **parameters)
    assert toy.faults == ["INSTANT"]
    assert toy.done == {"i": "FAILED"}
    toy.do("stateRequest", "j")
    assert toy.faults == []


def test_a_leg_is_tried_three_times():
    toy = Toy()
    toy.send(along(0, 1, 1))
    for _ in range(2):
        toy.vehicle.fail_drive("no way", False)
        assert toy.vehicle.leg is None
        assert toy.faults == ["DRIVING"]
        toy.wait(5.0)
        assert toy.vehicle.leg is not None
    toy.vehicle.fail_drive("no way", False)
    toy.wait(99.0)
    assert toy.faults == ["UNREACHABLE"]
    assert toy.vehicle.leg is None
    toy.do("cancelOrder", "c")
    assert toy.faults == []


def test_driving_by_hand_ends_the_order():
    toy = Toy()
    toy.send(along(0, 1, 1))
    toy.sense(is_by_hand=True)
    assert toy.vehicle.node_states == ()
    assert toy.faults == ["DRIVING"]
    toy.send(along(0, 1, 1, "B"))
    assert toy.faults == ["NOT_AVAILABLE", "DRIVING"]
    toy.sense()
    toy.send(along(0, 1, 1, "B"))
    assert toy.faults == []


def test_an_edge_without_rotation_is_entered_in_its_heading_and_followed():
    toy = Toy()
    content = order([node(number) for number in range(4)])
    content["edges"][1]["rotationAllowed"] = False
    toy.send(content)
    assert (len(toy.vehicle.leg.nodes), toy.vehicle.leg.heading) == (1, None)
    toy.step()
    leg = toy.vehicle.leg
    assert (len(leg.nodes), leg.heading) == (1, 0.0)
    assert toy.vehicle.path_of(leg)[-1].tolist() == [4.0, 0.0]
    toy.drive()
    assert toy.vehicle.last_node == ("n3", 6)


def test_an_order_to_a_place_that_walls_close_off_is_refused_before_it_is_driven():
    """It was driven, and failed with the planner's words where the robot stood."""
    config = {"map": str(MAPS / "slim_blockage.yaml"), "map_id": MAP, "sites": ""}
    toy = Toy(ground=ground_of(config, 0.2))
    for x, faults in ((-3.0, []), (-4.5, ["NO_ROUTE"])):
        start = node(0, x=toy.pose.x, y=toy.pose.y)
        toy.send(order([start, node(1, x=x, y=2.7)], f"to{x:g}"))
        assert toy.faults == faults
        toy.drive()


def test_an_edge_is_driven_backwards_and_the_next_one_forwards():
    toy = Toy()
    content = order([node(number) for number in range(4)])
    content["edges"][1] |= {"orientation": 3.1, "trajectory": nurbs((2.0, 0.0), (4.0, 0.0))}
    content["edges"][2]["trajectory"] = nurbs((4.0, 0.0), (6.0, 0.0))
    toy.send(content)
    assert not toy.vehicle.leg.is_backwards
    toy.step()
    leg = toy.vehicle.leg
    assert (len(leg.nodes), leg.is_backwards) == (1, True)
    assert abs(leg.heading) == pytest.approx(math.pi)
    toy.step()
    leg = toy.vehicle.leg
    assert (len(leg.nodes), leg.is_backwards, leg.heading) == (1, False, None)
    toy.drive()
    assert toy.vehicle.last_node == ("n3", 6)


def test_a_heading_is_met_within_its_deviation():
    for allowed, turn in ((None, 0.0), (0.1, 0.2), (0.3, 0.0)):
        toy = Toy()
        place = {"theta": 0.2} | ({} if allowed is None else {"allowedDeviationTheta": allowed})
        toy.send(order([node(0), node(1, **place)]))
        assert toy.vehicle.turn_at(("n1", 2)) == pytest.approx(turn)


def test_a_node_that_is_to_be_met_closely_is_a_stop():
    toy = Toy()
    toy.send(order([node(0), node(1, allowedDeviationXY=0.3), node(2, theta=1.0), node(3)]))
    assert len(toy.vehicle.leg.nodes) == 1
    toy.step()
    assert len(toy.vehicle.leg.nodes) == 1
    toy.step()
    assert len(toy.vehicle.leg.nodes) == 1
    toy.drive()
    assert not toy.vehicle.is_busy


def test_logs_are_written():
    toy = Toy()
    for reason in ("slow", "lost"):
        toy.do("logReport", f"log {reason}", reason=reason)
    assert toy.vehicle.take_requests().log_reasons == ("slow", "lost")
    assert toy.vehicle.take_requests().log_reasons == ()


@pytest.mark.parametrize("identity", [OF_20, OF_2, OF_3])
@pytest.mark.parametrize("kind", ["startHibernation", "detectObject", "updateCertificate"])
def test_an_action_of_the_standard_that_no_robot_does_is_refused_and_not_in_the_factsheet(
    kind, identity
):
    sheet = factsheet(load_robot("turtlebot3_burger"), identity.offered, identity.version)
    offered = [each["actionType"] for each in sheet["protocolFeatures"]["agvActions"]]
    assert kind not in offered
    toy = Toy(identity)
    toy.do(kind, "instant")
    assert toy.done == {"instant": "FAILED"}
    toy.send(order([node(0, action(kind, "on node"))]))
    assert toy.faults == ["INSTANT", "UNKNOWN_ACTION"]
    assert toy.vehicle.order_id == ""
