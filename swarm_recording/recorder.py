"""Recorder process of `swarm-up --record`; nothing else of the swarm knows whether it runs.

python -m swarm_recording.recorder CONFIG.json --event-fd N --control-fd M
"""

from __future__ import annotations

import contextlib
import json
import signal
import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, Protocol

from rclpy.node import Node

from swarm_common.middleware.rcl_take import sender_of
from swarm_common.middleware.rclpy_compat import join_graph
from swarm_common.middleware.ros_poll import PolledTopic
from swarm_common.middleware.topic_table import WORLD_TOPICS, Topic
from swarm_common.model.errors import SwarmError
from swarm_common.process.messages import RecordingBegun, RecordingEnded, Refused
from swarm_common.process.pipes import EventWriter, child_options, leave
from swarm_recording.filter import CLOCK, Losses, RateFilter
from swarm_recording.tape import Tape
from swarm_recording.topic_source import SwarmTopics, TopicSource, message_class, quality

LOOK_PERIOD = 0.02  # [s] of wall time between two looks at all topics
DEPTH = 200  # messages of a topic that may come in between
PATIENCE = 60.0  # [s] of wall time for all to be heard before time begins
LAST_LOOK = 0.3  # [s] in which messages under way still arrive when the run ends
PLACES = "/sim/tf"


class Stamps(Protocol):
    """Says when a message was sent."""

    @property
    def begin(self) -> int | None:
        """[ns] when the recording begins; None as long as that is not known."""

    def stamp(self, topic: Topic, data: bytes, received: int) -> int | None:
        """Return the time [ns] of a message; None if it is not to be recorded."""


class Recorder:
    """Writes the messages of all wanted topics to a tape, byte by byte as received.

    Attributes:
        losses: Gaps in the numbers of messages.
    """

    def __init__(
        self,
        node: Node,
        source: TopicSource,
        tape: Tape,
        stamps: Stamps,
        losses: Losses | None = None,
    ) -> None:
        """Subscribe to everything.

        Args:
            node: Appears as the subscriber in the graph.
            stamps: Stamps of the messages; simulated time needs `/clock`, recorded or not.

        Raises:
            ConfigError: If a topic cannot be recorded.
        """
        self.losses = losses or Losses()
        self._heard: set[str] = set()  # topics
        self._node, self._source, self._tape, self._stamps = node, source, tape, stamps
        self._inputs: list[tuple[Topic, PolledTopic]] = []
        # The clock comes first: it says when messages without a stamp were sent.
        topics = sorted(source.begin(), key=lambda topic: topic.name != CLOCK)
        if stamps.begin is None and (not topics or topics[0].name != CLOCK):
            self._subscribe(next(topic for topic in WORLD_TOPICS if topic.name == CLOCK))
        for topic in topics:
            self._add(topic)

    def _add(self, topic: Topic) -> None:
        self._tape.add_topic(topic)
        self._subscribe(topic)

    def _subscribe(self, topic: Topic) -> None:
        kind, depth = message_class(topic.type), quality(topic, DEPTH)
        self._inputs.append((topic, PolledTopic(self._node, kind, topic.name, depth)))

    @property
    def missing(self) -> list[Topic]:
        """Topics that the world publishes before time begins, and of which nothing has come."""
        silent = {name for name, count in self._tape.counts.items() if not count}
        return [t for t, _ in self._inputs if t.comes_first and t.name in silent]

    @property
    def lost(self) -> dict[str, int]:
        """Number of messages by topic that are not on the tape although they were sent."""
        stay = {topic.name: 1 for topic in self.missing if topic.is_latched}
        return stay | dict(sorted(self.losses.counts.items()))

    def await_swarm(self, robots: Collection[str], is_stopped: Callable[[], bool]) -> None:
        """Record until the world and the navigators of robots are heard, before time begins.

        Each side of a topic finds the other by itself. So they have met when this one knows all
        publishers, and an answer has come that was sent since.
        """
        answers = {f"/{robot}/cmd_vel" for robot in robots} & self._tape.counts.keys()
        spaces = ("sim", *robots)
        topics = [
            (topic, source)
            for topic, source in self._inputs
            if not topic.is_optional
            and (topic.name.count("/") == 1 or topic.name.split("/")[1] in spaces)
        ]
        end = time.monotonic() + PATIENCE
        have_met = False
        while not is_stopped() and time.monotonic() < end:
            if not have_met:
                have_met = all(source.senders > topic.many for topic, source in topics)
                self._heard.clear()
            self.take()
            if not self.missing and have_met and answers <= self._heard:
                break
            time.sleep(LOOK_PERIOD)
        else:
            return
        for topic, _ in topics:
            for info in self._node.get_publishers_info_by_topic(topic.name):
                self.losses.meet(topic, sender_of(info.endpoint_gid))

    def take(self, *, is_last: bool = False) -> None:
        """Record the messages that have arrived; what stays can wait for the time, unless last."""
        latest = b""
        for topic, source in self._inputs:
            if topic.is_latched and self._stamps.begin is None and not is_last:
                continue
            is_recorded = topic.name in self._tape.counts
            while (data := source.take()) is not None:
                self._heard.add(topic.name)
                self.losses.note(topic, source.sender, source.sequence, data)
                stamp = self._stamps.stamp(topic, data, source.received)
                if stamp is not None and is_recorded:
                    self._tape.write(topic.name, stamp, data)
                if topic.name == PLACES:
                    latest = data
        changes = self._source.changes(latest)
        for space in changes.gone:
            for entry in [entry for entry in self._inputs if entry[0].name.startswith(space)]:
                self._inputs.remove(entry)
                entry[1].destroy()
        for topic in changes.topics:
            self._add(topic)
        self._tape.save_if_due()


def run(recorder: Recorder, tape: Tape, is_stopped: Callable[[], bool]) -> dict[str, int]:
    """Record until it is stopped; return how many messages were lost, by topic."""
    while not is_stopped():
        recorder.take()
        time.sleep(LOOK_PERIOD)
    end = time.monotonic() + LAST_LOOK
    while time.monotonic() < end:
        recorder.take(is_last=True)
        time.sleep(LOOK_PERIOD)
    tape.close(recorder.lost)
    return recorder.lost


def record(config: dict[str, Any], events: EventWriter) -> dict[str, int]:
    """Record until SIGTERM.

    Args:
        config: Written by `process_table`; `awaited` are the robots to hear before time begins,
            None if it has begun.
        events: Told of the beginning and the end.

    Returns:
        How many messages were lost, by topic.
    """
    stopping: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: stopping.append(number))
    path = Path(config["path"])
    path.parent.mkdir(parents=True, exist_ok=True)
    tape = Tape(path, config["about"])
    node = join_graph("recorder")
    source = SwarmTopics(config["topics"], config["robots"])
    times = RateFilter(config["rate"])
    awaited = config["awaited"]
    losses = Losses(None if awaited is None else times.is_after_begin)
    recorder = Recorder(node, source, tape, times, losses)
    if awaited is not None:
        recorder.await_swarm(awaited, lambda: bool(stopping))
    events.write(RecordingBegun(str(path), len(tape.counts)))
    lost = run(recorder, tape, lambda: bool(stopping))
    missing = [topic.name for topic in recorder.missing if topic.is_latched]
    events.write(RecordingEnded(str(path), sum(tape.counts.values()), lost, missing))
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
    leave(main())
