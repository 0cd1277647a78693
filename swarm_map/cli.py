"""Entry point of the command `swarm-map`."""

from __future__ import annotations

import sys

import typer

from swarm_commander.cli.main import run_app


def main() -> None:
    """Run `swarm-map`."""
    sys.exit(run_app("swarm-map", _load))


def _load() -> typer.Typer:
    from swarm_map.map_command import map_app

    return map_app
