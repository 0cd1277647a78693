"""Entry point of the command `swarm-bench`."""

from __future__ import annotations

import sys

import typer

from swarm_commander.cli.main import run_app


def main() -> None:
    """Run `swarm-bench`."""
    sys.exit(run_app("swarm-bench", _load))


def _load() -> typer.Typer:
    from swarm_bench import (  # noqa: F401  # add theirs
        ablate_command,
        halls_command,
        scale_command,
        storm_command,
    )
    from swarm_bench.bench_command import bench_app

    return bench_app
