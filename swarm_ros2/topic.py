"""`ros2 topic`: list, info, type, find; the verbs that carry messages are in their own modules."""

from __future__ import annotations

import argparse
from typing import Any

from rclpy.node import Node

from swarm_common.model.errors import SwarmError
from swarm_ros2 import graph, topic_echo, topic_hz, topic_pub
from swarm_ros2.verbs import add_flag, add_list_options, add_verb


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 topic`."""
    topic_echo.add_verbs(verbs)
    verb = add_verb(
        verbs,
        "find",
        "Output a list of available topics of a given type",
        _find,
        topic_type="Name of the ROS topic type to filter for",
    )
    add_list_options(verb, "topic")
    topic_hz.add_verbs(verbs)
    name = "Name of the ROS topic to get info (e.g. '/chatter')"
    verb = add_verb(verbs, "info", "Print information about a topic", _info, topic_name=name)
    details = (
        "Prints detailed information like the node name, node namespace, topic type, topic type"
        " hash, GUID, and QoS Profile of the publishers and subscribers to this topic"
    )
    add_flag(verb, "--verbose", "-v", help=details)
    verb = add_verb(verbs, "list", "Output a list of available topics", _list)
    add_flag(verb, "-t", "--show-types", help="Additionally show the topic type")
    add_list_options(verb, "topic")
    add_flag(verb, "-v", "--verbose", help="List full details about each topic")
    topic_pub.add_verbs(verbs)
    name = "Name of the ROS topic to get type (e.g. '/chatter')"
    add_verb(verbs, "type", "Print a topic's type", _type, topic_name=name)


def _list(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        graph.settle(node)
        hidden = options.include_hidden_topics
        rows = graph.visible(node.get_topic_names_and_types(), hidden=hidden)
        if options.verbose and not options.count_topics:
            _print_both_sides(node, rows)
            return
    graph.print_names(rows, types=options.show_types, count=options.count_topics)


def _print_both_sides(node: Node, rows: graph.NamesAndTypes) -> None:
    sides = (
        ("Published", "publisher", node.count_publishers),
        ("Subscribed", "subscriber", node.count_subscribers),
    )
    for title, noun, count_of in sides:
        print(f"{title} topics:")
        for name, types in sorted(rows):
            count = count_of(name)
            if count:
                print(f" * {name} [{', '.join(types)}] {count} {noun}{'s' if count > 1 else ''}")
        print()


def _info(options: argparse.Namespace) -> None:
    topic = graph.absolute(options.topic_name)
    with graph.open_node() as node:
        text = graph.settled(
            node,
            lambda: _describe(node, topic, verbose=options.verbose),
            lambda text: bool(text) and graph.UNKNOWN_NODE not in text,
        )
    if not text:
        raise SwarmError(f"Unknown topic '{topic}'")
    print(text)


def _describe(node: Node, topic: str, *, verbose: bool) -> str:
    """Return what ros2cli prints about a topic; nothing while it is unknown."""
    types = dict(node.get_topic_names_and_types()).get(topic)
    if types is None:
        return ""
    publishers = node.get_publishers_info_by_topic(topic)
    subscriptions = node.get_subscriptions_info_by_topic(topic)
    heads = (
        f"Type: {types[0] if len(types) == 1 else types}",
        f"Publisher count: {len(publishers)}",
        f"Subscription count: {len(subscriptions)}",
    )
    if not verbose:
        return "\n".join(heads)
    blocks = (heads[0], heads[1], *map(str, publishers), heads[2], *map(str, subscriptions))
    return "\n\n".join(blocks) + "\n"


def _type(options: argparse.Namespace) -> None:
    topic = graph.absolute(options.topic_name)
    with graph.open_node() as node:
        name = graph.topic_type(node, topic)
    if name is None:
        raise SwarmError(f"Unknown topic '{topic}'")
    print(name)


def _find(options: argparse.Namespace) -> None:
    listing, hidden = Node.get_topic_names_and_types, options.include_hidden_topics
    graph.print_found(listing, options.topic_type, count=options.count_topics, hidden=hidden)
