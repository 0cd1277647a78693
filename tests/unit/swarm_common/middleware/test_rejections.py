"""What doors turned away is counted by kind, and said once per kind and source."""

import os

from swarm_common.middleware.rejections import REASON_LENGTH, SOURCES_PER_KIND, Rejections
from swarm_common.process.messages import EVENTS, InputsRejected
from swarm_common.process.pipes import EventWriter, MessageReader


def _pipe():
    reading, writing = os.pipe()
    return MessageReader(reading, EVENTS), EventWriter(writing)


def test_counts_by_kind_reach_the_pipe_once_and_the_first_reason_of_each_kind():
    reader, writer = _pipe()
    rejections = Rejections(writer, lambda _: None)
    for _ in range(3):
        rejections.reject("odom", "the world", "a number is nan")
    rejections.reject("goal", "a client", "x is 1e+308 m")
    rejections.tell(10.0)
    rejections.reject("goal", "a client", "x is nan")
    rejections.tell(10.1)  # too early
    first = reader.read()
    rejections.flush()
    assert first == [
        InputsRejected(
            {"odom": 3, "goal": 1},
            {
                "odom": "rejected: odom from the world: a number is nan",
                "goal": "rejected: goal from a client: x is 1e+308 m",
            },
        )
    ]
    assert reader.read() == [InputsRejected({"goal": 1}, {})]
    rejections.flush()
    assert reader.read() == []


def test_each_source_is_said_once_and_a_flood_of_names_is_cut():
    lines: list[str] = []
    rejections = Rejections(EventWriter(None), lines.append)
    for number in range(1000):
        for _ in range(3):
            rejections.reject("beacon", f"Srobot{number}", "x" * 10_000)
    assert rejections.counts == {"beacon": 3000}
    assert len(lines) == SOURCES_PER_KIND
    assert max(map(len, lines)) <= REASON_LENGTH
