"""The list of the robots' hosts: who serves whom, who is silent, who is given up."""

import dataclasses

import pytest

from swarm_commander.hosts.host_table import HostReport, HostTable, parse_report
from swarm_common.model.errors import ConfigError
from swarm_common.process import messages as say

ROBOTS = ["Srobot1", "Srobot2", "Srobot3"]
FIRST = HostReport("a", "first (10.0.0.2)", ("Srobot1", "Srobot2"))
SECOND = HostReport("b", "second (10.0.0.3)", ("Srobot3",))


def kinds(events):
    return [type(event) for event in events]


def table_of_first():
    host_table = HostTable(ROBOTS, notice_after=3.0, lost_after=30.0)
    host_table.hear(FIRST, 0.0)
    return host_table


def test_hosts_take_on_robots_until_none_is_left_and_leave():
    host_table = HostTable(ROBOTS)
    assert kinds(host_table.hear(FIRST, 0.0)) == [say.HostJoined]
    assert kinds(host_table.hear(SECOND, 0.0)) == [say.HostJoined]
    assert host_table.answer()["hosts"] == {"a": "serving", "b": "serving"}
    table = table_of_first()
    assert kinds(table.hear(dataclasses.replace(FIRST, is_leaving=True), 1.0)) == [say.HostLeft]
    assert table.look(100.0) == []
    assert table.answer()["hosts"] == {"a": "left"}


def test_a_robot_has_one_host_whose_reports_pass_through_messages():
    other = HostReport("c", "third", ("Srobot2", "Srobot3"))
    table = table_of_first()
    assert kinds(table.hear(other, 1.0)) == [say.HostRejected]
    assert "Srobot2 is on first (10.0.0.2) already" in table.answer()["refused"]["c"]
    assert table.hear(other, 1.5) == []
    assert "c" not in table.answer()["hosts"]
    assert parse_report(dataclasses.asdict(FIRST), "a") == FIRST
    for bad in ({}, {"robots": [], "active": []}, {**dataclasses.asdict(FIRST), "more": 1}):
        with pytest.raises(ConfigError, match="something else than a report"):
            parse_report(bad, "a")
    with pytest.raises(ConfigError, match="b speaks for a"):
        parse_report(dataclasses.asdict(FIRST), "b")


def test_what_happened_to_navigators_and_who_hears_nothing_is_told_once():
    table = table_of_first()
    news = dataclasses.replace(FIRST, active=("Srobot1",), died={"Srobot2": -9})
    events = table.hear(news, 0.5)
    assert events == [say.NavigatorActive("Srobot1"), say.NavigatorDied("Srobot2", -9, FIRST.label)]
    assert table.hear(news, 1.0) == []
    table = table_of_first()
    deaf = dataclasses.replace(FIRST, deaf_for=3.5)
    assert kinds(table.hear(deaf, 1.0)) == [say.HostDeaf]
    assert table.hear(dataclasses.replace(FIRST, deaf_for=4.0), 1.5) == []
    table.hear(FIRST, 2.0)
    assert kinds(table.hear(deaf, 8.0)) == [say.HostDeaf]


def test_a_short_silence_is_noticed_and_over():
    table = table_of_first()
    assert table.look(3.0) == []
    assert table.look(3.5) == [say.HostSilent("a", FIRST.label, FIRST.robots, 3.5)]
    assert table.look(20.0) == []
    assert table.hear(FIRST, 21.0) == [say.HostHeard("a", FIRST.label, FIRST.robots, 21.0)]
    assert table.summary()[0]["silences"] == [21.0]


def test_a_long_silence_is_for_good_and_its_robots_may_go_on_elsewhere():
    table = table_of_first()
    assert kinds(table.look(31.0)) == [say.HostSilent, say.HostLost]
    assert table.hear(FIRST, 32.0) == []  # it is told, and ends
    assert table.answer()["hosts"] == {"a": "lost"}
    assert table.all_have_left
    table.look(31.0)
    again = HostReport("d", "first again", FIRST.robots)
    assert kinds(table.hear(again, 40.0)) == [say.HostJoined]
