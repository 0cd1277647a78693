"""Zones of VDA 5050 3.0 in a real run: directions, actions, what is lost; actions done again."""

import itertools
import json

import pytest

from tests.fakes.fleet_orders import action, edge, node, on_wire
from tests.fakes.real_swarm import RealSwarm
from tests.fakes.ros_domains import reserved_domain
from tests.graph.test_vda5050 import HAS_BROKER, WORLD, Listener, free_port

ROBOT = "Srobot1"
LANE = (-1.0, -6.0, 1.0, 4.0)  # west only; leaves a way along the north wall
YARD = (-4.0, -5.5, -2.0, -2.5)
EAST, WEST, SOUTH = (3.0, 0.0), (-3.5, 0.0), (-3.0, -4.0)


def box(name, kind, left, low, right, high, **more):
    corners = [(left, low), (right, low), (right, high), (left, high)]
    vertices = [{"x": x, "y": y} for x, y in corners]
    return {"zoneId": name, "zoneType": kind, "vertices": vertices} | more


LOOK = {
    "actionType": "wait",
    "blockingType": "HARD",
    "actionParameters": [{"key": "duration", "value": 1.0}],
}
ZONES = [
    box("lane", "DIRECTED", *LANE, direction=3.141592, limitation="RESTRICTED"),
    box("yard", "ACTION", *YARD, entryActions=[LOOK], duringActions=[], exitActions=[LOOK]),
    box("dock", "RELEASE", *YARD, releaseLossBehavior="EVACUATE"),
]


class Fleet(Listener):
    """A fleet control of 3.0 that drives one robot."""

    numbers = itertools.count()

    def do(self, kind, **parameters):
        name = f"{kind}-{next(self.numbers)}"
        told = {"serialNumber": ROBOT, "actions": [action(kind, name, "NONE", **parameters)]}
        self.send(ROBOT, "instantActions", on_wire("instantActions", told, "3.0"))
        self.wait(lambda: self.status(name) in ("FINISHED", "FAILED"), name)
        return self.status(name)

    def status(self, action_id):
        states = self.now["actionStates"], self.now["instantActionStates"]
        found = [each for each in itertools.chain(*states) if each["actionId"] == action_id]
        return found[0]["actionStatus"] if found else ""

    @property
    def now(self):
        return self.state(ROBOT)

    @property
    def pose(self):
        return self.now["mobileRobotPosition"]

    @property
    def zone_actions(self):
        return [each["actionStatus"] for each in self.now["zoneActionStates"]]

    def order(self, name, place, *actions):
        nodes = [
            node(0, x=self.pose["x"], y=self.pose["y"], mapId=WORLD),
            node(1, *actions, x=place[0], y=place[1], mapId=WORLD),
        ]
        parts = {"serialNumber": ROBOT, "orderId": name, "orderUpdateId": 0, "nodes": nodes}
        self.send(ROBOT, "order", on_wire("order", parts | {"edges": [edge(0)]}, "3.0"))
        self.wait(lambda: self.now["orderId"] == name, f"it takes {name}")

    def go(self, name, place):
        """Drive to a place; return the places on the way, and the ways that it told."""
        count = len(self.all(ROBOT, "visualization"))
        self.order(name, place)
        self.wait(lambda: self.now["nodeStates"] == [], f"it arrives: {name}")
        assert self.now["errors"] == []
        seen = self.all(ROBOT, "visualization")[count:]
        ways = [each["plannedPath"]["trajectory"] for each in seen if "plannedPath" in each]
        return (
            [(each["mobileRobotPosition"]["x"], each["mobileRobotPosition"]["y"]) for each in seen],
            [[(point["x"], point["y"]) for point in way["controlPoints"]] for way in ways],
        )

    def grant(self, kind):
        (request,) = self.now["zoneRequests"]
        answer = {"requestId": request["requestId"], "grantType": kind}
        told = {"serialNumber": ROBOT, "responses": [answer]}
        self.send(ROBOT, "responses", on_wire("responses", told, "3.0"))


def eastward_in_lane(points):
    """Return the steps of a way that lead east through the lane."""
    left, low, right, high = LANE
    return [
        (a, b)
        for a, b in itertools.pairwise(points)
        if all(left < x < right and low < y < high for x, y in (a, b)) and b[0] > a[0] + 0.02
    ]


@pytest.fixture
def fleet(tmp_path_factory):
    port = free_port()
    with reserved_domain() as domain:
        up = RealSwarm(
            tmp_path_factory.mktemp("zones"), domain, "--swarm-size", "2", "--world", WORLD,
            "--vda5050", f"embedded:{port}", "--vda5050-version", "3.0", "--drive", "planar",
            "--speed", "4", "--headless", "--no-report",
        )  # fmt: skip
        try:
            up.wait_until_active()
            up.wait_until(lambda: "VDA 5050: 2 robots at" in up.output)
            listener = Fleet(port, "vda5050/v3/swarm")
            listener.wait(lambda: listener.all(ROBOT, "state"), "it is there")
            yield listener
        finally:
            up.close()


@pytest.mark.slow
@pytest.mark.skipif(not HAS_BROKER, reason="mosquitto is not installed")
def test_a_robot_heeds_the_zones_of_its_fleet_control(fleet, tmp_path):
    fleet.go("to the west", WEST)
    path = tmp_path / "zones.json"
    path.write_text(json.dumps({"mapId": WORLD, "zoneSetId": "z", "zones": ZONES}))
    link = {"zoneSetId": "z", "zoneSetDownloadLink": path.as_uri()}
    assert fleet.do("downloadZoneSet", **link) == "FINISHED"
    assert fleet.do("downloadZoneSet", **link) == "FAILED"
    assert [each["errorType"] for each in fleet.now["errors"]] == ["DUPLICATE_ZONE_SET"]
    assert fleet.do("enableZoneSet", zoneSetId="z") == "FINISHED"

    seen, ways = fleet.go("to the east", EAST)
    assert max(y for _, y in seen) > LANE[3]
    assert not eastward_in_lane(seen)
    assert ways
    assert not [way for way in ways if eastward_in_lane(way)]
    seen, _ = fleet.go("back", WEST)
    assert max(y for _, y in seen) < 2.0

    pick = action("pick", "pick", duration=1.0) | {"retriable": True}
    fleet.order("into the yard", SOUTH, pick)
    fleet.wait(lambda: fleet.now.get("zoneRequests"), "it asks for the zone")
    fleet.grant("GRANTED")
    fleet.wait(lambda: fleet.zone_actions == ["FINISHED"], "it has looked around")
    fleet.wait(lambda: fleet.now["driving"], "it drives on")
    fleet.grant("REVOKED")
    fleet.wait(lambda: len(fleet.zone_actions) == 2, "it leaves the zone")
    assert fleet.do("clearZoneActions") == "FINISHED"
    assert fleet.do("simFailAction", actionType="pick") == "FINISHED"
    fleet.wait(lambda: is_asked(fleet.now), "it asks again")
    assert fleet.now["errors"] == []
    fleet.grant("GRANTED")
    fleet.wait(lambda: fleet.status("pick") == "RETRIABLE", "its action fails")
    assert fleet.do("retry", actionId="pick") == "FINISHED"
    fleet.wait(lambda: fleet.status("pick") == "FINISHED", "it does it again")
    assert fleet.now["nodeStates"] == [] == fleet.now["errors"]
    assert fleet.now["loads"] != []


def is_asked(state):
    return [each["requestStatus"] for each in state.get("zoneRequests", ())] == ["REQUESTED"]
