"""Zone sets of version 3.0, and releases."""

import numpy as np
import pytest

from swarm_common.model.grid import KEEPOUT, Grid
from tests.fakes.fleet_orders import MAP, OF_3, Toy, along

NO_ACTIONS = {"entryActions": [], "duringActions": [], "exitActions": []}
LATER = "2026-01-01T00:01:00Z"


def zone(kind, first, last, **more):
    corners = [(first, -1.0), (last, -1.0), (last, 1.0), (first, 1.0)]
    vertices = [{"x": x, "y": y} for x, y in corners]
    return {"zoneId": f"{kind}{first:g}", "zoneType": kind, "vertices": vertices} | more


def hear(toy, topic, **content):
    toy.hear(topic, content)


def toy_with(*zones):
    toy = Toy(OF_3)
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
        (zone("DIRECTED", 1.0, 2.0, direction=0.0, limitation="SOFT"), "UNSUPPORTED"),
        (zone("BIDIRECTED", 1.0, 2.0, direction=0.0, limitation="SOFT"), "UNSUPPORTED"),
        (zone("COORDINATED_REPLANNING", 1.0, 2.0), "UNSUPPORTED"),
        (zone("ACTION", 1.0, 2.0, **NO_ACTIONS), "UNSUPPORTED"),
        (zone("RELEASE", 1.0, 2.0, releaseLossBehavior="EVACUATE"), "UNSUPPORTED"),
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
