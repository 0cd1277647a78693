"""Entry point of the command `swarm-bench`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from swarm_run.command_line import run_command

if TYPE_CHECKING:
    import typer


def main() -> None:
    """Run `swarm-bench`."""
    run_command("swarm-bench", _load)


def _load() -> typer.Typer:
    import swarm_bench.capacity.command  # adds its command
    import swarm_bench.halls.command  # likewise
    import swarm_bench.lanes.command  # likewise
    import swarm_bench.study.command  # noqa: F401  # likewise
    from swarm_bench.suite.command import bench_app

    return bench_app
