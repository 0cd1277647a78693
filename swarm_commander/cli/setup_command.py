"""The command `swarm-setup`: installs the ROS 2 interface packages that are missing."""

from __future__ import annotations

import typer

from swarm_setup.build import ensure_interfaces

setup_app = typer.Typer(rich_markup_mode="rich")


@setup_app.command(epilog="Example: swarm-setup")
def setup() -> None:
    """Build and install the ROS 2 interface packages that this environment lacks.

    The other commands do the same when they start; this does nothing else.
    """
    names = ensure_interfaces()
    done = f"ROS 2 interfaces installed: {', '.join(names)}"
    typer.echo(done if names else "ROS 2 interfaces are up to date", err=True)
