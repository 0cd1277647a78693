"""RViz for a run: the commands that open its windows.

`python -m swarm_commander.viewers.rviz CONFIG.json` becomes a program with a window: those of
others do not know the flags that swarm-up gives its processes; here they are dropped.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

from swarm_common.process import start

HOW_TO_GET = (
    "--rviz: rviz2 is not installed; on Ubuntu 24.04 with ROS 2: apt install ros-jazzy-rviz2."
    " Without it, swarm-up --viewer shows the same in a browser."
)


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


if __name__ == "__main__":
    command = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))["command"]
    os.execv(command[0], command)
