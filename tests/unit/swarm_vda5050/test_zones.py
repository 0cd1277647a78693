"""Zone sets of version 3.0, and releases."""

import msgspec
import numpy as np
import pytest

from swarm_common.model.grid import KEEPOUT, Grid
from swarm_common.model.records import Pose
from swarm_vda5050.order_check import DrivingArea
from swarm_vda5050.reading import Reader
from tests.fakes.fleet_orders import MAP, OF_3, Toy, action, along, node, order

NO_ACTIONS = {"entryActions": [], "duringActions": [], "exitActions": []}
PICK = {"actionType": "pick", "blockingType": "HARD"}
LATER = "2026-01-01T00:01:00Z"


def zone(kind, first, last, **more):
    corners = [(first, -1.0), (last, -1.0), (last, 1.0), (first, 1.0)]
    vertices = [{"x": x, "y": y} for x, y in corners]
    return {"zoneId": f"{kind}{first:g}", "zoneType": kind, "vertices": vertices} | more


def hear(toy, topic, **content):
    toy.hear(topic, content)


def toy_with(*zones):
    return enable(Toy(OF_3), *zones)


def enable(toy, *zones):
    hear(toy, "zoneSet", zoneSet={"mapId": MAP, "zoneSetId": "z", "zones": list(zones)})
    assert [state.zone_set_status for state in toy.vehicle.zones.states] == ["DISABLED"]
    toy.do("enableZoneSet", "e", zoneSetId="z")
    assert [state.zone_set_status for state in toy.vehicle.zones.states] == ["ENABLED"]
    return toy


def answer(toy, grant, **more):
    (request,) = toy.vehicle.zones.requests
    response = {"requestId": request.request_id, "grantType": grant} | more
    hear(toy, "responses", responses=[response])
    toy.wait(0.1)


def statuses(toy):
    return [request.request_status for request in toy.vehicle.zones.requests]


def test_a_zone_is_entered_only_when_it_is_released():
    toy = toy_with(zone("RELEASE", 3.0, 5.0))
    toy.send(along(0, 4, 4))
    toy.wait(0.1)
    assert statuses(toy) == ["REQUESTED"]
    toy.drive()
    assert toy.vehicle.last_node == ("n1", 2)
    answer(toy, "QUEUED")
    assert toy.vehicle.leg is None
    answer(toy, "GRANTED")
    assert statuses(toy) == ["GRANTED"]
    toy.drive()
    assert toy.vehicle.last_node == ("n4", 8)
    assert statuses(toy) == []


def test_a_rejected_request_is_made_again_later():
    toy = toy_with(zone("RELEASE", 3.0, 5.0))
    toy.send(along(0, 4, 4))
    toy.wait(0.1)
    answer(toy, "REJECTED")
    assert statuses(toy) == []
    toy.clock(11.0)
    assert statuses(toy) == ["REQUESTED"]


@pytest.mark.parametrize(("behaviour", "is_stopped"), [("STOP", True), ("CONTINUE", False)])
@pytest.mark.parametrize("loss", ["REVOKED", "EXPIRED"])
def test_a_release_is_lost_in_a_zone(behaviour, is_stopped, loss):
    toy = toy_with(zone("RELEASE", 3.0, 5.0, releaseLossBehavior=behaviour))
    toy.send(along(0, 4, 4))
    toy.wait(0.1)
    answer(toy, "GRANTED", leaseExpiry=LATER)
    toy.step()
    toy.step()
    assert toy.pose.x == 4.0
    if loss == "REVOKED":
        answer(toy, "REVOKED")
    else:
        toy.clock(61.0)
    assert statuses(toy) == [loss]
    assert (toy.vehicle.leg is None) is is_stopped
    assert ("RELEASE_LOST" in toy.faults) is is_stopped
    answer(toy, "GRANTED")
    toy.drive()
    assert toy.vehicle.last_node == ("n4", 8)
    assert toy.faults == []


def test_a_zone_whose_release_is_lost_is_evacuated_and_the_order_goes_on():
    toy = toy_with(zone("RELEASE", 3.0, 5.0, releaseLossBehavior="EVACUATE"))
    toy.send(along(0, 4, 4))
    toy.wait(0.1)
    answer(toy, "GRANTED")
    toy.step()
    toy.step()
    answer(toy, "REVOKED")
    (place,) = (node.node_position for node in toy.vehicle.leg.nodes)
    assert not 2.7 < place.x < 5.3 or abs(place.y) > 1.3
    assert toy.vehicle.path_of(toy.vehicle.leg) is None
    toy.vehicle.fail_drive("a robot is in the way", True)
    assert toy.vehicle.leg is None
    assert toy.faults == ["DRIVING"]
    toy.wait(6.0)
    assert statuses(toy) == ["REVOKED"]
    assert toy.vehicle.leg is not None
    toy.pose = Pose(place.x, place.y, 0.0)
    toy.wait(1.0)
    toy.wait(0.1)
    assert "REVOKED" not in statuses(toy)
    for _ in range(2):
        if statuses(toy) == ["REQUESTED"]:
            answer(toy, "GRANTED")
    toy.drive()
    assert toy.vehicle.last_node == ("n4", 8)
    assert toy.faults == []


def test_a_robot_that_finds_no_place_beside_a_zone_stops_in_it():
    toy = Toy(OF_3, DrivingArea(MAP, lambda x, y: "" if abs(y) < 0.1 and 0 <= x <= 8 else "full"))
    enable(toy, zone("RELEASE", -3.0, 15.0, releaseLossBehavior="EVACUATE"))
    toy.send(along(0, 4, 4))
    toy.wait(0.1)
    answer(toy, "GRANTED")
    toy.step()
    answer(toy, "REVOKED")
    assert toy.vehicle.leg is None
    assert toy.faults == ["RELEASE_LOST"]


@pytest.mark.parametrize(
    ("kind", "limitation", "free", "most"),
    [
        ("DIRECTED", "SOFT", 0.47, np.pi),
        ("DIRECTED", "RESTRICTED", 0.47, np.pi / 2),
        ("DIRECTED", "STRICT", 0.24, 0.47),
        ("BIDIRECTED", "SOFT", 0.24, np.pi / 2),
        ("BIDIRECTED", "RESTRICTED", 0.24, 0.47),
    ],
)
def test_directions_of_zones_are_told_to_the_navigator(kind, limitation, free, most):
    toy = toy_with(zone(kind, 3.0, 5.0, direction=7.0, limitation=limitation))
    (told,) = toy.vehicle.zones.directed
    assert told.points == ((3.0, -1.0), (5.0, -1.0), (5.0, 1.0), (3.0, 1.0))
    assert told.direction == pytest.approx(7.0 - 2 * np.pi)
    assert (told.free_off, told.most_off) == (free, most)
    assert told.is_two_way is (kind == "BIDIRECTED")
    assert toy.vehicle.zones.costs == {}


def way_of(request):
    return [(point["x"], point["y"]) for point in request.trajectory["controlPoints"]]


def test_the_way_through_a_coordinated_zone_is_asked_for_and_followed():
    toy = toy_with(zone("COORDINATED_REPLANNING", 3.0, 5.0))
    toy.send(along(0, 3, 4))
    toy.wait(0.1)
    (request,) = toy.vehicle.zones.requests
    assert (request.request_type, request.request_status) == ("REPLANNING", "REQUESTED")
    assert way_of(request) == [(0.0, 0.0), (6.0, 0.0)]
    toy.drive()
    assert toy.vehicle.last_node == ("n1", 2)
    assert set(toy.vehicle.zones.costs.values()) == {KEEPOUT}  # nobody plans through it
    answer(toy, "QUEUED")
    assert toy.vehicle.leg is None
    assert statuses(toy) == ["REQUESTED"]
    (request,) = toy.vehicle.zones.requests
    granted = {"requestId": request.request_id, "grantType": "GRANTED"}
    hear(toy, "responses", responses=[granted])
    assert statuses(toy) == ["GRANTED"]
    assert toy.vehicle.leg.is_followed
    assert toy.vehicle.zones.costs == {}  # as soon as the way is driven
    assert toy.vehicle.path_of(toy.vehicle.leg)[-1].tolist() == [6.0, 0.0]
    toy.step()
    toy.send(along(3, 4, 4, update=1))  # its edge does not touch the zone
    toy.wait(0.1)
    assert statuses(toy) == ["GRANTED"]
    toy.drive()
    assert toy.vehicle.last_node == ("n4", 8)
    assert statuses(toy) == []
    assert toy.faults == []


def test_an_edge_on_which_only_the_body_touches_a_coordinated_zone_is_asked_for_and_followed():
    beside = zone("COORDINATED_REPLANNING", 3.0, 5.0)
    beside["vertices"] = [{"x": v["x"], "y": v["y"] + 1.1} for v in beside["vertices"]]
    toy = toy_with(beside)
    toy.send(along(0, 2, 2))
    toy.wait(0.1)
    assert statuses(toy) == ["REQUESTED"]
    answer(toy, "GRANTED")
    toy.step()
    assert toy.vehicle.leg.is_followed


def test_who_stands_exactly_stops_in_a_zone_whose_release_is_lost():
    toy = toy_with(zone("RELEASE", 1.0, 5.0))
    toy.send(order([node(0), node(1, action("finePositioning", "f"))]))
    toy.wait(0.1)
    answer(toy, "GRANTED")
    toy.drive()
    toy.wait(0.1)
    assert toy.vehicle.fine_target is not None
    answer(toy, "REVOKED")
    assert toy.vehicle.fine_target is None


def test_a_longer_way_is_asked_for_anew_while_the_granted_one_is_driven():
    toy = toy_with(zone("COORDINATED_REPLANNING", 3.0, 9.0))
    toy.send(along(0, 2, 4))
    toy.wait(0.1)
    answer(toy, "GRANTED")
    toy.step()
    toy.send(along(2, 4, 4, update=1))
    toy.wait(0.1)
    assert statuses(toy) == ["GRANTED", "REQUESTED"]
    assert way_of(toy.vehicle.zones.requests[1]) == [(2.0, 0.0), (8.0, 0.0)]
    toy.drive()
    assert toy.vehicle.last_node == ("n2", 4)
    granted = {"requestId": toy.vehicle.zones.requests[-1].request_id, "grantType": "GRANTED"}
    hear(toy, "responses", responses=[granted])
    toy.wait(0.1)
    assert statuses(toy) == ["GRANTED"]
    toy.drive()
    assert toy.vehicle.last_node == ("n4", 8)


@pytest.mark.parametrize("loss", ["REVOKED", "EXPIRED"])
def test_a_robot_whose_way_is_lost_stops_and_asks_anew(loss):
    toy = toy_with(zone("COORDINATED_REPLANNING", 3.0, 7.0))
    toy.send(along(0, 4, 4))
    toy.wait(0.1)
    answer(toy, "GRANTED", leaseExpiry=LATER)
    toy.step()
    toy.step()
    (before,) = toy.vehicle.zones.requests
    if loss == "REVOKED":
        response = {"requestId": before.request_id, "grantType": "REVOKED"}
        hear(toy, "responses", responses=[response])
    else:
        toy.now = 61.0
    toy.sense(is_standing=False)
    assert statuses(toy) == [loss]
    assert toy.vehicle.leg is None
    assert toy.faults == ["DRIVING"]
    toy.wait(0.1)
    (after,) = toy.vehicle.zones.requests
    assert (after.request_status, after.request_id != before.request_id) == ("REQUESTED", True)
    assert way_of(after)[0] == (4.0, 0.0)
    answer(toy, "GRANTED")
    assert toy.faults == []
    toy.drive()
    assert toy.vehicle.last_node == ("n4", 8)


def test_a_robot_that_is_driven_by_hand_asks_for_nothing():
    toy = toy_with(zone("RELEASE", 1.0, 5.0), zone("COORDINATED_REPLANNING", 3.0, 5.0))
    toy.send(along(0, 4, 4))
    toy.wait(0.1)
    assert statuses(toy) == ["REQUESTED", "REQUESTED"]
    toy.pose = Pose(4.0, 0.0, 0.0)
    toy.sense(is_by_hand=True)
    toy.sense(is_by_hand=True)
    assert statuses(toy) == []


@pytest.mark.parametrize(
    ("grants", "word"),
    [
        ([("7", "GRANTED")], "there was no request '7'"),
        ([("1", "REVOKED")], "is revoked, but was not granted"),
        ([("1", "GRANTED"), ("1", "REJECTED")], "is rejected after it was granted"),
        ([("1", "QUEUED"), ("1", "GRANTED"), ("1", "GRANTED"), ("1", "REVOKED")], ""),
    ],
)
def test_answers_that_make_no_sense_are_reported_and_none_lets_a_robot_in(grants, word):
    toy = toy_with(zone("RELEASE", 3.0, 5.0))
    toy.send(along(0, 4, 4))
    toy.wait(0.1)
    for name, grant in grants:
        hear(toy, "responses", responses=[{"requestId": name, "grantType": grant}])
    assert [error.message for error in toy.vehicle.errors if word in error.message] or not word
    assert toy.faults == (["VALIDATION"] if word else [])
    toy.drive()
    assert toy.vehicle.last_node == ("n1", 2)


def corridor_order(loss="STOP", *, base=3):
    content = along(0, base, 3)
    for number in (0, 2):
        content["edges"][number]["corridor"] = {
            "leftWidth": 1.0, "rightWidth": 1.0, "releaseRequired": True,
            "releaseLossBehavior": loss,
        }  # fmt: skip
    return content


def ask_for_corridor(**order):
    toy = Toy(OF_3)
    toy.send(corridor_order(**order))
    toy.wait(0.1)
    return toy


def corridors(toy):
    return [(each.edge_id, each.request_status) for each in toy.vehicle.edge_requests]


def answer_corridor(toy, grant, index=0, **more):
    request = toy.vehicle.edge_requests[index]
    response = {"requestId": request.request_id, "grantType": grant} | more
    hear(toy, "responses", responses=[response])
    toy.wait(0.1)


def test_an_edge_is_followed_until_its_corridor_is_granted():
    toy = ask_for_corridor()
    assert corridors(toy) == [("e0", "REQUESTED"), ("e2", "REQUESTED")]
    assert [each.sequence_id for each in toy.vehicle.edge_requests] == [1, 5]
    assert toy.vehicle.path_of(toy.vehicle.leg) is not None
    assert toy.vehicle.corridors_of(toy.vehicle.leg) == []
    answer_corridor(toy, "GRANTED")
    assert corridors(toy)[0] == ("e0", "GRANTED")
    assert toy.vehicle.path_of(toy.vehicle.leg) is None
    (area,) = toy.vehicle.corridors_of(toy.vehicle.leg)
    assert area.bounds[1] == pytest.approx(-1.2)
    toy.step()
    toy.wait(0.1)
    assert corridors(toy) == [("e2", "REQUESTED")]
    answer_corridor(toy, "REJECTED")
    assert corridors(toy) == []
    toy.drive()  # along the line
    assert toy.vehicle.last_node == ("n3", 6)
    assert toy.faults == []


def test_only_corridors_of_the_base_are_asked_for():
    assert corridors(ask_for_corridor(base=1)) == [("e0", "REQUESTED")]


@pytest.mark.parametrize("loss", ["REVOKED", "EXPIRED"])
def test_a_robot_whose_corridor_is_lost_stops_or_returns_to_the_line(loss):
    for behaviour in ("STOP", "RETURN"):
        toy = ask_for_corridor(loss=behaviour)
        answer_corridor(toy, "GRANTED", leaseExpiry=LATER)
        toy.pose = Pose(1.0, 0.6, 0.0)
        toy.wait(1.0)
        if loss == "REVOKED":
            answer_corridor(toy, "REVOKED")
        else:
            toy.clock(61.0)
        assert corridors(toy)[0] == ("e0", loss)
        if behaviour == "STOP":
            assert toy.vehicle.leg is None
            assert toy.faults == ["RELEASE_LOST"]
            assert toy.vehicle.errors[0].references["edgeId"] == "e0"
            answer_corridor(toy, "GRANTED")
            assert toy.vehicle.path_of(toy.vehicle.leg) is None
        else:
            assert toy.vehicle.path_of(toy.vehicle.leg) is not None
            toy.pose = Pose(1.2, 0.0, 0.0)
            toy.wait(1.0)
            assert corridors(toy) == [("e2", "REQUESTED")]
            toy.clock(toy.now + 11.0)
            assert sorted(corridors(toy)) == [("e0", "REQUESTED"), ("e2", "REQUESTED")]
        assert toy.faults == []


def test_requests_are_valid_in_the_state_and_their_numbers_are_never_used_twice():
    toy = toy_with(zone("RELEASE", 1.0, 5.0), zone("COORDINATED_REPLANNING", 2.5, 3.5))
    toy.send(corridor_order())
    toy.wait(0.1)
    vehicle = toy.vehicle
    asked = (*vehicle.zones.requests, *vehicle.edge_requests)
    assert len({each.request_id for each in asked}) == len(asked) == 4
    state = msgspec.structs.replace(
        toy.state(), zone_requests=vehicle.zones.requests, edge_requests=vehicle.edge_requests
    )
    told = msgspec.json.decode(toy.dialect.write("state", state))
    read = Reader("3.0", is_lenient=False).record(told, "state")
    assert [each["requestType"] for each in read["zoneRequests"]] == ["ACCESS", "REPLANNING"]
    assert {each["requestType"] for each in read["edgeRequests"]} == {"CORRIDOR"}


def test_zones_become_a_mask_and_a_limit():
    toy = toy_with(
        zone("BLOCKED", 10.0, 12.0), zone("PENALTY", 14.0, 16.0, penaltyFactor=0.5),
        zone("SPEED_LIMIT", 18.0, 19.0, maxSpeed=0.1), zone("RELEASE", 20.0, 21.0),
    )  # fmt: skip
    zones = toy.vehicle.zones
    mask = zones.mask(Grid(np.zeros((40, 500), np.int8), 0.05, 0.0, -1.0), [])
    values = [int(mask.cells[mask.cell_of(x, 0.0)]) for x in (9.0, 11.0, 15.0, 18.5, 20.5)]
    assert values == [0, KEEPOUT, 50, 0, KEEPOUT]
    assert zones.limit_at(17.6, 0.0) == 0.1
    assert zones.limit_at(16.0, 0.0) == np.inf


def test_a_preferred_zone_makes_all_others_cost_more():
    toy = toy_with(
        zone("PRIORITY", 2.0, 6.0, priorityFactor=0.5),
        zone("PRIORITY", 4.0, 6.0, priorityFactor=1.0), zone("BLOCKED", 10.0, 12.0),
    )  # fmt: skip
    mask = toy.vehicle.zones.mask(Grid(np.zeros((40, 300), np.int8), 0.05, 0.0, -1.0), [])
    values = [int(mask.cells[mask.cell_of(x, 0.0)]) for x in (1.0, 3.0, 5.0, 11.0)]
    assert values == [KEEPOUT - 1, 49, 0, KEEPOUT]


def test_in_a_line_guided_zone_the_line_of_an_edge_is_followed():
    toy = toy_with(zone("LINE_GUIDED", 3.0, 5.0))
    toy.send(along(0, 4, 4))
    assert [node.node_id for node in toy.vehicle.leg.nodes] == ["n1"]
    assert toy.vehicle.path_of(toy.vehicle.leg) is None
    toy.step()
    assert [node.node_id for node in toy.vehicle.leg.nodes] == ["n2", "n3"]
    path = toy.vehicle.path_of(toy.vehicle.leg)
    assert path[0].tolist() == [2.0, 0.0]
    assert path[-1].tolist() == [6.0, 0.0]
    toy.drive()
    assert toy.vehicle.last_node == ("n4", 8)


@pytest.mark.parametrize(
    ("bad", "name"),
    [
        (zone("BIDIRECTED", 1.0, 2.0, direction=0.0, limitation="STRICT"), "VALIDATION"),
        (zone("DIRECTED", 1.0, 2.0, direction=0.0), "VALIDATION"),
        (zone("ACTION", 1.0, 2.0, **NO_ACTIONS | {"exitActions": [PICK]}), "UNSUPPORTED"),
        (zone("ACTION", 1.0, 2.0, entryActions=[]), "VALIDATION"),
        (zone("SPEED_LIMIT", 1.0, 2.0), "VALIDATION"),
        (zone("PENALTY", 1.0, 2.0, penaltyFactor=2.0), "VALIDATION"),
        (zone("BLOCKED", 1.0, 1.0), "VALIDATION"),
        (zone("BLOCKED", 1.0, 1e308), "VALIDATION"),
    ],
)
def test_a_bad_zone_set_is_not_taken(bad, name):
    toy = Toy(OF_3)
    hear(toy, "zoneSet", zoneSet={"mapId": MAP, "zoneSetId": "z", "zones": [bad]})
    assert toy.faults == [name]
    assert toy.vehicle.zones.states == ()


def test_a_zone_set_is_neither_replaced_nor_deleted_while_it_is_enabled():
    toy = toy_with(zone("BLOCKED", 10.0, 12.0))
    hear(toy, "zoneSet", zoneSet={"mapId": MAP, "zoneSetId": "z", "zones": []})
    assert toy.faults == ["ZONE_SET"]
    hear(toy, "zoneSet", zoneSet={"mapId": MAP, "zoneSetId": "y", "zones": []})
    assert toy.faults == []
    toy.do("deleteZoneSet", "d1", zoneSetId="z")
    toy.do("enableZoneSet", "e2", zoneSetId="y")
    toy.do("deleteZoneSet", "d2", zoneSetId="z")
    assert [toy.done[key] for key in ("d1", "e2", "d2")] == ["FAILED", "FINISHED", "FINISHED"]
    assert toy.vehicle.zones.costs == {}
