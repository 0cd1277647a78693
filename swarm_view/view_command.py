"""The command `swarm-view`: a 3D view of a running swarm in the browser."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import rclpy
import typer

from swarm_common.middleware.addresses import check_address
from swarm_common.process.pipes import leave
from swarm_common.process.start import has_display, open_page
from swarm_run.domain import check_swarm, domain_id, patience_for
from swarm_run.robots.discovery import find_robots
from swarm_run.spec import LOOPBACK, VIEWER_PORT
from swarm_view.process import open_node, serve_live
from swarm_view.server.server import Server, title_of
from swarm_view.state.topics import robots_in
from swarm_view.viewer import Viewer, run_until_signal

if TYPE_CHECKING:
    from swarm_recording.bag_feed import BagFeed  # mcap is slow to import

view_app = typer.Typer(rich_markup_mode="rich")


@view_app.command(epilog="Example: swarm-view --port 8081 --open")
def view(
    port: Annotated[
        int, typer.Option(help="TCP port to listen on; 0 for a free one.")
    ] = VIEWER_PORT,
    host: Annotated[
        str,
        typer.Option(help="Address to listen on; others than 127.0.0.1 open it to the network."),
    ] = LOOPBACK,
    open_: Annotated[
        bool | None,
        typer.Option(
            "--open/--no-open",
            show_default="where there is a display",
            help="Open it in a browser.",
        ),
    ] = None,
) -> None:
    """Show a running swarm in the browser, until Ctrl-C."""
    check_address(host, port)
    check_swarm(domain_id())
    node = open_node()
    try:
        robots = find_robots(node, [], patience_for(domain_id()))
        server = Server(host, port)
        serve_live(server, node, announce=partial(_announce, server, robots, open_))
    finally:
        rclpy.try_shutdown()
    leave(0)


def show_recording(feed: BagFeed, port: int, path: Path, *, opens: bool | None = None) -> None:
    """Show a recording in the browser, until a signal asks for the end.

    Args:
        path: Path of the recording, or of its run.
        opens: Whether to open a browser; None: where there is a display.
    """
    check_address(LOOPBACK, port)
    server = Server(LOOPBACK, port, title_of(feed.bag.about.get("world", ""), path))
    announce = partial(_announce, server, robots_in(feed.topics()), opens)
    run_until_signal(Viewer(server, feed, None, feed), announce)


def _announce(server: Server, robots: Sequence[str], opens: bool | None) -> None:
    one = f"one robot: {server.url(robots[0])}\n" if robots else ""
    typer.echo(f"viewer: {server.url()}\n{one}press Ctrl-C to end")
    if has_display() if opens is None else opens:
        open_page(server.url())
