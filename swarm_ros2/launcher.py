"""`ros2 run`, `launch` and `doctor`: they hand over to the program that is meant."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from swarm_common.model.errors import SwarmError

MAIN = "swarm_commander.cli.main"
# Executables of ours, by package.
PROGRAMS = {
    "swarm_commander": {
        "swarm_up": f"{MAIN}:swarm_up",
        "swarm_commander": f"{MAIN}:commander",
        "swarm_teleop": f"{MAIN}:teleop",
        "swarm_report": f"{MAIN}:report",
        "swarm_doctor": f"{MAIN}:doctor",
    },
    "swarm_bench": {"swarm_bench": "swarm_bench.cli:main"},
    "swarm_map": {"swarm_map": "swarm_map.cli:main"},
    "swarm_view": {"swarm_view": "swarm_view.cli:main", "swarm_replay": "swarm_view.cli:replay"},
    "swarm_setup": {"swarm_setup": f"{MAIN}:setup"},
}
LAUNCH_FILE = "swarm.launch.py"
SHOW = frozenset({"-s", "--show-args", "--show-arguments"})  # of ros2 launch
CALL = "import sys; from {module} import {name}; sys.argv[0] = {label!r}; sys.exit({name}())"


def add_arguments(command: str, parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `run`, `launch` or `doctor`."""
    if command == "doctor":
        parser.add_argument("arguments", nargs=argparse.REMAINDER, help="Of swarm-doctor")
        parser.set_defaults(run=lambda options: start("swarm_doctor", options.arguments))
        return
    parser.add_argument("package_name", help="Name of the ROS package")
    what = "executable" if command == "run" else "launch_file"
    parser.add_argument(f"{what}_name", help=f"Name of the {what.replace('_', ' ')}")
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="Passed on")
    parser.set_defaults(run=_run if command == "run" else _launch)


def start(program: str, arguments: Sequence[str]) -> NoReturn:
    """Become one of our programs; it has no entry point of its own in a checkout."""
    target = next(own[program] for own in PROGRAMS.values() if program in own)
    module, _, name = target.partition(":")
    call = CALL.format(module=module, name=name, label=program.replace("_", "-"))
    os.execv(sys.executable, [sys.executable, "-P", "-c", call, *arguments])


def swarm_up_arguments(words: Sequence[str]) -> list[str]:
    """Return the options of swarm-up for launch arguments like `swarm_size:=20`."""
    options: list[str] = []
    for word in words:
        name, sign, value = word.partition(":=")
        if not sign or not name:
            raise SwarmError(
                f"malformed launch argument '{word}', expected format '<name>:=<value>'"
            )
        flag, lower = name.replace("_", "-"), value.lower()
        if lower in ("true", "false"):
            options.append(f"--{flag}" if lower == "true" else f"--no-{flag}")
        else:
            options += [f"--{flag}", value]
    return options


def _run(options: argparse.Namespace) -> None:
    package, name = options.package_name, options.executable_name
    if name in PROGRAMS.get(package, {}):
        start(name, options.arguments)
    folders = (*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix)
    prefixes = [Path(folder) for folder in folders if folder]
    for prefix in prefixes:
        path = prefix / "lib" / package / name
        if path.is_file() and os.access(path, os.X_OK):
            os.execv(path, [str(path), *options.arguments])
    known = package in PROGRAMS or any((p / "share" / package).is_dir() for p in prefixes)
    raise SwarmError("No executable found" if known else f"Package '{package}' not found")


def _launch(options: argparse.Namespace) -> None:
    if (options.package_name, options.launch_file_name) != ("swarm_commander", LAUNCH_FILE):
        raise SwarmError(
            f"this ros2 launches swarm_commander {LAUNCH_FILE} only; for other launch files install"
            " ROS 2's own launch"
        )
    words = options.arguments
    start("swarm_up", ["--help"] if SHOW.intersection(words) else swarm_up_arguments(words))
