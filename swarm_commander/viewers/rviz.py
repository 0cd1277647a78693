"""RViz for a run: its configuration files, and the commands that open them."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any

import yaml

from swarm_commander.viewers.rviz_config import merged_config, robot_config, swarm_config
from swarm_common.process import start
from swarm_run.spec import MERGED, SWARM

DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # the dumper in C is ten times as fast
HOW_TO_GET = (
    "--rviz: rviz2 is not installed; on Ubuntu 24.04 with ROS 2: apt install ros-jazzy-rviz2."
    " Without it, swarm-up --viewer shows the same in a browser."
)


def write_rviz(
    folder: Path, robots: Sequence[str], newcomers: Collection[str] | None = None
) -> None:
    """Write `NAME.rviz` for each robot, or newcomers only, `swarm.rviz` and `merged.rviz`."""
    folder.mkdir(parents=True, exist_ok=True)
    for index, robot in enumerate(robots):
        if newcomers is None or robot in newcomers:
            _write(folder / f"{robot}.rviz", robot_config(robot, index))
    _write(folder / f"{SWARM}.rviz", swarm_config(robots))
    _write(folder / f"{MERGED}.rviz", merged_config(robots))


def _write(path: Path, config: dict[str, Any]) -> None:
    path.write_text(yaml.dump(config, Dumper=DUMPER, sort_keys=False), encoding="utf-8")


def find_rviz(tell: Callable[[str], None]) -> str | None:
    """Return the path of rviz2; if it is not installed, tell how to get it and return None."""
    program = shutil.which("rviz2")
    if program is None:
        tell(HOW_TO_GET)
    return program


def rviz_command(program: str, config: Path, name: str) -> list[str]:
    """Return the command that opens a window for a robot or the swarm."""
    return [program, "-d", str(config), "--ros-args", *remappings(name)]


def remappings(name: str) -> tuple[str, ...]:
    """Return the ROS arguments of a window: every robot has a tree of frames of its own."""
    match name:
        case "swarm":
            pairs = {"/tf": "/sim/tf"}
        case "merged":
            pairs = {}  # the relay's
        case _:
            pairs = {"/tf": f"/{name}/tf", "/tf_static": f"/{name}/tf_static"}
    words = [word for old, new in pairs.items() for word in ("-r", f"{old}:={new}")]
    return (*words, "-r", f"__node:=rviz_{name}", "-p", "use_sim_time:=true")


def relay_command() -> list[str]:
    """Return the command that puts all robots' frames into one tree, for the merged window."""
    return list(start.command("swarm_commander.viewers.frame_relay"))
