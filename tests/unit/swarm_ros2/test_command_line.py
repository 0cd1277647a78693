"""Words without a verb, and interfaces as text."""

import pytest

from swarm_ros2 import command_line, launcher


def run(capsys, *words):
    assert command_line.run(words) == 0
    return capsys.readouterr().out


def test_without_a_command_or_a_verb_there_is_help_as_from_ros2cli(capsys):
    assert run(capsys).startswith("usage: ros2 [-h] command ...")
    assert run(capsys, "topic").startswith("usage: ros2 topic [-h] verb ...")
    with pytest.raises(SystemExit, match="2"):
        command_line.run(["topics"])


def test_a_range_in_which_no_node_is_found_is_told_in_a_line(capsys, monkeypatch):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    assert command_line.run(["topic", "list"]) == 1
    assert capsys.readouterr().err.startswith("ROS_AUTOMATIC_DISCOVERY_RANGE is 'OFF'")


def test_comments_of_nested_types_are_shown_if_asked_for(capsys):
    name = "geometry_msgs/msg/PoseStamped"
    nested = "\t# This represents a pose"
    everything = run(capsys, "interface", "show", "--all-comments", name)
    some = run(capsys, "interface", "show", name)
    none = run(capsys, "interface", "show", "--no-comments", name)
    assert [text.count("\t#") > 0 for text in (everything, some, none)] == [True, False, False]
    assert ["# A Pose" in text for text in (everything, some, none)] == [True, True, False]
    assert nested not in some
    assert len(everything) > len(some) > len(none)


def test_options_of_the_doctor_are_passed_on():
    """They were refused as unknown."""
    for words in (["--swarm-size", "3"], ["--help"], []):
        assert (
            command_line._parser(["doctor", *words]).parse_args(["doctor", *words]).arguments
            == words
        )


def test_the_arguments_of_the_launch_file_are_shown(monkeypatch):
    started: list[tuple[str, list[str]]] = []
    monkeypatch.setattr(launcher, "start", lambda *call: started.append(call))
    launch = ("launch", "swarm_commander", "swarm.launch.py")
    for words in (["--show-args"], ["-s"], ["swarm_size:=3", "viewer:=true"]):
        assert command_line.run([*launch, *words]) == 0
    helped = ("swarm_up", ["--help"])
    assert started == [helped, helped, ("swarm_up", ["--swarm-size", "3", "--viewer"])]
