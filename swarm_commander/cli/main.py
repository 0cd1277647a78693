"""Entry points of the commands `swarm-up`, `swarm-commander` and `swarm-report`."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

from swarm_run.command_line import prepare_ros, run_command

# All other modules are imported later, when Ctrl-C no longer ends in a traceback.
if TYPE_CHECKING:
    from collections.abc import Sequence

    import typer


def swarm_up() -> None:
    """Run `swarm-up`."""
    sys.argv[1:] = with_value(sys.argv[1:], "--rviz", "swarm")
    _run("swarm-up")


def commander() -> None:
    """Run `swarm-commander`."""
    _run("swarm-commander")


def teleop() -> None:
    """Run `swarm-teleop`."""
    _run("swarm-teleop")


def report() -> None:
    """Run `swarm-report`."""
    _run("swarm-report")


def doctor() -> None:
    """Run `swarm-doctor`."""
    _run("swarm-doctor")


def setup() -> None:
    """Run `swarm-setup`."""
    _run("swarm-setup")


def _run(name: str) -> None:
    run_command(name, lambda: load_app(name))


def load_app(name: str) -> typer.Typer:
    """Import the command line of a command, and before it what it needs."""
    from swarm_common.model.robot_names import FLEET_COMMANDS

    if name in ("swarm-commander", "swarm-teleop"):
        prepare_ros()
    match name:
        case "swarm-up":
            from swarm_commander.cli.up_command import up_app as app
        case "swarm-commander" if _first_word() in FLEET_COMMANDS:
            from swarm_commander.cli.fleet_command import fleet_app as app
        case "swarm-commander":
            from swarm_commander.cli.commander_command import commander_app as app
        case "swarm-teleop":
            from swarm_commander.cli.teleop_command import teleop_app as app
        case "swarm-report":
            from swarm_report.report_command import report_app as app
        case "swarm-doctor":
            from swarm_commander.cli.doctor import doctor_app as app
        case _:
            from swarm_commander.cli.doctor import setup_app as app
    return app


def _first_word() -> str:
    """Return the first argument, also while a shell asks how to complete it; empty without one."""
    typed = os.environ.get("_TYPER_COMPLETE_ARGS") or os.environ.get("COMP_WORDS")
    words = sys.argv if typed is None else typed.split()
    return words[1] if len(words) > 1 else ""


def with_value(words: Sequence[str], flag: str, default: str) -> list[str]:
    """Return a command line in which every flag with an optional value has one."""
    result: list[str] = []
    for number, word in enumerate(words, 1):
        result.append(word)
        if word == flag and (number == len(words) or words[number].startswith("-")):
            result.append(default)
    return result
