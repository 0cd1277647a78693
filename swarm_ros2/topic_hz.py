"""`ros2 topic hz`, `bw` and `delay`: what arrives on a topic, in figures."""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.serialization import deserialize_message

from swarm_common.model.errors import SwarmError
from swarm_ros2 import graph, quality, text
from swarm_ros2.rate import WINDOW, BandwidthMeter, DelayMeter, RateMeter
from swarm_ros2.verbs import LISTENED, add_flag, add_verb

NANOSECONDS = 1e9
BANDWIDTH_WINDOW = 100  # messages
HELP = {
    "hz": "Print the average publishing rate to screen",
    "bw": "Display bandwidth used by topic",
    "delay": "Display delay of topic from timestamp in header",
}
Take = Callable[[bytes], None]
Report = Callable[[], str | None]


def add_verbs(verbs: Any) -> None:
    """Add `hz`, `bw` and `delay` to the verbs of `ros2 topic`."""
    for name, summary in HELP.items():
        verb = add_verb(verbs, name, summary, _measure, topic_name=LISTENED)
        window = BANDWIDTH_WINDOW if name == "bw" else WINDOW
        verb.add_argument(
            "--window",
            "-w",
            type=int,
            default=window,
            metavar="N",
            help=f"Window size, in number of messages, for calculating it (default: {window})",
        )
        if name == "hz":
            add_flag(verb, "--wall-time", help="Wall time is always used here")
        quality.add_arguments(verb, preset="sensor_data")
        verb.set_defaults(measure=name)


def _measure(options: argparse.Namespace) -> None:
    graph.watch_interrupts()
    topic = graph.absolute(options.topic_name)
    with graph.open_node(sim_time=options.use_sim_time) as node:
        name = graph.topic_type(node, topic, timeout=1.0)
        if name is None:
            print(f"WARNING: topic [{topic}] does not appear to be published yet", file=sys.stderr)
            name = graph.topic_type(node, topic, timeout=math.inf)
        kind = text.load("msg", str(name))
        take, report = METERS[options.measure](options.window, kind, node)
        profile = quality.for_listening(node, topic, options)
        node.create_subscription(kind, topic, take, profile, raw=True)
        if options.measure == "bw":
            print(f"Subscribed to [{topic}]", flush=True)
        while True:
            graph.spin(node, graph.deadline(1.0))
            if (line := report()) is not None:
                print(line, flush=True)


def _rate(window: int, _: Any, __: Node) -> tuple[Take, Report]:
    rate = RateMeter(window)
    return lambda _: rate.add(time.monotonic()), rate.report


def _bandwidth(window: int, _: Any, __: Node) -> tuple[Take, Report]:
    meter = BandwidthMeter(window)
    return (lambda data: meter.add(time.monotonic(), data), lambda: meter.report(time.monotonic()))


def _delay(window: int, kind: Any, node: Node) -> tuple[Take, Report]:
    if "header" not in kind.get_fields_and_field_types():
        raise SwarmError("msg does not have header")
    meter = DelayMeter(window)

    def take(data: bytes) -> None:
        stamp = deserialize_message(data, kind).header.stamp
        now = node.get_clock().now().nanoseconds / NANOSECONDS
        if now <= 0.0:  # /clock has not come yet
            return
        meter.add(now - stamp.sec - stamp.nanosec / NANOSECONDS)

    return take, meter.report


METERS = {"hz": _rate, "bw": _bandwidth, "delay": _delay}
