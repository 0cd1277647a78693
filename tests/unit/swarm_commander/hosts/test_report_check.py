"""What comes in from other hosts: only what the secret sealed, for this run, once."""

import dataclasses
import json
from typing import Any

import pytest

from swarm_commander.hosts.host_server import FORGED, STALE, UNREADABLE, ReportCheck
from swarm_commander.hosts.host_table import HOSTS, TABLE_TOPIC, HostReport
from swarm_common.middleware.rejections import Rejections
from swarm_common.middleware.sealed import Sealer
from swarm_common.process.pipes import EventWriter

SECRET = "a secret of this swarm"
REPORT = HostReport("a", "first (10.0.0.2)", ("Srobot1",))
CONTENT = dataclasses.asdict(REPORT)


class Door(ReportCheck):
    """Remembers what it said."""

    def __init__(self):
        self.said: list[str] = []
        self._rejections = Rejections(EventWriter(None), self.said.append)
        super().__init__(SECRET, "run 2", self._rejections)

    @property
    def rejected(self):
        return dict(self._rejections.counts)


def door():
    return Door()


def sealed(secret=SECRET, kind=HOSTS, run="run 2", sender="a"):
    return Sealer(secret, kind, sender).seal(run, CONTENT)


def test_a_report_of_this_run_is_taken_and_none_of_the_run_before():
    one = door()
    assert one.take(sealed()) == REPORT
    assert one.rejected == {}
    # A world that crashed and was started again took the old hosts, which leave at once.
    one = door()
    assert one.take(sealed(run="run 1")) is None
    assert one.take(sealed(run="run 1", sender="b")) is None
    assert one.rejected == {STALE: 2}
    assert len(one.said) == 2  # once for each host


def test_neither_forged_nor_wrong_reports_are_taken():
    one = door()
    assert one.take(sealed(secret="a secret of another")) is None
    assert one.take(json.dumps(CONTENT)) is None
    assert one.rejected == {FORGED: 2}
    one = door()
    assert one.take(Sealer(SECRET, HOSTS, "a").seal("run 2", {"robots": 3})) is None
    assert one.take(sealed(sender="b")) is None
    assert one.rejected == {UNREADABLE: 2}


def test_what_was_said_once_or_by_the_other_side_is_not_taken():
    one = door()
    sealer = Sealer(SECRET, HOSTS, "a")
    first, second = sealer.seal("run 2", CONTENT), sealer.seal("run 2", CONTENT)
    assert one.take(second) is not None
    assert one.take(second) is None  # said again
    assert one.take(first) is None  # overtaken
    assert one.rejected == {}
    assert one.take(sealed(kind=TABLE_TOPIC)) is None
    assert one.rejected == {FORGED: 1}


@pytest.mark.parametrize("member", ["run", "sender", "number", "body", "seal"])
def test_no_member_can_be_changed(member):
    data = json.loads(sealed())
    data[member] = 2 if member == "number" else data[member].replace("a", "b").replace("2", "3")
    one = door()
    assert one.take(json.dumps(data)) is None
    assert one.rejected == {FORGED: 1}


WELL: dict[str, Any] = {"run": "r", "sender": "s", "number": 1, "body": "{}", "seal": "00"}


@pytest.mark.parametrize(
    "text",
    [
        "", "[]", "null", "1e999", "{", "[" * 100_000, "{}", "\x00",
        json.dumps({**WELL, "run": None}),
        json.dumps({**WELL, "number": 1.5}), json.dumps({**WELL, "number": True}),
        json.dumps({**WELL, "seal": []}), json.dumps({**WELL, "sender": "x" * 1000}),
        json.dumps({**WELL, "body": "\ud800"}), json.dumps({**WELL, "seal": "\u00e9"}),
        json.dumps(WELL),
    ],
)  # fmt: skip
def test_nonsense_is_counted_and_nothing_else(text):
    one = door()
    assert one.take(text) is None
    assert one.rejected == {FORGED: 1}
