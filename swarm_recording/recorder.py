"""Recorder process of `swarm-up --record`; nothing else of the swarm knows whether it runs.

python -m swarm_recording.recorder CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node

from swarm_common.middleware.cdr import TransformsReader
from swarm_common.middleware.ros_poll import PolledTopic
from swarm_common.middleware.topic_table import Topic
from swarm_common.model.errors import SwarmError
from swarm_common.process.messages import RecordingBegun, RecordingEnded, Refused
from swarm_common.process.pipes import EventWriter, child_options
from swarm_recording.filter import CLOCK, Losses, RateFilter
from swarm_recording.ros_types import message_class, quality
from swarm_recording.selection import select, select_of
from swarm_recording.tape import Tape

LOOK_PERIOD = 0.02  # [s] of wall time between two looks at all topics
DEPTH = 200  # messages of a topic that may come in between
LAST_LOOK = 0.3  # [s] in which messages under way still arrive when the run ends
PLACES = "/sim/tf"


class Recorder:
    """Writes the messages of all wanted topics to a tape, byte by byte as received.

    Robots that come later are recorded from the moment at which `/sim/tf` shows them.

    Attributes:
        losses: Messages that are not on the tape although they were sent.
    """

    def __init__(
        self, node: Node, robots: list[str], patterns: str, tape: Tape, rate: float | None
    ) -> None:
        """Subscribe to everything.

        Args:
            node: Appears as the subscriber in the graph.
            patterns: Of the topics to record, see `select`.
            rate: See `RateFilter`.

        Raises:
            ConfigError: If a pattern matches nothing.
        """
        self.losses = Losses()
        self._node = node
        self._tape = tape
        self._filter = RateFilter(rate)
        self._patterns = patterns
        self._reader = TransformsReader()
        self._robots = set(robots)
        self._inputs: list[tuple[Topic, PolledTopic]] = []
        # The clock comes first: it says when messages without a stamp were sent.
        for topic in sorted(select(patterns, robots), key=lambda topic: topic.name != CLOCK):
            self._add(topic)

    def _add(self, topic: Topic) -> None:
        self._tape.add_topic(topic)
        kind, depth = message_class(topic.type), quality(topic, DEPTH)
        self._inputs.append((topic, PolledTopic(self._node, kind, topic.name, depth)))

    def take(self, *, is_last: bool = False) -> None:
        """Record the messages that have arrived; what stays can wait for the time, unless last."""
        latest = b""
        for topic, source in self._inputs:
            if topic.is_latched and self._filter.begin is None and not is_last:
                continue
            while (data := source.take()) is not None:
                self.losses.note(topic, source.sender, source.sequence)
                stamp = self._filter.stamp(topic, data)
                if stamp is not None:
                    self._tape.write(topic.name, stamp, data)
                if topic.name == PLACES:
                    latest = data
        if latest:
            self._meet(latest)
        self._tape.save_if_due()

    def _meet(self, transforms: bytes) -> None:
        """Begin with robots that have come, and end with those that are gone."""
        try:
            _, frames, _ = self._reader.read(transforms)
        except ValueError:  # from a foreign publisher; it is recorded all the same
            return
        robots = {frame.partition("/")[0] for frame in frames}
        for robot in self._robots - robots:
            space = f"/{robot}/"
            for entry in [entry for entry in self._inputs if entry[0].name.startswith(space)]:
                self._inputs.remove(entry)
                entry[1].destroy()
        for robot in sorted(robots - self._robots):
            for topic in select_of(self._patterns, robot):
                self._add(topic)
        self._robots = robots


def record(config: dict[str, Any], events: EventWriter) -> int:
    """Record until SIGTERM.

    Args:
        config: See `recorder_config`.
        events: Told of the beginning and the end.

    Returns:
        How many messages were lost.
    """
    path = Path(config["path"])
    path.parent.mkdir(parents=True, exist_ok=True)
    tape = Tape(path, config["about"])
    rclpy.init(signal_handler_options=rclpy.SignalHandlerOptions.NO)
    node = rclpy.create_node("recorder", enable_rosout=False, start_parameter_services=False)
    recorder = Recorder(node, config["robots"], config["topics"], tape, config["rate"])
    stopping: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: stopping.append(number))
    events.write(RecordingBegun(str(path), len(tape.counts)))
    while not stopping:
        recorder.take()
        time.sleep(LOOK_PERIOD)
    end = time.monotonic() + LAST_LOOK
    while time.monotonic() < end:
        recorder.take(is_last=True)
        time.sleep(LOOK_PERIOD)
    tape.close()
    lost = recorder.losses.count
    events.write(RecordingEnded(str(path), sum(tape.counts.values()), lost))
    return lost


def main() -> int:
    """Run until SIGTERM; return the exit code."""
    options = child_options("Recorder of a swarm")
    config = json.loads(options.config.read_text(encoding="utf-8"))
    events = EventWriter(options.event_fd)
    with contextlib.suppress(BrokenPipeError):
        try:
            record(config, events)
        except (SwarmError, OSError) as error:
            events.write(Refused(f"recording to {config['path']}: {error}"))
            return 2
    return 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    # Everything of this process ends with it; taking the graph down entity by entity takes longer.
    os._exit(code)
