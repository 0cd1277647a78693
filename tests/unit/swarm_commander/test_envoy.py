"""A robots' host towards the world's: finding it, being welcome, silence, the end."""

from __future__ import annotations

from typing import Any

import pytest

from swarm_commander.charter import Charter
from swarm_commander.envoy import Envoy, names_of
from swarm_commander.roll import HostReport

FACTS = {"world": "slim_blockage", "seed": 3, "robot": "turtlebot3_waffle", "swarm_size": 2}
CHARTER = Charter("run", "1 (abc)", FACTS, {"Srobot1": {}, "Srobot2": {}}, {})


def envoy(**stated: object) -> Envoy:
    report = HostReport("a", "first", ("Srobot1", "Srobot2"))
    return Envoy(report, "1 (abc)", stated, 0.0, find_limit=60.0, lost_after=30.0)


def roll(**values: Any) -> dict[str, Any]:
    answer = {"run": "run", "hosts": {"a": "serving"}, "refused": {}, "figures": {}, "removed": []}
    return answer | {"is_over": False} | values


def welcome() -> Envoy:
    one = envoy(seed=3, world="slim_blockage")
    assert one.report is None  # nothing to say before it is known that both sides agree
    assert one.take_charter(CHARTER.to_text(), 1.0) == []
    assert one.take_roll(roll(hosts={}), 1.5) == []
    assert one.take_roll(roll(), 2.0) == [{"event": "welcome"}]
    assert one.take_roll(roll(), 2.5) == []
    return one


def only(events: list[dict[str, Any]]) -> dict[str, Any]:
    (event,) = events
    return event


def test_welcome_and_news() -> None:
    one = welcome()
    one.note_active("Srobot1")
    one.note_death("Srobot2", -11)
    one.note_usage(1.5, 70.0)
    report = one.report
    assert report is not None
    assert (report["active"], report["died"], report["cpu"]) == (["Srobot1"], {"Srobot2": -11}, 1.5)
    events = one.take_roll(roll(figures={"sim_time": 4.0}, removed=["Srobot2", "Srobot9"]), 3.0)
    assert events[0] == {"event": "progress", "sim_time": 4.0}
    assert events[1:] == [{"event": "taken_out", "robot": "Srobot2"}]


def test_nobody_answers() -> None:
    one = envoy()
    assert one.look(20.0) == []
    assert only(one.look(20.1))["event"] == "unanswered_yet"
    assert one.look(60.0) == []
    assert only(one.look(60.5))["event"] == "unanswered"
    assert one.is_over
    assert one.look(61.0) == []


@pytest.mark.parametrize(
    ("edition", "stated", "robots", "words"),
    [
        ("1 (abd)", {}, ("Srobot1",), "install the same on both"),
        ("1 (abc)", {"seed": 4}, ("Srobot1",), "--seed is 4 here, but 3 on the world's host"),
        ("1 (abc)", {"swarm_size": 5}, ("Srobot1",), "--swarm-size is 5 here, but 2"),
        ("1 (abc)", {"world": "u_shape"}, ("Srobot1",), "--world is u_shape here"),
        ("1 (abc)", {}, ("Srobot1", "Srobot3"), "--robots asks for Srobot3"),
    ],
)
def test_disagreement_is_one_error(
    edition: str, stated: dict[str, object], robots: tuple[str, ...], words: str
) -> None:
    one = Envoy(HostReport("a", "first", robots), edition, stated, 0.0)
    event = only(one.take_charter(CHARTER.to_text(), 1.0))
    assert event["event"] == "error"
    assert words in event["message"]
    assert one.is_over


def test_something_else_than_a_charter() -> None:
    event = only(envoy().take_charter("[]", 1.0))
    assert "something else than a charter" in event["message"]


def test_refused() -> None:
    one = envoy()
    one.take_charter(CHARTER.to_text(), 1.0)
    event = only(one.take_roll(roll(hosts={}, refused={"a": "Srobot1 is taken"}), 2.0))
    assert event == {"event": "error", "message": "Srobot1 is taken"}


def test_a_silence_and_its_end() -> None:
    one = welcome()
    assert one.look(5.0) == []
    assert only(one.look(6.0))["event"] == "world_silent"
    assert one.look(20.0) == []
    assert only(one.take_roll(roll(), 22.5)) == {"event": "world_heard", "seconds": 20.0}
    assert one.silences == [20.0]


@pytest.mark.parametrize("changes", [{"hosts": {"a": "lost"}}, {"run": "another"}])
def test_given_up_by_the_world(changes: dict[str, Any]) -> None:
    one = welcome()
    assert only(one.take_roll(roll(**changes), 3.0))["event"] == "world_lost"
    assert one.is_over


def test_the_world_is_lost() -> None:
    one = welcome()
    assert [event["event"] for event in one.look(33.0)] == ["world_silent", "world_lost"]


def test_the_end_is_acknowledged() -> None:
    one = welcome()
    event = only(one.take_roll(roll(is_over=True, reason="mission done"), 3.0))
    assert event == {"event": "world_over", "reason": "mission done"}
    assert one.report is not None
    assert one.report["is_leaving"]


def test_names_in_few_words() -> None:
    assert names_of(["Srobot1"]) == "Srobot1"
    assert names_of(["Srobot1", "Srobot2"]) == "Srobot1 and Srobot2"
    assert names_of(["Srobot2", "Srobot3", "Srobot4"]) == "Srobot2 to Srobot4"
    assert names_of(["Srobot2", "Srobot3", "Srobot5"]) == "Srobot2, Srobot3, Srobot5"
