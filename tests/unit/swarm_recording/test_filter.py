"""Times of recorded messages."""

import struct

from swarm_common.middleware.topic_table import all_topics
from swarm_recording.filter import Losses, RateFilter

TOPICS = {topic.name: topic for topic in all_topics(["Srobot1"])}


def stamped(name, seconds):
    at = TOPICS[name].stamp_at
    assert at is not None
    return bytes(at) + struct.pack("<iI", seconds, 0) + bytes(8)


def test_what_stays_is_no_older_than_a_recording_from_the_middle():
    """The map was recorded at its stamp, 0: players waited for the time of the rest."""
    times = RateFilter(None)
    assert times.begin is None
    for name, seconds, time in (
        ("/clock", 289, 289), ("/map", 0, 289), ("/clock", 290, 290), ("/map", 300, 300)
    ):  # fmt: skip
        assert times.stamp(TOPICS[name], stamped(name, seconds)) == time * 10**9


def test_a_gap_in_the_numbers_of_a_sender_is_what_was_lost():
    losses = Losses()
    status, latched = TOPICS["/Srobot1/status"], TOPICS["/map"]
    for sender, sequence in (((1, 1), 7), ((1, 1), 8), ((2, 2), 1), ((1, 1), 12), ((2, 2), 2)):
        losses.note(status, sender, sequence, b"")
    assert losses.counts == {status.name: 3}
    losses.note(status, (1, 1), 9, b"")  # late
    losses.note(status, (1, 1), 13, b"")
    losses.note(TOPICS["/Srobot1/odom"], (1, 1), 20, b"")
    for sequence in (1, 5):  # only the latest is kept for latecomers
        losses.note(latched, (1, 1), sequence, b"")
    assert losses.counts == {status.name: 3}


def test_what_a_whole_recording_lacks_before_the_first_message_is_lost_too():
    """A recorder that came late said nothing, as it knew no number before its first."""
    times = RateFilter(None)
    losses = Losses(times.is_after_begin)
    odom, status = TOPICS["/Srobot1/odom"], TOPICS["/Srobot1/status"]
    times.stamp(TOPICS["/clock"], stamped("/clock", 0))
    losses.note(odom, (1, 1), 6, stamped("/Srobot1/odom", 5))
    losses.note(status, (2, 2), 3, stamped("/Srobot1/status", 0))  # before time begins
    assert losses.counts == {odom.name: 5}
