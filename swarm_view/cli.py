"""Entry point of the command `swarm-view`."""

from __future__ import annotations

import sys

import typer

from swarm_commander.cli.main import run_app
from swarm_common.middleware import ros_env
from swarm_setup.build import ensure_interfaces


def main() -> None:
    """Run `swarm-view`."""
    sys.exit(run_app("swarm-view", _load))


def _load() -> typer.Typer:
    ros_env.set_defaults()  # before rclpy is imported
    ensure_interfaces()  # before our messages are imported
    from swarm_view.view_command import view_app

    return view_app
