"""Entry point of the command `swarm-map`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from swarm_run.command_line import run_command

if TYPE_CHECKING:
    import typer


def main() -> None:
    """Run `swarm-map`."""
    run_command("swarm-map", _load)


def _load() -> typer.Typer:
    from swarm_map.map_command import map_app

    return map_app
