"""Argument tree, errors and exit codes of the `ros2` command."""

from __future__ import annotations

import argparse
import importlib
import os
import signal
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from swarm_common.middleware import ros_env
from swarm_common.middleware.other_ros import set_aside
from swarm_common.model.errors import SwarmError
from swarm_common.process.standard_streams import (
    complain,
    end_of_output,
    finish_output,
    is_of_output,
    open_standard_streams,
)
from swarm_ros2 import launcher

MARKER = b"swarm_ros2"  # in the script that pip writes for our entry point
COMMANDS = {
    "action": "Various action related sub-commands",
    "bag": "Various rosbag related sub-commands",
    "doctor": "Check the machine for common problems (swarm-doctor)",
    "interface": "Show information about ROS interfaces",
    "launch": "Run a launch file",
    "lifecycle": "Various lifecycle related sub-commands",
    "node": "Various node related sub-commands",
    "param": "Various param related sub-commands",
    "run": "Run a package specific executable",
    "service": "Various service related sub-commands",
    "topic": "Various topic related sub-commands",
}
LIKE_PROGRAMS = ("doctor", "launch", "run")  # commands without verbs
WITHOUT_GRAPH = ("bag", "interface")
EPILOG = (
    "This is the small ros2 of the swarm workbench. Where ROS 2 is installed (another ros2 on"
    " PATH), that one runs instead, with all of its commands."
)


def main() -> None:
    """Run the command as this process, and end it."""
    real = find_real_ros2(os.environ)
    if real is not None:
        os.execve(real, [str(real), *sys.argv[1:]], clean_environment(os.environ, Path(sys.prefix)))
    open_standard_streams()
    set_aside("ros2")
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        code = run(sys.argv[1:])
    except SystemExit as end:  # argparse's
        code = end.code if isinstance(end.code, int) else 1
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # while the interpreter ends
    sys.exit(finish_output("ros2", code, failed=1))


def run(arguments: Sequence[str]) -> int:
    """Run one command line, the words after `ros2`; return the exit code."""
    try:
        ros_env.set_defaults()  # before rclpy is imported
        options = _parser(arguments).parse_args(arguments)
        if "run" not in options:
            options.print_help()
            return 0
        options.run(options)
    except SwarmError as error:
        complain(str(error))
        return 1
    except KeyboardInterrupt:
        return int(signal.SIGINT)
    except OSError as error:
        if is_of_output(error):
            return end_of_output("ros2", error, failed=1)
        raise
    return 0


def _parser(arguments: Sequence[str]) -> argparse.ArgumentParser:
    """Build the argument tree; only the module of the command in use is imported."""
    parser = argparse.ArgumentParser(
        prog="ros2", description="ros2 is an extensible command-line tool for ROS 2.", epilog=EPILOG
    )
    parser.set_defaults(print_help=parser.print_help)
    commands = parser.add_subparsers(metavar="command")
    wanted = next((word for word in arguments if not word.startswith("-")), None)
    for name, text in COMMANDS.items():
        is_doctor = name == "doctor"  # whose options are the program's
        shape: dict[str, Any] = {"prefix_chars": "\0", "add_help": False} if is_doctor else {}
        command = commands.add_parser(name, help=text, description=text, **shape)
        if name != wanted:
            continue
        if name in LIKE_PROGRAMS:
            launcher.add_arguments(name, command)
            continue
        command.set_defaults(print_help=command.print_help)
        verbs = command.add_subparsers(metavar="verb")
        importlib.import_module(f"swarm_ros2.{name}").add_verbs(verbs)
        if name not in WITHOUT_GRAPH:
            for verb in verbs.choices.values():
                _add_ros2clis_options(verb)
    return parser


def _add_ros2clis_options(verb: argparse.ArgumentParser) -> None:
    """Add the options that all verbs of ros2cli have; most change nothing here."""
    verb.add_argument(
        "-s", "--use-sim-time", action="store_true", help="Take the time of /clock (delay)"
    )
    vain = "No effect: there is no daemon, and discovery takes as long as it needs"
    verb.add_argument("--spin-time", type=float, metavar="N", help=vain)
    verb.add_argument("--no-daemon", action="store_true", help=vain)
    verb.add_argument("--include-hidden-nodes", action="store_true", help=vain)


def find_real_ros2(environ: Mapping[str, str]) -> Path | None:
    """Return the first `ros2` on PATH that is not this one."""
    for folder in environ.get("PATH", "").split(os.pathsep):
        candidate = Path(folder or ".") / "ros2"
        if os.access(candidate, os.X_OK) and candidate.is_file() and not _is_ours(candidate):
            return candidate
    return None


def clean_environment(environ: Mapping[str, str], prefix: Path) -> dict[str, str]:
    """Return the environment without what the ROS 2 wheels put there at start-up.

    The libraries of this environment must not get in the way of those of the real ROS 2.
    """
    cleaned = dict(environ)
    cleaned.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None)
    folders = cleaned.pop("LD_LIBRARY_PATH", "").split(os.pathsep)
    kept = [folder for folder in folders if folder and not Path(folder).is_relative_to(prefix)]
    if kept:
        cleaned["LD_LIBRARY_PATH"] = os.pathsep.join(kept)
    return cleaned


def _is_ours(script: Path) -> bool:
    try:
        with script.open("rb") as file:
            return MARKER in file.read(4096)
    except OSError:
        return True
