"""The launch file, with stand-ins for ROS 2's `launch`, which PyPI does not have."""

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from swarm_common.model.errors import ConfigError, UnknownNameError

FILE = Path(__file__).parents[2] / "colcon" / "swarm_commander" / "launch" / "swarm.launch.py"
NAMES = {
    "launch": ("LaunchContext", "LaunchDescription"),
    "launch.actions": (
        "DeclareLaunchArgument", "EmitEvent", "ExecuteProcess", "LogInfo", "OpaqueFunction",
        "RegisterEventHandler",
    ),
    "launch.event_handlers": ("OnProcessExit",),
    "launch.events": ("Shutdown",),
}  # fmt: skip


@pytest.fixture
def launch_file(monkeypatch):
    for module, names in NAMES.items():
        made = ModuleType(module)
        for name in names:
            setattr(made, name, lambda *items, kind=name, **told: SimpleNamespace(
                kind=kind, items=items, **told))  # fmt: skip
        monkeypatch.setitem(sys.modules, module, made)
    monkeypatch.setattr(sys, "argv", ["ros2", "launch", "swarm_commander", "swarm.launch.py"])
    return runpy.run_path(str(FILE))


def context(*words, **more):
    given = dict(word.split(":=") for word in words)
    return SimpleNamespace(argv=list(words), launch_configurations=given | more)


def test_arguments_become_options_and_unknown_ones_are_refused(launch_file):
    words = ("swarm_size:=2", "headless:=true", "record:=false", "viewer:=False", "mission:=")
    *_, swarm = launch_file["start"](context(*words))
    assert swarm.cmd[3:] == ["--swarm-size", "2", "--headless", "--no-viewer"]
    with pytest.raises(UnknownNameError, match="'swarm_sise'; did you mean 'swarm_size'"):
        launch_file["start"](context("swarm_sise:=2"))
    with pytest.raises(ConfigError, match="headless is 'maybe'"):
        launch_file["start"](context("headless:=maybe"))


def test_included_it_names_misspelt_ones_among_those_of_others(launch_file, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["ros2", "launch", "mine", "mine.launch.py"])
    note, *_ = launch_file["start"](context("theirs:=1", swarm_sise="2"))
    assert (note.kind, "did you mean 'swarm_size'" in note.msg) == ("LogInfo", True)


def test_the_launch_fails_with_swarm_up(launch_file):
    with pytest.raises(RuntimeError, match="code 2"):
        launch_file["end"](SimpleNamespace(returncode=2), context())
    (ended,) = launch_file["end"](SimpleNamespace(returncode=0), context())
    assert ended.kind == "EmitEvent"
