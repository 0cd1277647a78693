"""Entry point of the command `swarm-bench`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from swarm_run.command_line import run_command

if TYPE_CHECKING:
    import typer

HOMES = {  # command -> package whose module `command` adds it
    "traffic": "suite", "suite": "suite", "report-traffic": "suite",
    "sweep": "capacity", "halls": "halls", "lanes": "lanes", "study": "study",
}  # fmt: skip


def main() -> None:
    """Run `swarm-bench`."""
    run_command("swarm-bench", lambda: _load(sys.argv[1:]))


def _load(words: Sequence[str] = ()) -> typer.Typer:
    """Return the app with the command that `words` begin with, or else with all of them."""
    packages = [HOMES[word] for word in words[:1] if word in HOMES] or HOMES.values()
    for package in packages:
        import_module(f"swarm_bench.{package}.command")  # slow
    from swarm_bench.suite.command import bench_app

    return bench_app
