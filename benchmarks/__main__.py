"""Entry point of `python -m benchmarks`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from swarm_commander.cli.main import run_command

if TYPE_CHECKING:
    import typer


def _load() -> typer.Typer:
    from benchmarks.app import load

    return load()


if __name__ == "__main__":
    run_command("python -m benchmarks", _load)
