"""Entry point of the command `swarm-view`."""

from __future__ import annotations

import sys

import typer

from swarm_commander.cli.main import prepare_ros, run_app


def main() -> None:
    """Run `swarm-view`."""
    sys.exit(run_app("swarm-view", _load))


def _load() -> typer.Typer:
    prepare_ros()
    from swarm_view.view_command import view_app

    return view_app
