"""Entry point of the command `swarm-view`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from swarm_commander.cli.main import prepare_ros, run_command

if TYPE_CHECKING:
    import typer


def main() -> None:
    """Run `swarm-view`."""
    run_command("swarm-view", _load)


def _load() -> typer.Typer:
    prepare_ros()
    from swarm_view.view_command import view_app

    return view_app
