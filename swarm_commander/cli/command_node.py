"""The node of a command that works with a running swarm."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import rclpy
from rclpy.node import Node

from swarm_common.middleware.rclpy_compat import join_graph
from swarm_run.domain import check_swarm, domain_id


@contextmanager
def command_node(name: str) -> Iterator[Node]:
    """Join the graph of a running swarm; at its end the command gives its robots back.

    Raises:
        NoSwarmError: If there is no swarm.
    """
    check_swarm(domain_id())
    node = join_graph(name)
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
