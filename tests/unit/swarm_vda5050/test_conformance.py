"""The verdict on a fleet control: each rule is broken by a message, and by that alone."""

import copy
import json

import pytest

from swarm_vda5050.conformance import RULES, Conformance, Heard, summary
from swarm_vda5050.faults import ActiveError, OrderFault, OrderRejectedError
from tests.fakes.fleet_orders import (
    MAP,
    OF_3,
    SPACING,
    Toy,
    action,
    along,
    header,
    node,
    on_wire,
    order,
)


class Judged:
    """A toy robot, and the verdict on who sends it messages."""

    def __init__(self, *, is_lenient=False, edges=None, places=None):
        self.toy = Toy()
        self.toy.dialect.is_lenient = is_lenient
        self.notes: list[str] = []
        self.conformance = Conformance("2.1", self.notes.append, edges, places)
        self.count = 0

    def hear(self, topic, content, *, is_retained=False, **changes):
        self.count += 1
        time = f"2026-01-01T00:{self.count // 60:02}:{self.count % 60:02}Z"
        told = header() | {"headerId": self.count, "timestamp": time}
        told |= {k: v for k, v in copy.deepcopy(content).items() if k not in header()} | changes
        self.renumber(told)
        data, message, forgiven = json.dumps(told).encode(), None, []
        has_waited = self.toy.vehicle.waits_for_base
        try:
            if is_retained:
                raise OrderRejectedError(OrderFault.VALIDATION, "kept")
            message = self.toy.dialect.read(topic, data)
        except OrderRejectedError as error:
            answers = [ActiveError(error.fault, str(error), {})]
        else:
            forgiven = self.toy.dialect.forgiven
            answers = self.toy.vehicle.receive(message)
        heard = Heard("Srobot1", topic, data, is_retained, message, answers, forgiven, has_waited)
        self.conformance.judge(heard)

    def renumber(self, told):
        """Begin a new order at sequenceId 0."""
        if told.get("orderId", self.toy.vehicle.order_id) == self.toy.vehicle.order_id:
            return
        first = told["nodes"][0]["sequenceId"]
        for part in (*told["nodes"], *told["edges"]):
            part["sequenceId"] -= first

    @property
    def broken(self):
        return [each["rule"] for each in self.report["rules"] if each["broken"]]

    @property
    def report(self):
        return self.conformance.report("strict", {})


def good(judged):
    """Send what breaks no rule: an order, an update, an instant action."""
    judged.hear("order", along(0, 1, 2))
    judged.hear("order", along(1, 2, 2, update=1))
    judged.hear("instantActions", {"actions": [action("stateRequest", "s", "NONE")]})


def test_a_good_fleet_control_keeps_the_rules_that_it_touches():
    judged = Judged(edges={("n0", "n1"), ("n1", "n2")})
    good(judged)
    assert judged.broken == []
    assert judged.notes == []
    seen = {rule["rule"] for rule in judged.report["rules"] if rule["kept"]}
    assert {"schema", "headerId", "structure", "stitching", "base", "layout", "actions"} <= seen
    assert "zone sets" not in seen
    assert summary(judged.report).endswith("and broke none")


def test_rules_are_seen_in_the_messages_that_they_are_about():
    judged = Judged()
    good(judged)
    judged.hear("instantActions", actions("dance"))
    seen = {rule["rule"]: rule["seen"] for rule in judged.report["rules"]}
    for rule in ("schema", "version", "retained", "headerId", "timestamp"):
        assert seen[rule] == 4, rule
    assert (seen["actions"], seen["instant actions"]) == (2, 2)
    assert seen["cancel"] == seen["maps"] == 0


def test_faults_on_demand_are_not_judged():
    judged = Judged()
    good(judged)
    judged.hear("instantActions", actions("simError"), headerId=0, timestamp="2020-01-01T00:00:00Z")
    assert judged.broken == []
    assert judged.report["messages"] == 3
    judged.hear("instantActions", actions("stateRequest", "simError"), headerId=0)
    assert "headerId" in judged.broken


def actions(*kinds):
    return {"actions": [action(kind, f"{kind}-1", "NONE") for kind in kinds]}


@pytest.mark.parametrize(
    ("rule", "topic", "content", "changes"),
    [
        ("schema", "order", along(2, 3, 3, "B"), {"speed": 1}),
        ("version", "order", along(2, 3, 3, "B"), {"version": "2.0.0"}),
        ("headerId", "order", along(2, 3, 3, "B"), {"headerId": 1}),
        ("timestamp", "order", along(2, 3, 3, "B"), {"timestamp": "2026-01-01T01:00:00+01:00"}),
        ("timestamp", "order", along(2, 3, 3, "B"), {"timestamp": "2025-01-01T00:00:00Z"}),
        ("ids", "order", along(2, 3, 3, "B B"), {}),
        ("structure", "order", along(2, 3, 3, "B") | {"edges": []}, {}),
        ("first update", "order", along(2, 3, 3, "B", update=4), {}),
        ("orderId", "order", along(2, 3, 3, "Z"), {}),
        ("start", "order", along(0, 1, 1, "B"), {}),
        ("orderUpdateId", "order", along(2, 3, 3, update=0), {}),
        ("orderUpdateId", "order", along(2, 4, 4, update=1), {}),
        ("stitching", "order", along(1, 3, 3, update=2), {}),
        ("base", "order", order([node(2, theta=1.0), node(3)], update=2), {}),
        ("map", "order", order([node(2), node(3, mapId="moon")], "B"), {}),
        ("actions", "order", order([node(2, action("dance", "d"))], "B"), {}),
        ("optional fields", "order", along(2, 3, 3, "B") | {"nodes": [
            {k: v for k, v in node(2).items() if k != "nodePosition"}], "edges": []}, {}),
        ("instant actions", "instantActions", actions("dance"), {}),
        ("maps", "instantActions", {"actions": [action(
            "downloadMap", "m", "NONE", mapId=MAP, mapVersion="1", mapDownloadLink="file:///m.zip",
        )]}, {}),
        ("cancel", "instantActions", actions("cancelOrder"), {}),
    ],
)  # fmt: skip
def test_each_rule_is_broken_by_its_message(rule, topic, content, changes):
    judged = Judged()
    judged.hear("order", along(0, 0, 0, "Z"))
    good(judged)
    judged.toy.drive()
    judged.hear(topic, content, **changes)
    assert judged.broken == [rule]
    (found,) = (each for each in judged.report["rules"] if each["rule"] == rule)
    assert found["first"]["problem"]
    assert json.loads(found["first"]["message"])
    assert len(judged.notes) == 1
    assert judged.report["broken"] == ([rule] if RULES[rule].is_duty else [])


def test_orders_that_do_not_fit_the_state_break_their_rules():
    judged = Judged(edges={("n0", "n1")})
    judged.hear("order", along(0, 2, 2))
    judged.hear("order", along(0, 1, 1, "B"))
    judged.hear("instantActions", actions("cancelOrder"))
    judged.toy.wait(1.0)
    judged.hear("order", along(2, 3, 3, update=1))
    judged.hear("order", along(0, 1, 1, "C"), is_retained=True)
    assert judged.broken == ["retained", "one order", "after cancel", "layout"]


def test_a_lenient_one_takes_what_it_understands_and_says_what_it_forgave():
    judged = Judged(is_lenient=True)
    content = order([node(0), node(1, x="2.0", theta=9.0)])
    content["edges"][0]["maximumSpeed"] = 0.1
    judged.hear("order", content)
    assert [state.node_id for state in judged.toy.vehicle.node_states] == ["n1"]
    assert judged.toy.vehicle.leg.max_speed == 0.1
    assert judged.broken == []
    (schema,) = (each for each in judged.report["rules"] if each["rule"] == "schema")
    assert schema["forgiven"] == 1
    for word in ("x is '2.0'", "theta is 9", "maximumSpeed is a field of 3.0"):
        assert word in schema["first"]["problem"]
    assert MAP == "hall"


class Master:
    """A small fleet control, right but for one planted fault."""

    def __init__(self, fault):
        edges = {(f"n{number}", f"n{number + 1}") for number in range(9)}
        places = {f"n{number}": (SPACING * number, 0.0) for number in range(10)}
        self.fault = fault
        self.judged = Judged(edges=edges, places=places)

    def work(self):
        """Send an order, its update, a cancel and the next order."""
        toy, send = self.judged.toy, self.judged.hear
        content = along(0, 1, 3)
        if self.fault == "a wrong place":
            content["nodes"][3]["nodePosition"]["y"] += 0.4
        send("order", content)
        if self.fault == "a late update":
            toy.drive()
        update = along(1, 3, 3, update=1)
        if self.fault == "a gap":
            for part in (*update["nodes"][1:], *update["edges"]):
                part["sequenceId"] += 2
        if self.fault == "a wrong stitch":
            update["nodes"][0]["nodePosition"]["x"] += 0.4
        send("order", update, **({"headerId": 1} if self.fault == "the same headerId" else {}))
        toy.step()
        send("instantActions", actions("cancelOrder"))
        if self.fault == "an order before the cancel ends":
            send("order", along(1, 2, 2, "early"))
        if self.fault == "a cancel that is ignored":
            send("order", along(3, 4, 4, update=2))
        toy.wait(1.0)
        number = round(toy.pose.x / SPACING)
        send("order", along(number, number + 1, number + 1, "B"))
        if self.fault == "a stale order":
            send("order", along(0, 1, 1, "old"), is_retained=True)


@pytest.mark.parametrize(
    ("fault", "rules"),
    [
        ("", set()),
        ("a gap", {"structure"}),
        ("a wrong place", {"layout"}),
        ("a wrong stitch", {"base", "layout"}),
        ("a late update", {"horizon"}),
        ("the same headerId", {"headerId"}),
        ("an order before the cancel ends", {"one order"}),
        ("a cancel that is ignored", {"after cancel"}),
        ("a stale order", {"retained"}),
    ],
)
def test_a_fault_planted_into_a_fleet_control_is_named(fault, rules):
    master = Master(fault)
    master.work()
    assert set(master.judged.broken) == rules


def test_an_answer_to_no_request_breaks_its_rule():
    toy, notes = Toy(OF_3), []
    conformance = Conformance("3.0", notes.append)
    content = {"responses": [{"requestId": "1", "grantType": "GRANTED"}]}
    for number, responses in enumerate(([], content["responses"]), 1):
        told = {"headerId": number, "responses": responses}
        data = on_wire("responses", told, "3.0")
        message = toy.dialect.read("responses", data)
        answers = toy.vehicle.receive(message)
        conformance.judge(Heard("Srobot1", "responses", data, False, message, answers, []))
    assert conformance.broken == ["responses"]
    (rule,) = (each for each in conformance.report("strict", {})["rules"] if each["broken"])
    assert (rule["kept"], rule["first"]["problem"]) == (1, "there was no request '1'")
