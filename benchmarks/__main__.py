"""Entry point of `python -m benchmarks`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from swarm_run.command_line import run_command

if TYPE_CHECKING:
    import typer


def load() -> typer.Typer:
    """Return the command with all of its parts."""
    import benchmarks.decisions  # each adds its command
    import benchmarks.peers.command
    import benchmarks.results_page
    import benchmarks.scale.command
    import benchmarks.storm.command  # noqa: F401
    from benchmarks.app import benchmarks_app

    return benchmarks_app


if __name__ == "__main__":
    run_command("python -m benchmarks", load)
