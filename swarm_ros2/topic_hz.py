"""`ros2 topic hz`: measures the rate at which messages arrive."""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from collections import deque
from typing import Any

from swarm_ros2 import graph, interfaces, quality

WINDOW = 10000  # messages


class RateMeter:
    """Arrival times of the last messages, and their statistics."""

    def __init__(self, window: int = WINDOW) -> None:
        """Start without messages.

        Args:
            window: Number of intervals to keep.
        """
        self._last: float | None = None
        self._intervals: deque[float] = deque(maxlen=window)
        self._reported = 0
        self._count = 0

    def add(self, now: float) -> None:
        """Note a message that arrived at `now` [s]."""
        if self._last is not None:
            self._intervals.append(now - self._last)
        self._last = now
        self._count += 1

    def report(self) -> str | None:
        """Return the statistics as ros2cli words them, None if nothing came since the last call."""
        if not self._intervals or self._count == self._reported:
            return None
        self._reported = self._count
        mean = statistics.fmean(self._intervals)
        rate = 1.0 / mean if mean > 0.0 else math.inf
        deviation = statistics.pstdev(self._intervals, mean)
        return (
            f"average rate: {rate:.3f}\n"
            f"\tmin: {min(self._intervals):.3f}s max: {max(self._intervals):.3f}s"
            f" std dev: {deviation:.5f}s window: {len(self._intervals) + 1}"
        )


def add_verb(verbs: Any) -> None:
    """Add `hz` to the verbs of `ros2 topic`."""
    verb = verbs.add_parser("hz", help="Print the average publishing rate to screen")
    verb.add_argument("topic_name", help="Name of the ROS topic to listen to (e.g. '/chatter')")
    verb.add_argument(
        "--window", "-w", type=int, default=WINDOW, metavar="N",
        help=f"Window size, in number of messages, for calculating rate (default: {WINDOW})",
    )
    verb.add_argument("--wall-time", action="store_true", help="Wall time is always used here")
    quality.add_arguments(verb, preset="sensor_data")
    verb.set_defaults(run=_measure)


def _measure(options: argparse.Namespace) -> None:
    topic = graph.absolute(options.topic_name)
    meter = RateMeter(options.window)
    with graph.open_node() as node:
        name = graph.topic_type(node, topic, timeout=1.0)
        if name is None:
            print(f"WARNING: topic [{topic}] does not appear to be published yet", file=sys.stderr)
            name = graph.topic_type(node, topic, timeout=math.inf)
        profile = quality.for_listening(node, topic, options)
        node.create_subscription(
            interfaces.load("msg", str(name)), topic, lambda _: meter.add(time.monotonic()),
            profile, raw=True,
        )
        while True:
            graph.spin(node, graph.deadline(1.0))
            report = meter.report()
            if report is not None:
                print(report, flush=True)
