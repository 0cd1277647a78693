"""Entry points of the commands `swarm-view` and `swarm-replay`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from swarm_run.command_line import prepare_ros, run_command

if TYPE_CHECKING:
    import typer


def main() -> None:
    """Run `swarm-view`."""
    run_command("swarm-view", load_view)


def replay() -> None:
    """Run `swarm-replay`."""
    run_command("swarm-replay", load_replay)


def load_view() -> typer.Typer:
    """Return the command line of `swarm-view`."""
    prepare_ros()
    from swarm_view.view_command import view_app

    return view_app


def load_replay() -> typer.Typer:
    """Return the command line of `swarm-replay`."""
    from swarm_view.replay_command import replay_app

    return replay_app
