"""The view of the live graph; swarm-up starts it as `python -m swarm_view.process CONFIG.json`."""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Callable

import rclpy
from rclpy.node import Node

from swarm_common.middleware import ros_env
from swarm_common.middleware.rclpy_compat import join_graph
from swarm_common.model.errors import SwarmError
from swarm_common.process.messages import VIEWER, Refused, ViewerOpened
from swarm_common.process.pipes import EventWriter, MessageReader, child_options, leave
from swarm_view.server.server import Server
from swarm_view.state.live_feed import LiveFeed
from swarm_view.state.operator_link import OperatorLink
from swarm_view.viewer import Hear, Viewer, run_until_signal


def main(arguments: list[str] | None = None) -> int:
    """Serve the view until told to stop; returns the exit code."""
    options = child_options("Viewer of a swarm", arguments)
    logging.basicConfig(level=logging.WARNING)
    events = EventWriter(options.event_fd)
    config = json.loads(options.config.read_text(encoding="utf-8"))
    try:
        server = Server(config["host"], config["port"], config["title"])
    except SwarmError as error:
        events.write(Refused(str(error)))
        sys.stderr.write(f"{error}\n")
        return 2
    events.write(ViewerOpened(server.url()))
    commands = MessageReader(options.control_fd, VIEWER)
    serve_live(server, open_node(), commands.read)
    return 0


def open_node() -> Node:
    """Join the graph."""
    ros_env.set_defaults()
    return join_graph("viewer", "sim")


def serve_live(
    server: Server, node: Node, hear: Hear | None = None, announce: Callable[[], None] | None = None
) -> None:
    """Show the live graph until a signal asks for the end; the node is destroyed then."""
    link = OperatorLink(node)
    run_until_signal(Viewer(server, LiveFeed(node), link, hear=hear), announce)
    link.close()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    leave(main())
