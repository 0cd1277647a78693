"""Entry point of the command `swarm-bench`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from swarm_run.command_line import run_command

if TYPE_CHECKING:
    import typer

OWN = ("traffic", "suite", "report-traffic")  # commands of the suite
OTHERS = {"sweep": "capacity", "halls": "halls", "lanes": "lanes", "study": "study"}


def main() -> None:
    """Run `swarm-bench`."""
    run_command("swarm-bench", lambda: _load(sys.argv[1:]))


def _load(words: Sequence[str] = ()) -> typer.Typer:
    """Return the app with the command that `words` begin with, or else with all of them."""
    from swarm_bench.suite.command import bench_app

    asked = words[0] if words else ""
    for name, package in OTHERS.items():
        if asked not in OWN and (name == asked or asked not in OTHERS):
            import_module(f"swarm_bench.{package}.command")  # adds its command; slow to import
    return bench_app
