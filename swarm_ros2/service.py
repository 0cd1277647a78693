"""`ros2 service`: list, type, find, call, info."""

from __future__ import annotations

import argparse
import time
from typing import Any

from rclpy.node import Node

from swarm_common.model.errors import SwarmError
from swarm_ros2 import graph, text
from swarm_ros2.verbs import add_flag, add_list_options, add_verb


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 service`."""
    verb = add_verb(
        verbs,
        "call",
        "Call a service",
        _call,
        service_name="Name of the ROS service to call to (e.g. '/add')",
        service_type="Type of the ROS service (e.g. 'std_srvs/srv/Empty')",
    )
    text.add_values(verb, "values", "Values to fill the service request with", "{a: 1, b: 2}")
    repeat = "Repeat the call at a specific rate in Hz"
    verb.add_argument("-r", "--rate", metavar="N", type=float, help=repeat)
    verb = add_verb(
        verbs,
        "find",
        "Output a list of available services of a given type",
        _find,
        service_type="Name of the ROS service type to filter for",
    )
    add_list_options(verb, "service")
    name = "Name of the ROS service to get info"
    add_verb(verbs, "info", "Print information about a service", _info, service_name=name)
    verb = add_verb(verbs, "list", "Output a list of available services", _list)
    add_flag(verb, "-t", "--show-types", help="Additionally show the service type")
    add_list_options(verb, "service")
    name = "Name of the ROS service to get type"
    add_verb(verbs, "type", "Output a service's type", _type, service_name=name)


def _list(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        rows = graph.settled(node, node.get_service_names_and_types)
    shown = graph.visible(rows, hidden=options.include_hidden_services)
    graph.print_names(shown, types=options.show_types, count=options.count_services)


def _info(options: argparse.Namespace) -> None:
    service = graph.absolute(options.service_name)
    with graph.open_node() as node:
        kind = graph.service_type(node, service)
        if kind is None:
            raise SwarmError(f"Unknown service '{options.service_name}'")
        counts = graph.settled(
            node, lambda: (node.count_clients(service), node.count_services(service))
        )
    print(f"Type: {kind}\nClients count: {counts[0]}\nServices count: {counts[1]}")


def _find(options: argparse.Namespace) -> None:
    listing, hidden = Node.get_service_names_and_types, options.include_hidden_services
    graph.print_found(listing, options.service_type, count=options.count_services, hidden=hidden)


def _type(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        name = graph.service_type(node, graph.absolute(options.service_name))
    if name is None:
        raise SwarmError(f"Unknown service '{options.service_name}'")
    print(name)


def _call(options: argparse.Namespace) -> None:
    service = text.load("srv", options.service_type)
    request = service.Request()
    text.fill(request, text.given_values(options, "values"))
    with graph.open_node() as node:
        client = node.create_client(service, graph.absolute(options.service_name))
        if not client.service_is_ready():
            print("waiting for service to become available...", flush=True)
            graph.wait_for(client.service_is_ready, timeout=float("inf"))
        while True:
            print(f"requester: making request: {request!r}\n", flush=True)
            future = client.call_async(request)
            graph.spin(node, future.done)
            print(f"response:\n{future.result()!r}\n", flush=True)
            if options.rate is None:
                return
            time.sleep(1.0 / options.rate)
