"""Entry point of the command `swarm-bench`."""

from __future__ import annotations

import sys

import typer

from swarm_commander.cli.main import run_app


def main() -> None:
    """Run `swarm-bench`."""
    sys.exit(run_app("swarm-bench", _load))


def _load() -> typer.Typer:
    import swarm_bench.ablation.command  # each adds its command
    import swarm_bench.halls.command
    import swarm_bench.scale.command
    import swarm_bench.storm.command  # noqa: F401
    from swarm_bench.suite.command import bench_app

    return bench_app
