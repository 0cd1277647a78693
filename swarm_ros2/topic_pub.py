"""`ros2 topic pub`: publishes a message once, some times or at a rate."""

from __future__ import annotations

import argparse
import math
import time
from typing import Any

from swarm_common.model.errors import SwarmError
from swarm_ros2 import graph, quality, text
from swarm_ros2.verbs import add_flag, add_verb


def add_verbs(verbs: Any) -> None:
    """Add `pub` to the verbs of `ros2 topic`."""
    verb = add_verb(
        verbs,
        "pub",
        "Publish a message to a topic",
        _publish,
        topic_name="Name of the ROS topic to publish to (e.g. '/chatter')",
        message_type="Type of the ROS message (e.g. 'std_msgs/String')",
    )
    text.add_values(verb, "values", "Values to fill the message with", "data: Hello World")
    rate = "Publishing rate in Hz (default: 1)"
    verb.add_argument("-r", "--rate", metavar="N", type=_positive, default=1.0, help=rate)
    every = "Only print every N-th published message (default: 1)"
    verb.add_argument("-p", "--print", metavar="N", type=int, default=1, dest="every", help=every)
    group = verb.add_mutually_exclusive_group()
    add_flag(group, "-1", "--once", help="Publish one message and exit")
    times = "Publish this number of times and then exit"
    group.add_argument("-t", "--times", type=int, default=0, help=times)
    verb.add_argument(
        "-w",
        "--wait-matching-subscriptions",
        type=int,
        default=None,
        metavar="N",
        dest="wait",
        help="Wait until finding the specified number of matching subscriptions. Defaults to 1"
        ' when using "-1"/"--once"/"--times", otherwise defaults to 0',
    )
    verb.add_argument(
        "--max-wait-time-secs",
        type=_positive,
        default=math.inf,
        metavar="N",
        dest="patience",
        help="Give up waiting for matching subscriptions after N seconds (default: never)",
    )
    verb.add_argument("-n", "--node-name", help="Name of the created publishing node")
    alive = "Keep publishing node alive for N seconds after the last msg (default: 0.1)"
    verb.add_argument("--keep-alive", metavar="N", type=_positive, default=0.1, help=alive)
    quality.add_arguments(verb, preset="default")


def _publish(options: argparse.Namespace) -> None:
    message = text.load("msg", options.message_type)()
    stamps: list[text.Stamp] = []
    text.fill(message, text.given_values(options, "values"), stamps)
    times = 1 if options.once else options.times
    with graph.open_node(options.node_name) as node:
        publisher = node.create_publisher(
            type(message), graph.absolute(options.topic_name), quality.from_arguments(options)
        )
        wanted = options.wait if options.wait is not None else min(times, 1)
        _wait_for_subscriptions(publisher, wanted, options.patience)
        print("publisher: beginning loop", flush=True)
        due = time.monotonic()
        count = 0
        while times == 0 or count < times:
            time.sleep(max(0.0, due - time.monotonic()))
            due += 1.0 / options.rate
            count += 1
            if stamps:
                now = node.get_clock().now().to_msg()
                for stamp in stamps:
                    stamp(now)
            if options.every and count % options.every == 0:
                print(f"publishing #{count}: {message!r}\n", flush=True)
            publisher.publish(message)
        time.sleep(options.keep_alive)


def _wait_for_subscriptions(publisher: Any, wanted: int, patience: float) -> None:
    waited = 0.0
    while publisher.get_subscription_count() < wanted:
        if waited > patience:
            raise SwarmError(
                f"Timed out waiting for subscribers: Expected {wanted} subscribers but only got"
                f" {publisher.get_subscription_count()} subscribers"
            )
        if waited % 1.0 < graph.POLL:
            print(f"Waiting for at least {wanted} matching subscription(s)...", flush=True)
        time.sleep(graph.POLL)
        waited += graph.POLL


def _positive(word: str) -> float:
    value = float(word)
    if value <= 0.0:
        raise argparse.ArgumentTypeError("value must be positive")
    return value
