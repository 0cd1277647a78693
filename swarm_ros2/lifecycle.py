"""`ros2 lifecycle`: get, list, nodes, set."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from rclpy.node import Node

from swarm_common.model.errors import SwarmError
from swarm_ros2 import graph
from swarm_ros2.param import call
from swarm_ros2.verbs import NODE, add_flag, add_verb


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 lifecycle`."""
    verb = add_verb(verbs, "get", "Get lifecycle state for one or more nodes", _get)
    verb.add_argument("node_name", nargs="?", help="Name of the ROS node, of all if there is none")
    verb = add_verb(verbs, "list", "Output a list of available transitions", _list, node_name=NODE)
    add_flag(verb, "-a", "--all", help="Display all existing transitions")
    verb = add_verb(verbs, "nodes", "Output a list of nodes with lifecycle", _nodes)
    add_flag(verb, "-a", "--all", help="Display all nodes even hidden ones")
    add_flag(verb, "-c", "--count-nodes", help="Only display the number of nodes")
    what, transition = "Trigger lifecycle state transition", "The lifecycle transition"
    add_verb(verbs, "set", what, _set, node_name=NODE, transition=transition)


def _names(node: Node, *, hidden: bool = False) -> list[str]:
    graph.settle(node)
    services = dict(node.get_service_names_and_types())
    return [n for n in graph.node_names(node, hidden=hidden) if f"{n}/get_state" in services]


def _nodes(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        names = _names(node, hidden=options.all)
    print(len(names) if options.count_nodes else "\n".join(names))


def _get(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        name = options.node_name
        owners = _names(node) if name is None else [graph.absolute(name)]
        for owner in owners:
            state = call(node, owner, GetState, "get_state", GetState.Request()).current_state
            print(f"{'' if name else f'{owner}: '}{state.label} [{state.id}]", flush=True)


def _transitions(node: Node, owner: str, service: str) -> list[Any]:
    kind = GetAvailableTransitions
    return list(call(node, owner, kind, service, kind.Request()).available_transitions)


def _list(options: argparse.Namespace) -> None:
    service = "get_transition_graph" if options.all else "get_available_transitions"
    with graph.open_node() as node:
        ways = _transitions(node, graph.absolute(options.node_name), service)
    for way in ways:
        print(f"- {way.transition.label} [{way.transition.id}]")
        print(f"\tStart: {way.start_state.label}\n\tGoal: {way.goal_state.label}")


def _set(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        owner = graph.absolute(options.node_name)
        ways = [w.transition for w in _transitions(node, owner, "get_available_transitions")]
        wanted = options.transition
        found = [w for w in ways if w.label == wanted] or [w for w in ways if str(w.id) == wanted]
        if not found:
            known = "".join(f"\n- {way.label} [{way.id}]" for way in ways)
            raise SwarmError(f"Unknown transition requested, available ones are:{known}")
        request = ChangeState.Request(transition=found[0])
        is_done = call(node, owner, ChangeState, "change_state", request).success
    if is_done:
        print("Transitioning successful")
    else:
        print("Transitioning failed", file=sys.stderr)
