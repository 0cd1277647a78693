"""`ros2 topic hz`: measures the rate at which messages arrive."""

from __future__ import annotations

import argparse
import math
import sys
import time
from typing import Any

from swarm_ros2 import graph, interfaces, quality
from swarm_ros2.rate import WINDOW, RateMeter


def add_verb(verbs: Any) -> None:
    """Add `hz` to the verbs of `ros2 topic`."""
    verb = verbs.add_parser("hz", help="Print the average publishing rate to screen")
    verb.add_argument("topic_name", help="Name of the ROS topic to listen to (e.g. '/chatter')")
    verb.add_argument(
        "--window",
        "-w",
        type=int,
        default=WINDOW,
        metavar="N",
        help=f"Window size, in number of messages, for calculating rate (default: {WINDOW})",
    )
    verb.add_argument("--wall-time", action="store_true", help="Wall time is always used here")
    quality.add_arguments(verb, preset="sensor_data")
    verb.set_defaults(run=_measure)


def _measure(options: argparse.Namespace) -> None:
    graph.Interrupts.watch()
    topic = graph.absolute(options.topic_name)
    meter = RateMeter(options.window)
    with graph.open_node() as node:
        name = graph.topic_type(node, topic, timeout=1.0)
        if name is None:
            print(f"WARNING: topic [{topic}] does not appear to be published yet", file=sys.stderr)
            name = graph.topic_type(node, topic, timeout=math.inf)
        profile = quality.for_listening(node, topic, options)
        node.create_subscription(
            interfaces.load("msg", str(name)),
            topic,
            lambda _: meter.add(time.monotonic()),
            profile,
            raw=True,
        )
        while True:
            graph.spin(node, graph.deadline(1.0))
            report = meter.report()
            if report is not None:
                print(report, flush=True)
