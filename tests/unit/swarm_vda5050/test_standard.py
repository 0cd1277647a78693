"""The tables of the standard: what each version takes, refuses and writes."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vda5050.validation import SchemaValidator

from swarm_vda5050.dialect import Dialect
from swarm_vda5050.faults import OrderRejectedError
from swarm_vda5050.reading import written
from swarm_vda5050.standard import TABLES, VERSIONS, Each, Flag, Number, Record, Text, Words
from tests.fakes.fleet_orders import (
    OF_2,
    OF_3,
    OF_20,
    Toy,
    action,
    along,
    header,
    nurbs,
    on_wire,
)

THEIRS = SchemaValidator()


def order_with(version="2.1", **changes):
    """Return an order of a version; `changes` are of the last node, its position or its edge."""
    content = json.loads(on_wire("order", along(0, 1, 1), version))
    parts = {
        "node": content["nodes"][1],
        "position": content["nodes"][1]["nodePosition"],
        "edge": content["edges"][0],
        "order": content,
    }
    for name, more in changes.items():
        parts[name].update(more)
    return content


def problem_of(content, identity=OF_2, topic="order"):
    """Return why a message is refused; empty if it is taken."""
    try:
        Dialect(identity).read(topic, json.dumps(content).encode())
    except OrderRejectedError as error:
        return str(error)
    return ""


def test_topics_are_those_of_the_version():
    assert OF_20.topic("order") == "uagv/v2/swarm/Srobot1/order"
    assert OF_3.topic("order") == "vda5050/v3/swarm/Srobot1/order"
    assert OF_3.topics == ["order", "instantActions", "zoneSet", "responses"]


@pytest.mark.parametrize("version", VERSIONS)
def test_an_order_of_the_version_is_taken(version):
    identity = {"2.0": OF_20, "2.1": OF_2, "3.0": OF_3}[version]
    assert problem_of(order_with(version), identity) == ""


@pytest.mark.parametrize(
    ("identity", "content", "word"),
    [
        (OF_3, order_with("2.1", order={"version": "3.0.0"}), "startNodeId is a field of 2.0"),
        (OF_3, order_with("3.0", edge={"maxSpeed": 1.0}), "maxSpeed is a field of 2.0 and 2.1"),
        (OF_2, order_with("2.1", edge={"maximumSpeed": 1.0}), "maximumSpeed is a field of 3.0"),
        (OF_2, order_with("2.1", order={"orderDescription": "x"}), "is a field of 3.0"),
        (OF_20, order_with("2.0", edge={"corridor": {}}), "corridor is a field of 2.1 and 3.0"),
        (OF_3, order_with("3.0", position={"allowedDeviationXY": 0.5}), "expected an object"),
        (
            OF_2,
            order_with(position={"allowedDeviationXY": {"a": 1, "b": 1, "theta": 0}}),
            "expected a number",
        ),
        (OF_2, order_with(node={"actions": [action("pick", "p", "SINGLE")]}), "NONE, SOFT, HARD"),
        (OF_2, order_with(edge={"colour": "red"}), "is no field of the standard"),
    ],
)
def test_fields_and_types_of_another_version_are_refused(identity, content, word):
    """They were taken: who migrates saw green, and failed on real vehicles."""
    assert word in problem_of(content, identity)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"position": {"theta": 99.0}}, "theta is 99; expected -3.14159 to 3.14159"),
        ({"position": {"allowedDeviationTheta": 7.0}}, "expected 0 to 3.14159"),
        ({"position": {"x": "2"}}, "x is '2'; expected a number"),
        ({"edge": {"trajectory": {"controlPoints": []}}}, "lacks `degree`"),
        ({"edge": {"trajectory": nurbs((0, 0), (2, 0), knots=[0, 0, 2, 2])}}, "expected 0 to 1"),
        ({"edge": {"corridor": {"leftWidth": -1.0, "rightWidth": 1.0}}}, "leftWidth is -1"),
        ({"order": {"timestamp": "yesterday"}}, "expected a time like"),
        ({"order": {"headerId": -1}}, "headerId is -1; expected 0 to 2^32 - 1"),
        ({"order": {"orderId": "x" * 300_000}}, "300000 characters; expected 1 to 256"),
        ({"order": {"orderUpdateId": 0.5}}, "expected a whole number"),
        ({"node": {"nodeId": ""}}, "expected 1 to 256"),
        ({"node": {"released": 1}}, "released is 1; expected true or false"),
    ],
)
def test_what_the_schema_refuses_is_refused_and_forgiven_only_on_demand(changes, word):
    content = order_with(**changes)
    assert word in problem_of(content)
    toy = Toy()
    toy.dialect.is_lenient = True
    toy.hear("order", content)
    if not toy.vehicle.errors:
        assert any(word in remark for remark in toy.dialect.forgiven)


def test_instant_actions_of_2_0_and_3_0_are_their_own():
    content = header("2.0.0") | {"instantActions": [action("stateRequest", "s", "NONE")]}
    assert problem_of(content, OF_20, "instantActions") == ""
    assert "instantActions is a field of 2.0" in problem_of(content, OF_2, "instantActions")
    content = header("3.0.0") | {"actions": [action("stateRequest", "s", "HARD")]}
    assert "blockingType is 'HARD'; expected NONE" in problem_of(content, OF_3, "instantActions")


TOPICS = ("order", "instantActions", "state", "factsheet", "visualization", "connection")


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_written_is_read_and_has_the_fields_of_the_version(version):
    for topic in TOPICS:
        content = example(topic, version)
        assert written(renamed(content, topic, version), topic, version) == content


def example(table, version):
    """Return an object with all fields that a table has in a version, as on the wire."""
    fields = TABLES[version][table]
    names = {field.inside: wire for wire, field in reversed(fields.items())}
    return {wire: _example(fields[wire].kind, version) for wire in names.values()}


def _example(kind, version):
    match kind:
        case Record(table):
            return example(table, version)
        case Each(inner, least):
            return [_example(inner, version)] * max(least, 1)
        case Words(inside):
            return next(iter(inside))
        case Number(low, high):
            return min(max(low, 0), high)
        case Flag():
            return True
        case Text(is_time=True):
            return "2026-01-01T00:00:00Z"
    return "x"


def renamed(content, table, version):
    """Return what is on the wire with the names inside the package."""
    fields = TABLES[version][table]
    return {fields[w].inside: _renamed(v, fields[w].kind, version) for w, v in content.items()}


def _renamed(value, kind, version):
    match kind:
        case Record(table):
            return renamed(value, table, version)
        case Each(inner):
            return [_renamed(each, inner, version) for each in value]
        case Words(inside):
            return inside[value]
    return value


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(TOPICS), st.data())
def test_the_official_schema_of_2_1_needs_the_same_fields(topic, data):
    content = example(topic, "2.1")
    assert THEIRS.errors(topic, content) == []
    within, table = content, topic
    while True:
        name = data.draw(st.sampled_from(sorted(within)))
        field = TABLES["2.1"][table][name]
        inner = field.kind.kind if isinstance(field.kind, Each) else field.kind
        if not isinstance(inner, Record) or not within[name] or data.draw(st.booleans()):
            break
        within, table = within[name], inner.table
        within = within[0] if isinstance(within, list) else within
    del within[name]
    is_header = within is content and topic in ("factsheet", "instantActions", "visualization")
    assert bool(THEIRS.errors(topic, content)) is field.is_required or is_header, (table, name)
