"""`ros2 node`: list, info."""

from __future__ import annotations

import argparse
from collections import Counter
from typing import Any

from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_server_names_and_types_by_node,
)
from rclpy.node import Node, NodeNameNonExistentError

from swarm_common.model.errors import SwarmError
from swarm_ros2 import graph
from swarm_ros2.verbs import add_flag, add_verb


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 node`."""
    name = "Node name to request information"
    verb = add_verb(verbs, "info", "Output information about a node", _info, node_name=name)
    add_flag(verb, "--include-hidden", help="Display hidden topics, services, and actions as well")
    verb = add_verb(verbs, "list", "Output a list of available nodes", _list)
    add_flag(verb, "-a", "--all", help="Display all nodes even hidden ones")
    add_flag(verb, "-c", "--count-nodes", help="Only display the number of nodes discovered")


def _list(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        graph.settle(node)
        names = graph.node_names(node, hidden=options.all)
    doubles = [name for name, count in Counter(names).items() if count > 1]
    if doubles:
        print(
            f"WARNING: Be aware that there are nodes in the graph that share an exact name:"
            f" {', '.join(doubles)}"
        )
    print(len(names) if options.count_nodes else "\n".join(names))


def _info(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        try:
            full = graph.require_node(node, options.node_name)
            sections = graph.settled(node, lambda: _sections(node, full))
        except (SwarmError, NodeNameNonExistentError):
            raise SwarmError(f"Unable to find node '{options.node_name}'") from None
    print(full)
    for title, rows in sections.items():
        print(f"  {title}:")
        for row, types in sorted(rows):
            if options.include_hidden or not graph.is_hidden(row):
                print(f"    {row}: {', '.join(types)}")
        if title.startswith(("Service Clients", "Action")):
            print()


def _sections(node: Node, full: str) -> dict[str, graph.NamesAndTypes]:
    """Return what a node offers and uses, under ros2cli's titles."""
    namespace, _, name = full.rpartition("/")
    who = (name, namespace or "/")
    return {
        "Subscribers": node.get_subscriber_names_and_types_by_node(*who),
        "Publishers": node.get_publisher_names_and_types_by_node(*who),
        "Service Servers": node.get_service_names_and_types_by_node(*who),
        "Service Clients": node.get_client_names_and_types_by_node(*who),
        "Action Servers": get_action_server_names_and_types_by_node(node, *who),
        "Action Clients": get_action_client_names_and_types_by_node(node, *who),
    }
