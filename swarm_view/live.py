"""The view of the live graph: a node, and a server that shows the messages it receives."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import NoReturn

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from swarm_common.middleware import ros_env
from swarm_view.server.server import Server
from swarm_view.state.live_feed import LiveFeed
from swarm_view.state.operator_link import OperatorLink
from swarm_view.viewer import Hear, Viewer, run_until_signal


def open_node() -> Node:
    """Join the graph."""
    ros_env.set_defaults()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    return Node("viewer", namespace="sim", enable_rosout=False, start_parameter_services=False)


def serve_live(
    server: Server,
    node: Node,
    hear: Hear | None = None,
    announce: Callable[[], None] | None = None,
) -> None:
    """Show the live graph until a signal asks for the end; the node is destroyed then."""
    link = OperatorLink(node)
    run_until_signal(Viewer(server, LiveFeed(node), link, hear=hear), announce)
    link.close()
    node.destroy_node()
    rclpy.try_shutdown()


def leave(code: int) -> NoReturn:
    """End at once: the interpreter's own end would wait for threads of viser and DDS."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
