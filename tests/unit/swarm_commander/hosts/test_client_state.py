"""A robots' host towards the world's: finding it, being welcome, silence, the end."""

import dataclasses
from typing import Any

import msgspec
import pytest

from swarm_commander.hosts.client_state import ClientState
from swarm_commander.hosts.host_table import HostReport
from swarm_commander.hosts.run_description import RunDescription
from swarm_common.process import messages as say

FACTS = {"world": "slim_blockage", "seed": 3, "robot": "turtlebot3_waffle", "swarm_size": 2}
DESCRIPTION = RunDescription("run", "1 (abc)", FACTS, {"Srobot1": {}, "Srobot2": {}}, {})


def client(**stated):
    report = HostReport("a", "first", ())
    return ClientState(report, (1, 2), "1 (abc)", stated, 0.0, find_limit=60.0, lost_after=30.0)


def table(**values):
    answer: dict[str, Any] = {
        "hosts": {"a": "serving"},
        "refused": {},
        "figures": {},
        "removed": [],
    }
    return answer | {"is_over": False} | values


def welcome():
    one = client(seed=3, world="slim_blockage")
    assert one.report(0.5) is None  # nothing to say before it is known that both sides agree
    assert one.receive_description(DESCRIPTION.to_text(), 1.0) == []
    assert one.receive_table("run", table(hosts={}), 1.5) == []
    assert one.receive_table("run", table(), 2.0) == [say.WorldFound()]
    assert one.receive_table("run", table(), 2.5) == []
    return one


def only(events):
    (event,) = events
    return event


def test_welcome_and_news():
    one = welcome()
    one.record_active("Srobot1")
    one.record_death("Srobot2", -11)
    one.record_usage(1.5, 70.0)
    report = one.report(2.5)
    assert (report["active"], report["died"], report["cpu"]) == (["Srobot1"], {"Srobot2": -11}, 1.5)
    counts = say.CollisionCounts(0, 1)
    figures = msgspec.to_builtins(say.Figures(4.0, 2.0, counts))
    events = one.receive_table("run", table(figures=figures, removed=["Srobot2", "Srobot9"]), 3.0)
    assert events == [say.WorldProgress(4.0, 2.0, counts), say.RobotTakenOut("Srobot2")]


def test_nobody_answers_or_is_not_heard():
    one = client()
    assert one.look(20.0) == []
    assert only(one.look(20.1)) == say.WorldUnansweredYet(20.1)
    assert one.look(60.0) == []
    assert only(one.look(60.5)) == say.WorldUnanswered(60.5)
    assert one.is_over
    assert one.look(61.0) == []
    one = welcome()
    silent = {"a": "silent"}
    assert one.receive_table("run", table(hosts=silent), 5.0) == [say.WorldUnhearing()]
    assert one.receive_table("run", table(hosts=silent), 5.5) == []
    assert one.receive_table("run", table(), 6.0) == []
    report = one.report(8.5)
    assert report["deaf_for"] == 2.5


@pytest.mark.parametrize(
    ("edition", "stated", "robots", "words"),
    [
        ("1 (abd)", {}, (1,), "install the same on both"),
        ("1 (abc)", {"seed": 4}, (1,), "--seed is 4 here, but 3 on the world's host"),
        ("1 (abc)", {"swarm_size": 5}, (1,), "--swarm-size is 5 here, but 2"),
        ("1 (abc)", {"world": "u_shape"}, (1,), "--world is u_shape here"),
        ("1 (abc)", {}, (1, 3), "--robots asks for Srobot3"),
    ],
)
def test_disagreement_is_one_error(edition, stated, robots, words):
    one = ClientState(HostReport("a", "first", ()), robots, edition, stated, 0.0)
    event = only(one.receive_description(DESCRIPTION.to_text(), 1.0))
    assert isinstance(event, say.Refused)
    assert words in event.message
    assert one.is_over


def test_what_is_no_run_description_or_a_refusal_ends_it():
    event = only(client().receive_description("[]", 1.0))
    assert isinstance(event, say.Refused)
    assert "something else than a run description" in event.message
    one = client()
    one.receive_description(DESCRIPTION.to_text(), 1.0)
    event = only(one.receive_table("run", table(hosts={}, refused={"a": "Srobot1 is taken"}), 2.0))
    assert event == say.Refused("Srobot1 is taken")


def test_a_silence_and_its_end_or_the_loss_of_the_world():
    one = welcome()
    assert one.look(5.0) == []
    assert only(one.look(6.0)) == say.WorldSilent()
    assert one.look(20.0) == []
    assert only(one.receive_table("run", table(), 22.5)) == say.WorldHeard(20.0)
    assert one.silences == [20.0]
    one = welcome()
    assert [type(event) for event in one.look(33.0)] == [say.WorldSilent, say.WorldLost]


@pytest.mark.parametrize(("run", "standing"), [("run", "lost"), ("another", "serving")])
def test_given_up_by_the_world(run, standing):
    one = welcome()
    event = only(one.receive_table(run, table(hosts={"a": standing}), 3.0))
    assert isinstance(event, say.WorldLost)
    assert one.is_over


def test_the_worlds_host_names_the_robots_and_its_end_is_acknowledged():
    robots = {"ann": {}, "agv2": {}}
    description = RunDescription("run", "1 (abc)", FACTS, robots, {}, names="ann,agv{}")
    one = client()
    assert one.receive_description(description.to_text(), 1.0) == []
    report = one.report(2.0)
    assert report["robots"] == ("ann", "agv2")
    one = welcome()
    event = only(one.receive_table("run", table(is_over=True, reason="mission done"), 3.0))
    assert event == say.WorldOver("mission done")
    report = one.report(3.0)
    assert report["is_leaving"]


def test_a_host_that_still_waits_joins_the_run_that_has_begun_since():
    """The world crashed and was started again before it had answered."""
    one = client()
    one.receive_description(DESCRIPTION.to_text(), 1.0)
    assert one.receive_table("later", table(hosts={}), 2.0) == []
    one.receive_description(dataclasses.replace(DESCRIPTION, run="later").to_text(), 2.5)
    assert one.receive_table("later", table(), 3.0) == [say.WorldFound()]


def test_another_secret_is_an_error_where_no_other_world_is_heard():
    one = client()
    assert one.record_forgery(1.0) == []
    assert one.record_forgery(6.0) == []
    assert only(one.record_forgery(6.1)) == say.WorldHasOtherSecret()
    one = welcome()
    one.receive_table("run", table(), 3.0)
    assert one.record_forgery(6.0) == []
    assert isinstance(only(one.record_forgery(11.5)), say.WorldLost)
