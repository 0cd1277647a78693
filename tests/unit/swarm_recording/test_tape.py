"""A bag is whole after every write, also when its writer is killed; two libraries read it."""

import os
import random
import subprocess
import sys
import time

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from swarm_common.middleware.topic_table import WORLD_TOPICS, robot_topic
from swarm_recording.tape import Tape, quality_text
from tests.fakes.small_disk import small_disk

STORE = get_typestore(Stores.ROS2_JAZZY)
CLOCK = WORLD_TOPICS[0]
TWIST = robot_topic("Srobot1", "cmd_vel")


def clock(nanoseconds):
    time_type = STORE.types["builtin_interfaces/msg/Time"]
    message = STORE.types["rosgraph_msgs/msg/Clock"](
        clock=time_type(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
    )
    return bytes(STORE.serialize_cdr(message, "rosgraph_msgs/msg/Clock"))


def read_with_mcap(path):
    with path.open("rb") as stream:
        return [
            (channel.topic, message.log_time, message.data)
            for _, channel, message in make_reader(stream, validate_crcs=True).iter_messages()
        ]


def read_with_rosbags(path):
    with AnyReader([path], default_typestore=STORE) as reader:
        return [(link.topic, stamp, bytes(raw)) for link, stamp, raw in reader.messages()]


def test_every_save_leaves_a_whole_file(tmp_path):
    path = tmp_path / "a.mcap"
    tape = Tape(path, {"seed": "3"})
    tape.add_topic(CLOCK)
    written = []
    for number in range(60):
        written.append((CLOCK.name, number * 10**8, clock(number * 10**8)))
        tape.write(*written[-1])
        if number % 7 == 0:
            tape.save()
            assert read_with_mcap(path) == written
            assert read_with_rosbags(path) == written
    tape.close()
    assert read_with_mcap(path) == read_with_rosbags(path) == written
    with path.open("rb") as stream:
        (about,) = make_reader(stream).iter_metadata()
    assert (about.name, about.metadata) == ("swarm", {"seed": "3"})


def test_messages_are_decoded_by_the_schemas_in_the_file(tmp_path):
    path = tmp_path / "a.mcap"
    tape = Tape(path, {})
    tape.add_topic(CLOCK)
    tape.write(CLOCK.name, 1_500_000_000, clock(1_500_000_000))
    tape.close()
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        ((_, _, _, found),) = reader.iter_decoded_messages()
    assert (found.clock.sec, found.clock.nanosec) == (1, 500_000_000)
    with AnyReader([path], default_typestore=STORE) as bag:
        (link,) = bag.connections
        assert link.msgtype == "rosgraph_msgs/msg/Clock"
        assert "int32 sec" in link.msgdef.data


@pytest.mark.parametrize("topic", [CLOCK, WORLD_TOPICS[1], robot_topic("Srobot1", "scan")])
def test_the_quality_of_the_publisher_is_kept(tmp_path, topic):
    path = tmp_path / "a.mcap"
    tape = Tape(path, {})
    tape.add_topic(topic)
    tape.write(topic.name, 0, clock(0))
    tape.close()
    with AnyReader([path], default_typestore=STORE) as reader:
        (quality,) = reader.connections[0].ext.offered_qos_profiles
    assert quality.reliability.name == ("RELIABLE" if topic.is_reliable else "BEST_EFFORT")
    assert quality.durability.name == ("TRANSIENT_LOCAL" if topic.is_latched else "VOLATILE")
    assert "depth: " in quality_text(topic)


class Killed(BaseException):
    """The process ends here."""


def kill_after(steps, monkeypatch):
    """End writing after so many steps; the kernel ends a write between two pages of memory."""
    page = 4096
    pwrite, truncate = os.pwrite, os.ftruncate
    left = steps

    def step():
        nonlocal left
        if left == 0:
            raise Killed
        left -= 1

    def by_pages(descriptor, data, at):
        done = 0
        while done < len(data):
            step()
            size = min(page - (at + done) % page, len(data) - done)
            done += pwrite(descriptor, data[done : done + size], at + done)
        return done

    def cut(descriptor, size):
        step()
        truncate(descriptor, size)

    monkeypatch.setattr(os, "pwrite", by_pages)
    monkeypatch.setattr(os, "ftruncate", cut)


@pytest.mark.parametrize("batch", [3, 300])
def test_a_bag_is_whole_wherever_its_writer_is_killed(tmp_path, monkeypatch, batch):
    """Also where the summary is longer than what is added, and the other way round."""
    steps, is_done = 0, False
    while not is_done:
        path = tmp_path / "a.mcap"
        tape = Tape(path, {"about": "x" * 200})
        tape.add_topic(TWIST)
        tape.add_topic(CLOCK)
        saves = [0]
        with monkeypatch.context() as patch:
            kill_after(steps, patch)
            try:
                for number in range(4 * batch):
                    noise = random.Random(number).randbytes(60)
                    tape.write(CLOCK.name, number, clock(number) + noise)
                    if number % batch == batch - 1:
                        saves.append(number + 1)
                        tape.save()
                is_done = True
            except Killed:
                pass
        if len(saves) > 2 or path.is_file():
            found = read_with_mcap(path)
            assert found == read_with_rosbags(path)
            assert [stamp for _, stamp, _ in found] == list(range(len(found)))
            assert len(found) in saves[-2:]
            path.unlink()
        tape._sheet.close()
        steps += 1
    assert len(found) == 4 * batch
    assert steps > 20


WRITER = """
import sys
from pathlib import Path
from swarm_common.middleware.topic_table import WORLD_TOPICS
from swarm_recording.tape import Tape
tape = Tape(Path(sys.argv[1]), {})
tape.add_topic(WORLD_TOPICS[0])
number = 0
while True:
    for _ in range(300):
        stamp = number.to_bytes(8, "little")
        tape.write("/clock", number, bytes((0, 1, 0, 0)) + stamp)
        number += 1
    tape.save()
"""


def test_kill_9_leaves_a_readable_bag(tmp_path):
    rng = random.Random(5)
    for number in range(4):
        path = tmp_path / f"{number}.mcap"
        with subprocess.Popen([sys.executable, "-c", WRITER, str(path)]) as process:
            try:
                while not path.is_file() or path.stat().st_size < 20_000:
                    assert process.poll() is None
                    time.sleep(0.01)
                time.sleep(rng.uniform(0.0, 0.2))
            finally:
                process.kill()
        found = read_with_mcap(path)
        assert found == read_with_rosbags(path)
        assert [stamp for _, stamp, _ in found] == list(range(len(found)))
        assert len(found) >= 300


def test_a_full_disk_leaves_what_was_saved_before(tmp_path):
    with small_disk(tmp_path / "disk", "600k") as disk:
        path = disk / "a.mcap"
        tape = Tape(path, {})
        tape.add_topic(CLOCK)
        saved: list[tuple[str, int, bytes]] = []

        def write_on():
            for batch in range(1000):
                noise = random.Random(batch)
                stamps = range(100 * batch, 100 * batch + 100)
                written = [(CLOCK.name, at, clock(at) + noise.randbytes(100)) for at in stamps]
                for topic, at, data in written:
                    tape.write(topic, at, data)
                tape.save()
                saved.extend(written)

        with pytest.raises(OSError, match="No space left"):
            write_on()
        assert saved
        assert read_with_mcap(path) == saved
