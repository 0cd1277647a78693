"""Reading bags: whole and cut off, from any time on, and as a feed at any speed."""

import random
from contextlib import closing

import pytest

from swarm_common.middleware.topic_table import WORLD_TOPICS, robot_topic
from swarm_common.model.errors import ConfigError
from swarm_recording.bag import NANOSECONDS, Bag
from swarm_recording.bag_feed import BagFeed
from swarm_recording.tape import Tape

CLOCK, MAP = WORLD_TOPICS[:2]
ODOM, TF = robot_topic("Srobot1", "odom"), robot_topic("Srobot1", "tf")


def frame(name):
    return bytes(16) + name.encode().ljust(30, b"\0")


@pytest.fixture
def path(tmp_path):
    """A bag of 100 s: a map at 0 s, odometry each second, transforms of two senders."""
    tape = Tape(tmp_path / "recording.mcap", {"seed": "7"})
    for topic in (CLOCK, MAP, ODOM, TF):
        tape.add_topic(topic)
    tape.write(MAP.name, 0, b"map")
    for second in range(101):
        stamp = second * NANOSECONDS
        tape.write(ODOM.name, stamp, f"odom {second}".encode())
        tape.write(TF.name, stamp, frame("map") + bytes([second]))
        tape.write(TF.name, stamp, frame("odom") + bytes([second]))
        if second % 30 == 0:
            tape.save()
    tape.close()
    return tmp_path / "recording.mcap"


class Hands:
    """A clock that is moved by hand."""

    def __init__(self):
        self.time = 50.0

    def __call__(self):
        return self.time


def test_what_is_in_a_bag(path):
    with closing(Bag(path.parent)) as bag:
        assert (bag.start, bag.end) == (0.0, 100.0)
        assert bag.about == {"seed": "7"}
        assert bag.counts == {MAP.name: 1, ODOM.name: 101, TF.name: 202}
        assert bag.topics[MAP.name].is_latched
        assert bag.topics[ODOM.name].type == "nav_msgs/msg/Odometry"
        assert [data for _, _, data in bag.messages([ODOM.name], after=98 * NANOSECONDS)] == [
            b"odom 99",
            b"odom 100",
        ]


def test_the_latest_before_a_time(path):
    with closing(Bag(path)) as bag:
        found = bag.latest([MAP.name, ODOM.name, "/none"], round(70.5 * NANOSECONDS))
        assert found == [(MAP.name, 0, b"map"), (ODOM.name, 70 * NANOSECONDS, b"odom 70")]


def test_a_file_that_ends_in_the_middle_is_mended(path):
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 2 // 5])
    with closing(Bag(path)) as bag:
        assert bag.was_cut
        assert bag.about == {"seed": "7"}
        assert 30.0 <= bag.end < 100.0
        stamps = [stamp for _, stamp, _ in bag.messages([ODOM.name])]
        assert stamps == [second * NANOSECONDS for second in range(len(stamps))]


def test_a_damaged_chunk_is_left_out_and_told(path):
    content = bytearray(path.read_bytes())
    place = len(content) * 3 // 10
    content[place : place + 8] = b"\xff" * 8
    path.write_bytes(content)
    words: list[str] = []
    with closing(Bag(path, words.append)) as bag:
        times = [stamp // NANOSECONDS for _, stamp, _ in bag.messages([ODOM.name])]
        last = bag.latest([ODOM.name], 100 * NANOSECONDS)
    assert times == sorted(set(times))
    assert (times[0], times[-1]) == (0, 100)
    assert 60 < len(times) < 101
    assert last == [(ODOM.name, 100 * NANOSECONDS, b"odom 100")]
    assert bag.was_cut
    assert [str(path) in line for line in words] == [True]


def test_whatever_is_done_to_a_file_it_is_read_as_far_as_it_can_be_or_refused(path):
    whole, rng = path.read_bytes(), random.Random(7)
    read = refused = 0
    for _ in range(300):
        content = bytearray(whole)
        first = rng.randrange(len(content))
        if rng.random() < 0.5:
            content[first : first + rng.choice((1, 4, 300))] = rng.randbytes(rng.choice((1, 4, 40)))
        else:
            del content[first : first + rng.choice((1, 100, len(content)))]
        path.write_bytes(content)
        try:
            with closing(Bag(path)) as bag:
                messages = list(bag.messages())
                bag.latest(bag.topics, messages[-1][1] if messages else 0)
            read += 1
        except ConfigError:
            refused += 1
    assert read > refused


@pytest.mark.parametrize("content", [b"", b"nothing of the kind", None])
def test_what_is_no_bag_is_refused(tmp_path, content):
    file = tmp_path / "x.mcap"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(ConfigError, match=r"x\.mcap"):
        Bag(file)


def test_a_feed_plays_by_the_clock_jumps_and_ends(path):
    hands = Hands()
    with closing(BagFeed(path, hands)) as feed:
        assert feed.topics()[MAP.name] == "nav_msgs/msg/OccupancyGrid"
        assert feed.span == (0.0, 100.0)
        feed.want([MAP.name, ODOM.name])
        assert feed.take() == [(MAP.name, b"map"), (ODOM.name, b"odom 0")]
        hands.time += 5.0
        assert feed.take() == []  # still paused
        feed.play()
        for second in (1, 2, 3):
            hands.time += 1.0
            assert feed.take() == [(ODOM.name, f"odom {second}".encode())]
        feed.speed = 4.0
        hands.time += 1.0
        assert feed.take() == [(ODOM.name, b"odom 7")]  # the newest only
        feed.pause()
        hands.time += 9.0
        assert feed.now == 7.0
        assert feed.take() == []
    hands = Hands()
    with closing(BagFeed(path, hands)) as feed:
        feed.want([ODOM.name])
        feed.seek(40.5)
        assert feed.take() == [(ODOM.name, b"odom 40")]
        feed.want([ODOM.name, MAP.name])
        assert feed.take() == [(MAP.name, b"map")]
        feed.play()
        hands.time += 1000.0
        assert feed.take()[-1] == (ODOM.name, b"odom 100")
        assert not feed.is_playing
        feed.play()  # from the start again
        assert feed.now == 0.0
        feed.seek(-5.0)
        assert feed.now == 0.0
        with pytest.raises(ConfigError, match="speed"):
            feed.speed = 0.0


def test_each_sender_of_transforms_keeps_its_newest(path):
    hands = Hands()
    with closing(BagFeed(path, hands)) as feed:
        feed.want([TF.name])
        feed.take()
        feed.play()
        hands.time += 10.0
        assert [data[-1] for _, data in feed.take()] == [10, 10]
