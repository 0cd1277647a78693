"""Which topics are recorded, and which of their messages."""

import struct

import pytest

from swarm_common.middleware.topic_table import WORLD_TOPICS, robot_topic
from swarm_recording.filter import RateFilter
from swarm_recording.selection import ALWAYS, DEFAULT, select

ROBOTS = ["Srobot1", "Srobot2"]


def names(text):
    return {topic.name for topic in select(text, ROBOTS)}


def test_patterns_choose_and_the_world_comes_always():
    usual = {f"/{robot}/{name}" for robot in ROBOTS for name in DEFAULT}
    assert names("") == usual | set(ALWAYS)
    assert names("scan") == {"/Srobot1/scan", "/Srobot2/scan"} | set(ALWAYS)
    assert names("/Srobot1/scan, *costmap/costmap") - set(ALWAYS) == {
        "/Srobot1/scan",
        *(f"/{robot}/{kind}_costmap/costmap" for robot in ROBOTS for kind in ("local", "global")),
    }
    assert len(names("all")) > 2 * 15
    assert names("/Srobot2/*") - set(ALWAYS) == {n for n in names("all") if "Srobot2" in n}


def stamped(at, seconds, frame=b"map"):
    whole = round(seconds * 10**9)
    body = struct.pack("<iI", whole // 10**9, whole % 10**9)
    return b"\0\1\0\0" + bytes(at - 4) + body + struct.pack("<I", len(frame)) + frame + bytes(40)


def test_what_is_sent_again_is_recorded_once_and_frames_by_sender():
    """9 of 610 odometry messages of a loaded run were in the bag twice."""
    odom, other = robot_topic("Srobot1", "odom"), robot_topic("Srobot2", "odom")
    keep = RateFilter(None)
    times = [keep.stamp(odom, stamped(4, time)) for time in (0.1, 0.1, 0.2, 0.2)]
    assert times == [100_000_000, None, 200_000_000, None]
    assert keep.stamp(other, stamped(4, 0.2)) == 200_000_000
    assert keep.stamp(robot_topic("Srobot1", "robot_description"), b"\0\1\0\0") == keep.latest
    keep = RateFilter(1.0)
    topic = robot_topic("Srobot1", "tf")
    for frame in (b"map\0", b"odom\0"):
        assert keep.stamp(topic, stamped(8, 3.0, frame)) == 3 * 10**9
        assert keep.stamp(topic, stamped(8, 3.1, frame)) is None


@pytest.mark.parametrize(("rate", "kept"), [(10.0, 50), (5.0, 25), (1.0, 5)])
def test_a_rate_thins_each_topic_out(rate, kept):
    keep = RateFilter(rate)
    for name in ("odom", "cmd_vel"):
        topic = robot_topic("Srobot1", name)
        stamps = [keep.stamp(topic, stamped(4, 0.1 * tick)) for tick in range(50)]
        assert sum(stamp is not None for stamp in stamps) == kept


@pytest.mark.parametrize("topic", [WORLD_TOPICS[1], robot_topic("Srobot1", "status")])
def test_events_and_what_stays_for_latecomers_are_always_kept(topic):
    keep = RateFilter(0.1)
    for _ in range(2):
        assert keep.stamp(topic, stamped(4, 0.0)) == 0
