"""The command `swarm-setup`: builds what an environment needs once."""

from __future__ import annotations

import typer

from swarm_common.model.errors import SwarmError
from swarm_setup.build import ensure_interfaces
from swarm_setup.compiled import ensure_compiled

setup_app = typer.Typer(rich_markup_mode="rich")


@setup_app.command(epilog="Example: swarm-setup")
def setup() -> None:
    """Install the ROS 2 interface packages that this environment lacks; compile the navigators.

    The other commands install the packages, too. Navigators whose sources have changed run as
    Python, slower and with the same results.
    """
    names = ensure_interfaces()
    done = f"ROS 2 interfaces installed: {', '.join(names)}"
    typer.echo(done if names else "ROS 2 interfaces are up to date", err=True)
    try:
        is_new = ensure_compiled()
    except SwarmError as error:
        typer.echo(f"warning: navigators run as Python, not compiled: {error}", err=True)
        return
    typer.echo("navigators compiled" if is_new else "compiled navigators are up to date", err=True)
