"""ACTION zones, retriable actions and triggers: what begins where, and what blocks the way."""

import json

import msgspec
import pytest

from swarm_common.model.records import Pose
from swarm_describe.robots.loading import load_robot
from swarm_vda5050.dialect import Dialect
from swarm_vda5050.factsheet import factsheet
from swarm_vda5050.reading import FieldError, Reader
from swarm_vda5050.zone_actions import MOST_KEPT
from tests.fakes.fleet_orders import MAP, OF_2, OF_3, Toy, action, along, node, order
from tests.unit.swarm_vda5050.test_zones import NO_ACTIONS, hear, toy_with, zone


def wait(duration=2.0, blocking="HARD", **more):
    parameters = [{"key": "duration", "value": duration}]
    return {"actionType": "wait", "blockingType": blocking, "actionParameters": parameters} | more


def trigger(kinds=("FLEET_CONTROL",)):
    parameters = [{"key": "triggerType", "value": list(kinds)}]
    return {"actionType": "waitForTrigger", "blockingType": "HARD", "actionParameters": parameters}


def action_zone(first=3.0, last=5.0, **actions):
    return zone("ACTION", first, last, **NO_ACTIONS | actions)


def toy_in(**actions):
    """Return a toy that has looked at an ACTION zone from outside."""
    toy = toy_with(action_zone(**actions))
    toy.wait(0.1)
    return toy


def at(toy, x):
    toy.pose = Pose(x, 0.0, 0.0)
    toy.wait(0.5)
    return [str(state.action_status) for state in toy.vehicle.zone_action_states]


def test_actions_begin_as_the_body_comes_in_and_leaves_and_block_the_way():
    toy = toy_in(entryActions=[wait()], exitActions=[wait(1.0, "NONE")])
    toy.send(along(0, 4, 4))
    assert at(toy, 2.7) == []
    assert toy.vehicle.leg is not None
    assert at(toy, 2.85) == ["RUNNING"]  # its radius is 0.2 m
    assert toy.vehicle.leg is None
    toy.wait(2.0)
    assert at(toy, 4.0) == ["FINISHED"]
    assert toy.vehicle.leg is not None
    assert at(toy, 5.1) == ["FINISHED"]
    assert at(toy, 5.3) == ["FINISHED", "RUNNING"]
    assert toy.vehicle.leg is not None
    toy.wait(2.0)
    toy.do("clearZoneActions", "c")
    assert toy.vehicle.zone_action_states == ()
    assert toy.faults == []


def test_what_runs_in_a_zone_ends_as_the_robot_leaves_it_and_is_reported_once():
    toy = toy_in(duringActions=[wait(60.0, "NONE")])
    assert at(toy, 4.0) == ["RUNNING"]
    assert at(toy, 6.0) == ["FAILED"]
    assert toy.faults == ["ACTION"]
    toy.pose = Pose(0.0, 0.0, 0.0)
    toy.wait(0.5)  # back through the zone between two looks
    assert [str(s.action_status) for s in toy.vehicle.zone_action_states] == ["FAILED", "FAILED"]
    toy.send(along(0, 1, 1))
    assert toy.faults == []
    ids = [state.action_id for state in toy.vehicle.zone_action_states]
    assert len(set(ids)) == 2


def test_who_is_in_a_zone_as_it_is_enabled_crosses_it_but_has_not_come_in():
    toy = Toy(OF_3)
    toy.pose = Pose(4.0, 0.0, 0.0)
    toy.sense()
    zones = [action_zone(entryActions=[wait()], duringActions=[wait(60.0, "NONE")])]
    hear(toy, "zoneSet", zoneSet={"mapId": MAP, "zoneSetId": "z", "zones": zones})
    toy.do("enableZoneSet", "e", zoneSetId="z")
    assert at(toy, 4.0) == ["RUNNING"]


def test_who_is_driven_by_hand_does_nothing_in_zones():
    toy = toy_in(entryActions=[wait()], duringActions=[wait(60.0)])
    assert at(toy, 4.0) == ["RUNNING", "WAITING"]
    toy.sense(is_by_hand=True)
    assert [str(s.action_status) for s in toy.vehicle.zone_action_states] == ["FAILED", "FAILED"]
    toy.pose = Pose(0.0, 0.0, 0.0)
    toy.sense(is_by_hand=True)
    toy.pose = Pose(4.0, 0.0, 0.0)
    toy.sense(is_by_hand=True)
    assert len(toy.vehicle.zone_action_states) == 2


def test_only_the_latest_actions_are_kept():
    toy = toy_in(entryActions=[wait(0.1, "NONE")])
    for _ in range(MOST_KEPT + 5):
        at(toy, 0.0)
        at(toy, 4.0)
    assert len(toy.vehicle.zone_action_states) <= MOST_KEPT + 1


def test_states_of_zones_are_in_the_state_of_3_0_only():
    toy = toy_in(entryActions=[wait()])
    at(toy, 4.0)
    state = msgspec.structs.replace(toy.state(), zone_action_states=toy.vehicle.zone_action_states)
    told = json.loads(toy.dialect.write("state", state))
    Reader("3.0", is_lenient=False).record(told, "state")
    (found,) = told["zoneActionStates"]
    assert (found["actionType"], found["actionStatus"]) == ("wait", "RUNNING")
    assert "zoneActionStates" not in json.loads(Dialect(OF_2).write("state", state))


def test_a_trigger_ends_all_that_wait_for_one():
    toy = toy_in(entryActions=[trigger()])
    toy.send(order([node(0), node(1, trigger() | {"actionId": "t"}), node(2), node(3)]))
    toy.do("trigger", "early")
    assert toy.done["early"] == "FAILED"
    assert toy.faults == ["INSTANT"]
    toy.step()
    toy.wait(100.0)
    assert toy.done["t"] == "RUNNING"
    assert toy.vehicle.leg is None
    toy.do("trigger", "now")
    assert (toy.done["t"], toy.done["now"]) == ("FINISHED", "FINISHED")
    assert at(toy, 4.0) == ["RUNNING"]
    toy.do("cancelOrder", "c")
    toy.wait(0.1)
    assert at(toy, 4.0) == ["FAILED"]  # a cancelled order waits for no trigger


def test_a_trigger_that_nobody_can_give_is_not_waited_for():
    toy = Toy(OF_3)
    toy.send(order([node(0, trigger(["LOCAL"]) | {"actionId": "t"})]))
    assert toy.faults == ["UNKNOWN_ACTION"]
    assert "expected an array with FLEET_CONTROL" in toy.vehicle.errors[0].message


def retriable(*actions, **more):
    """Return a toy whose next pick has failed at node 1, and can be done again."""
    toy = Toy(OF_3)
    pick = action("pick", "p", **more) | {"retriable": True}
    toy.send(order([node(0), node(1, pick, *actions), node(2)]))
    toy.do("simFailAction", "fail", actionType="pick")
    toy.step()
    toy.wait(0.1)
    assert toy.done["p"] == "RETRIABLE"
    assert toy.vehicle.leg is None
    assert "ACTION" not in toy.faults
    return toy


def test_a_failed_action_is_done_again_on_demand():
    toy = retriable(action("wait", "w", duration=1.0))
    toy.wait(100.0)
    assert (toy.done["p"], toy.done["w"]) == ("RETRIABLE", "WAITING")
    toy.do("retry", "r", actionId="p")
    assert (toy.done["p"], toy.done["r"]) == ("RUNNING", "FINISHED")
    toy.wait(5.1)
    assert toy.done["p"] == "FINISHED"
    assert toy.vehicle.load is not None
    toy.wait(1.1)
    toy.drive()
    assert toy.vehicle.last_node == ("n2", 4)
    assert toy.faults == []


def test_a_failed_action_is_skipped_on_demand_and_the_order_goes_on():
    toy = retriable()
    toy.do("skipRetry", "s", actionId="p")
    assert (toy.done["p"], toy.done["s"]) == ("FAILED", "FINISHED")
    assert toy.faults == ["ACTION"]
    toy.drive()
    assert toy.vehicle.last_node == ("n2", 4)


@pytest.mark.parametrize("kind", ["retry", "skipRetry"])
def test_only_what_is_retriable_is_done_again(kind):
    toy = retriable(action("wait", "w", duration=1.0))
    for name in ("w", "nobody"):
        toy.do(kind, f"r {name}", actionId=name)
        assert toy.done[f"r {name}"] == "FAILED"
    assert "INSTANT" in toy.faults
    toy.do(kind, "good", actionId="p")
    assert toy.faults == ([] if kind == "retry" else ["ACTION"])


def test_a_paused_robot_does_again_what_it_is_told_once_it_goes_on():
    toy = retriable()
    toy.do("startPause", "pause")
    toy.do("retry", "r", actionId="p")
    assert toy.done["p"] == "PAUSED"
    toy.do("stopPause", "go")
    toy.wait(5.1)
    assert toy.done["p"] == "FINISHED"


def test_a_retriable_action_ends_with_its_order():
    toy = retriable()
    toy.do("cancelOrder", "c")
    toy.wait(0.1)
    assert (toy.done["p"], toy.done["c"]) == ("FAILED", "FINISHED")


def test_what_is_not_retriable_fails_at_once():
    toy = Toy(OF_3)
    toy.send(order([node(0), node(1, action("pick", "p"))]))
    toy.do("simFailAction", "fail")
    toy.step()
    toy.wait(0.1)
    assert toy.done["p"] == "FAILED"


def test_the_factsheet_says_what_there_is():
    sheet = factsheet(load_robot("turtlebot3_burger"), OF_3.offered, "3.0")
    scopes = {each["actionType"]: each["actionScopes"] for each in
              sheet["protocolFeatures"]["agvActions"]}  # fmt: skip
    assert [kind for kind, each in scopes.items() if "ZONE" in each] == ["wait", "waitForTrigger"]
    assert {"retry", "skipRetry", "trigger", "downloadZoneSet", "clearZoneActions"} <= set(scopes)
    optional = [each["parameter"] for each in sheet["protocolFeatures"]["optionalParameters"]]
    assert "order.nodes.actions.retriable" in optional
    assert len(sheet["typeSpecification"]["supportedZones"]) == 10
    older = factsheet(load_robot("turtlebot3_burger"), OF_2.offered, "2.1")
    kinds = {each["actionType"] for each in older["protocolFeatures"]["agvActions"]}
    assert not {"retry", "waitForTrigger", "downloadZoneSet"} & kinds
    assert not any("retriable" in each["parameter"] for each in
                   older["protocolFeatures"]["optionalParameters"])  # fmt: skip


LINK = "http://127.0.0.1/zones.json"


def fetch(toy, key, name="z", link=LINK, **more):
    toy.do("downloadZoneSet", key, zoneSetId=name, zoneSetDownloadLink=link, **more)
    return toy.done[key]


def zone_file(name="z", **more):
    return {"mapId": MAP, "zoneSetId": name, "zones": [zone("BLOCKED", 3.0, 5.0)]} | more


@pytest.mark.parametrize("content", [zone_file(), {"zoneSet": zone_file(), "version": "3.0.0"}])
def test_a_zone_set_is_downloaded_and_enabled(content):
    toy = Toy(OF_3)
    assert fetch(toy, "d", zoneSetHash="a" * 64) == "INITIALIZING"
    (download,) = toy.vehicle.take_requests().downloads
    assert download == ("d", LINK, "a" * 64, False)
    toy.vehicle.begin_download("d")
    toy.wait(100.0)
    assert toy.done["d"] == "RUNNING"
    toy.vehicle.end_download("d", "", toy.dialect.zone_set(json.dumps(content).encode()))
    assert toy.done["d"] == "FINISHED"
    assert [state.zone_set_status for state in toy.vehicle.zones.states] == ["DISABLED"]
    assert fetch(toy, "again") == "FAILED"
    assert toy.faults == ["ZONE_SET"]
    assert toy.vehicle.errors[0].references == {"zoneSetId": "z", "actionId": "again"}


@pytest.mark.parametrize(
    ("name", "problem", "zones", "fault"),
    [
        ("z", "nobody answers", None, "ACTION"),
        ("y", "", zone_file(), "ACTION"),
        ("z", "", zone_file(mapId="elsewhere"), "UNKNOWN_MAP"),
    ],
)
def test_a_zone_set_that_cannot_be_had_is_reported(name, problem, zones, fault):
    toy = Toy(OF_3)
    fetch(toy, "d", name)
    found = None if zones is None else toy.dialect.zone_set(json.dumps(zones).encode())
    toy.vehicle.end_download("d", problem, found)
    assert toy.done["d"] == "FAILED"
    assert toy.faults == [fault]
    hear(toy, "zoneSet", zoneSet=zone_file("good"))
    assert toy.faults == []


@pytest.mark.parametrize("more", [{"link": "ftp://x/z.json"}, {"zoneSetHash": "abc"}])
def test_a_link_that_leads_nowhere_is_not_followed(more):
    toy = Toy(OF_3)
    assert fetch(toy, "d", **more) == "FAILED"
    assert toy.vehicle.take_requests().downloads == ()
    assert "zoneSet" in toy.vehicle.errors[0].message


@pytest.mark.parametrize("data", [b"{", b"[]", b"{}", b'{"zoneSet": {"mapId": "m"}}', b"[" * 9999])
def test_a_file_without_a_zone_set_is_none(data):
    with pytest.raises(FieldError):
        Dialect(OF_3).zone_set(data)
