"""Times of recorded messages."""

from __future__ import annotations

import struct

from swarm_common.middleware.topic_table import all_topics
from swarm_recording.filter import RateFilter

TOPICS = {topic.name: topic for topic in all_topics(["Srobot1"])}


def stamped(name: str, seconds: int) -> bytes:
    at = TOPICS[name].stamp_at
    assert at is not None
    return bytes(at) + struct.pack("<iI", seconds, 0) + bytes(8)


def test_what_stays_is_no_older_than_a_recording_from_the_middle() -> None:
    """The map was recorded at its stamp, 0: players waited for the time of the rest."""
    times = RateFilter(None)
    assert times.begin is None
    for name, seconds, time in (
        ("/clock", 289, 289), ("/map", 0, 289), ("/clock", 290, 290), ("/map", 300, 300)
    ):  # fmt: skip
        assert times.stamp(TOPICS[name], stamped(name, seconds)) == time * 10**9
