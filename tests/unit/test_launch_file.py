"""The launch file, over stand-ins for what it uses of ROS 2's package launch."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

FILE = Path(__file__).parents[2] / "colcon" / "swarm_commander" / "launch" / "swarm.launch.py"


class Made(SimpleNamespace):
    """What a class of launch was called with."""

    def __init__(self, *arguments: Any, **keywords: Any) -> None:
        super().__init__(arguments=arguments, **keywords)


@pytest.fixture
def launch_file(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Return the names that the launch file defines."""
    parts = {
        "launch": ("LaunchContext", "LaunchDescription"),
        "launch.actions": (
            "DeclareLaunchArgument", "EmitEvent", "ExecuteProcess", "LogInfo", "OpaqueFunction",
            "RegisterEventHandler",
        ),
        "launch.event_handlers": ("OnProcessExit",),
        "launch.events": ("Shutdown",),
        "launch.events.process": ("ProcessExited",),
    }  # fmt: skip
    for name, classes in parts.items():
        module = ModuleType(name)
        for item in classes:
            setattr(module, item, type(item, (Made,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    return runpy.run_path(str(FILE))


def given(**values: str) -> Any:
    return SimpleNamespace(launch_configurations=values, is_shutdown=False)


def test_every_option_of_swarm_up_is_a_declared_argument(launch_file: dict[str, Any]) -> None:
    (actions,) = launch_file["generate_launch_description"]().arguments
    names = {item.arguments[0] for item in actions if type(item).__name__.startswith("Declare")}
    assert {"swarm_size", "world", "mission", "headless", "seed", "params"} <= names


def test_what_is_given_reaches_swarm_up(launch_file: dict[str, Any]) -> None:
    *_, swarm = launch_file["start"](given(swarm_size="2", viewer="false", world=""))
    assert swarm.cmd[-3:] == ["--swarm-size", "2", "--no-viewer"]


def test_a_misspelt_argument_is_refused_and_a_foreign_one_is_named(
    launch_file: dict[str, Any],
) -> None:
    with pytest.raises(RuntimeError, match="'swarm_sise'; did you mean 'swarm_size'"):
        launch_file["start"](given(swarm_sise="2"))
    _, note, _ = launch_file["start"](given(rviz_background="grey"))
    assert "'rviz_background'" in note.msg


@pytest.mark.parametrize("code", [1, 2, 3])
def test_the_launch_fails_when_swarm_up_does(launch_file: dict[str, Any], code: int) -> None:
    with pytest.raises(RuntimeError, match=f"exit code {code}"):
        launch_file["end"](SimpleNamespace(returncode=code), given())
    assert launch_file["end"](SimpleNamespace(returncode=0), given())
