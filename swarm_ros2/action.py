"""`ros2 action`: list, info, type, send_goal."""

from __future__ import annotations

import argparse
import contextlib
import sys
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import (
    ActionClient,
    get_action_client_names_and_types_by_node,
    get_action_names_and_types,
    get_action_server_names_and_types_by_node,
)
from rclpy.node import Node, NodeNameNonExistentError

from swarm_common.model.errors import SwarmError
from swarm_ros2 import graph, text
from swarm_ros2.verbs import add_flag, add_verb

STATUS_NAMES = {
    getattr(GoalStatus, f"STATUS_{name}"): name
    for name in ("ACCEPTED", "EXECUTING", "CANCELING", "SUCCEEDED", "CANCELED", "ABORTED")
}


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 action`."""
    info = "Name of the ROS action to get info (e.g. '/fibonacci')"
    verb = add_verb(verbs, "info", "Print information about an action", _info, action_name=info)
    add_flag(verb, "-t", "--show-types", help="Additionally show the action type")
    add_flag(verb, "-c", "--count", help="Only show the number of clients and servers")
    verb = add_verb(verbs, "list", "Output a list of action names", _list)
    add_flag(verb, "-t", "--show-types", help="Additionally show the action type")
    add_flag(verb, "-c", "--count-actions", help="Only display the number of actions discovered")
    add_verb(verbs, "type", "Print a action's type", _type, action_name=info)
    verb = add_verb(
        verbs,
        "send_goal",
        "Send an action goal",
        _send_goal,
        action_name="Name of the ROS action (e.g. '/fibonacci')",
        action_type="Type of the ROS action (e.g. 'nav2_msgs/action/NavigateToPose')",
    )
    text.add_values(verb, "goal", "Goal request values", "{order: 10}")
    add_flag(verb, "-f", "--feedback", help="Echo feedback messages for the goal")


def _list(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        rows = graph.settled(node, lambda: get_action_names_and_types(node))
    graph.print_names(rows, types=options.show_types, count=options.count_actions)


def _info(options: argparse.Namespace) -> None:
    action = graph.absolute(options.action_name)
    with graph.open_node() as node:
        sides = graph.settled(node, lambda: _sides(node, action))
    print(f"Action: {action}")
    for side, users in sides.items():
        print(f"Action {side}: {len(users)}")
        for name, types in [] if options.count else users:
            print(f"    {name} [{', '.join(types)}]" if options.show_types else f"    {name}")


def _type(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        rows = dict(graph.settled(node, lambda: get_action_names_and_types(node)))
    if options.action_name not in rows:
        sys.exit(1)
    print("\n".join(rows[options.action_name]))


def _sides(node: Node, action: str) -> dict[str, graph.NamesAndTypes]:
    listings = {
        "clients": get_action_client_names_and_types_by_node,
        "servers": get_action_server_names_and_types_by_node,
    }
    sides: dict[str, graph.NamesAndTypes] = {side: [] for side in listings}
    for name, namespace in node.get_node_names_and_namespaces():
        for side, listing in listings.items():
            with contextlib.suppress(NodeNameNonExistentError):  # it has just gone
                if types := dict(listing(node, name, namespace)).get(action):
                    sides[side].append((f"{namespace.rstrip('/')}/{name}", types))
    return {side: sorted(users) for side, users in sides.items()}


def _send_goal(options: argparse.Namespace) -> None:
    action = text.load("action", options.action_type)
    goal = action.Goal()
    text.fill(goal, text.given_values(options, "goal"))
    with graph.open_node() as node:
        client = ActionClient(node, action, graph.absolute(options.action_name))
        print("Waiting for an action server to become available...", flush=True)
        graph.wait_for(client.server_is_ready, timeout=float("inf"))
        print(f"Sending goal:\n     {text.to_yaml(goal)}", flush=True)

        def show(message: Any) -> None:
            print(f"Feedback:\n    {text.to_yaml(message.feedback)}", flush=True)

        future = client.send_goal_async(goal, show if options.feedback else None)
        graph.spin(node, future.done)
        handle = future.result()
        if not handle.accepted:
            print("Goal was rejected.")
            return
        print(f"Goal accepted with ID: {bytes(handle.goal_id.uuid).hex()}\n", flush=True)
        result = _await_result(node, handle)
        print(f"Result:\n    {text.to_yaml(result.result)}")
        print(f"Goal finished with status: {STATUS_NAMES.get(result.status, 'UNKNOWN')}")
        client.destroy()


def _await_result(node: Node, handle: Any) -> Any:
    """Wait for the result; Ctrl-C cancels the goal."""
    future = handle.get_result_async()
    try:
        graph.spin(node, future.done)
    except KeyboardInterrupt:
        print("Canceling goal...", flush=True)
        cancel = handle.cancel_goal_async()
        graph.spin(node, cancel.done)
        if not cancel.result().goals_canceling:
            raise SwarmError("Failed to cancel goal") from None
        print("Goal canceled.")
        raise
    return future.result()
