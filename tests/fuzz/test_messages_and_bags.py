"""Broken messages of fleet controls, bags and order files: understood, or refused in words."""

import contextlib
import copy
import json
import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.model.errors import SwarmError
from swarm_mission.mission import load_mission
from swarm_recording.bag import Bag
from swarm_vda5050.dialect import MESSAGES as KINDS
from swarm_vda5050.faults import OrderRejectedError
from tests.fakes.fleet_orders import (
    OF_2,
    OF_3,
    OF_20,
    Toy,
    action,
    along,
    header,
    node,
    nurbs,
    on_wire,
    order,
)
from tests.fuzz.byte_mutation import EDITS, FUZZ, mutated
from tests.unit.swarm_recording.bags import NOTE, OTHER, notes, write

CURVED = order([node(0), node(1, action("wait", "w", duration=1.0)), node(2), node(3)], "C")
CURVED["edges"][0]["trajectory"] = nurbs((0.0, 0.0), (2.0, 0.0), knots=[0.0, 0.0, 1.0, 1.0])
CURVED["edges"][1]["corridor"] = {"leftWidth": 1.0, "rightWidth": 1.0}
CURVED["edges"][2]["maxSpeed"] = 0.2
DO = header() | {"actions": [action(kind, kind, "NONE") for kind in ("startPause", "stopPause",
                 "cancelOrder", "stateRequest", "factsheetRequest")]}  # fmt: skip
MESSAGES = [
    *(("order", along(0, base, 4, update=base)) for base in (1, 2, 4)),
    ("order", CURVED),
    ("instantActions", DO),
]
ODD = [None, True, -1, 0, 7, 1e308, -0.0, 2**63, "", "n1", "x" * 300, "A", [], {}, [[]], [None] * 9,
       "2", "NaN", {"nodeId": "n1"}, "HARD", "wait", 0.5]  # fmt: skip
CHANGES = st.lists(
    st.tuples(st.floats(0.0, 1.0, exclude_max=True), st.sampled_from(ODD)), max_size=3
)
ORDERS = b"""
orders:
  - {from: a, to: [b, many], every: 60, service: 3, priority: 2, due: 120, batch: 4}
  - {from: b, to: a, shifts: [{begin: 0, end: 300, rate: 30}, {begin: 300, every: 90}]}
groups: {many: [c, d]}
dispatch: claim
capacity: 2
retries: 1
"""


def places(value):
    """Yield each container with each of its keys or indices."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, each in list(items):
        yield value, key
        if isinstance(each, dict | list):
            yield from places(each)


def changed(content, changes):
    content = copy.deepcopy(content)
    for share, value in changes:
        if found := list(places(content)):
            within, key = found[int(share * len(found))]
            within[key] = copy.deepcopy(value)
    return json.dumps(content).encode()


@pytest.mark.parametrize("is_lenient", [False, True])
@FUZZ
@given(
    identity=st.sampled_from([OF_20, OF_2, OF_3]),
    sent=st.lists(st.tuples(st.sampled_from(MESSAGES), CHANGES, EDITS), min_size=1, max_size=6),
)
def test_a_vehicle_is_told_anything_and_says_what_it_does(identity, is_lenient, sent):
    toy = Toy(identity)
    toy.dialect.is_lenient = is_lenient
    for (topic, content), changes, edits in sent:
        told = json.loads(on_wire(topic, content, identity.version))
        data = changed(told, changes) if changes else mutated(json.dumps(told).encode(), edits)
        try:
            toy.vehicle.receive(toy.dialect.read(topic, data))
        except OrderRejectedError as error:
            toy.vehicle.reject(error, KINDS[topic])
        for _ in range(9):
            toy.wait(1.0)
            toy.step()
        toy.vehicle.take_requests()
        json.loads(toy.dialect.write("state", toy.state()))


@FUZZ
@given(edits=EDITS)
def test_orders_with_faults_are_read_or_refused(edits):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "orders.yaml"
        path.write_bytes(mutated(ORDERS, edits))
        with contextlib.suppress(SwarmError):
            load_mission(str(path))


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    made = write(
        tmp_path_factory.mktemp("bag") / "a.mcap", notes(60, (NOTE, OTHER)), chunk_size=300
    )
    return made.read_bytes()


@FUZZ
@given(edits=EDITS)
def test_bags_with_faults_are_read_or_refused(bag, edits):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "broken.mcap"
        path.write_bytes(mutated(bag, edits))
        told: list[str] = []
        with contextlib.suppress(SwarmError), contextlib.closing(Bag(path, told.append)) as found:
            found.gaps(60.0)
            assert sum(1 for _ in found.messages()) <= 200
