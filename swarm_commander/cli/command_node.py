"""The node of a command that works with a running swarm."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from swarm_run.domain import check_swarm, domain_id


@contextmanager
def command_node(name: str) -> Iterator[Node]:
    """Join the graph of a running swarm.

    rclpy's own handlers of signals would take the graph down at Ctrl-C, before the command has
    cancelled its goals and given its robots back.

    Raises:
        NoSwarmError: If there is no swarm.
    """
    check_swarm(domain_id())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node(name, enable_rosout=False, start_parameter_services=False)
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
