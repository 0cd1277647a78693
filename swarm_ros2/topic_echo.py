"""`ros2 topic echo`: prints what is published on a topic."""

from __future__ import annotations

import argparse
import math
import sys
from typing import Any

from swarm_common.model.errors import SwarmError
from swarm_ros2 import graph, quality, text
from swarm_ros2.verbs import LISTENED, add_flag, add_verb

LONGEST = 128  # elements of arrays and strings that are printed


def add_verbs(verbs: Any) -> None:
    """Add `echo` to the verbs of `ros2 topic`."""
    verb = add_verb(verbs, "echo", "Output messages from a topic", _echo, topic_name=LISTENED)
    kind = "Type of the ROS message (e.g. 'std_msgs/msg/String')"
    verb.add_argument("message_type", nargs="?", help=kind)
    quality.add_arguments(verb, preset="sensor_data")
    verb.add_argument("--field", help="Echo a selected field of a message, e.g. pose.pose.position")
    add_flag(verb, "--full-length", "-f", help="Output all elements for arrays, bytes, and strings")
    verb.add_argument(
        "--truncate-length",
        "-l",
        type=int,
        default=LONGEST,
        metavar="N",
        help=f"The length to truncate arrays, bytes, and strings to (default: {LONGEST})",
    )
    add_flag(verb, "--no-arr", help="Don't print array fields of messages")
    add_flag(verb, "--no-str", help="Don't print string fields of messages")
    add_flag(verb, "--flow-style", help="Print collections in one line")
    add_flag(verb, "--csv", help="Output fields separated by commas")
    add_flag(verb, "--once", help="Print the first message and then exit")
    verb.add_argument("--timeout", metavar="N", type=float, help="Give up after N seconds")


def _echo(options: argparse.Namespace) -> None:
    graph.watch_interrupts()
    topic = graph.absolute(options.topic_name)
    is_done = False

    def show(message: Any) -> None:
        nonlocal is_done
        if not is_done:
            _print(message, options)
            sys.stdout.flush()
            is_done = options.once

    with graph.open_node() as node:
        name = options.message_type or graph.topic_type(node, topic)
        if name is None:
            print(f"WARNING: topic [{topic}] does not appear to be published yet", file=sys.stderr)
            raise SwarmError("Could not determine the type for the passed topic")
        message_class = text.load("msg", name)
        profile = quality.for_listening(node, topic, options)
        node.create_subscription(message_class, topic, show, profile)
        is_over = graph.deadline(options.timeout or math.inf)
        graph.spin(node, lambda: is_done or is_over())


def _print(message: Any, options: argparse.Namespace) -> None:
    shape: dict[str, Any] = {
        "longest": None if options.full_length else options.truncate_length,
        "arrays": not options.no_arr,
        "strings": not options.no_str,
    }
    part = _select(message, options.field)
    if options.csv:
        print(",".join(str(item) for item in _flat(text.to_plain(part, **shape))))
    elif hasattr(part, "get_fields_and_field_types"):
        print(text.to_yaml(part, flow=options.flow_style, **shape), end="---\n")
    else:
        print(text.to_plain(part, **shape), end="\n---\n")


def _select(message: Any, field: str | None) -> Any:
    for name in field.split(".") if field else ():
        try:
            message = getattr(message, name)
        except AttributeError as error:
            raise SwarmError(f"Invalid field '{field}': {error}") from error
    return message


def _flat(value: Any) -> list[Any]:
    if not isinstance(value, dict | list):
        return [value]
    items = value.values() if isinstance(value, dict) else value
    return [leaf for item in items for leaf in _flat(item)]
