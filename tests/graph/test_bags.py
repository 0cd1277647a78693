"""Bags of other people on the ROS graph: played to subscribers, recorded from publishers."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Int32, String

from swarm_recording.bag import Bag
from tests.fakes.ros_domains import reserved_domain
from tests.unit.swarm_recording.bags import NOTE, OTHER, cdr, notes, split_bag, write

LIMIT = 60.0  # [s] of wall time for anything to happen


class Graph:
    """A node in a domain of its own, and processes in it."""

    def __init__(self, domain, folder):
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node: Node = rclpy.create_node("other", context=self._context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._environ = os.environ | {
            "ROS_DOMAIN_ID": str(domain),
            "PATH": str(Path(sys.executable).parent),  # no other ros2 is on it
        }
        self._folder = folder
        self.processes: list[subprocess.Popen[bytes]] = []

    def start(self, *words):
        """Start `ros2 bag WORDS`; what it says is in `said`."""
        with self._log.open("wb") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", "swarm_ros2", "bag", *words],
                env=self._environ, stdout=log, stderr=subprocess.STDOUT, cwd=self._folder,
            )  # fmt: skip
        self.processes.append(process)
        return process

    @property
    def _log(self):
        return self._folder / "log"

    @property
    def said(self):
        return self._log.read_text()

    def hear(self, topic, kind=String, **quality):
        heard: list[bytes] = []
        profile = QoSProfile(depth=5000, **quality)
        self.node.create_subscription(kind, topic, heard.append, profile, raw=True)
        return heard

    def wait(self, condition):
        end = time.monotonic() + LIMIT
        while not condition():
            assert time.monotonic() < end, self.said
            self._executor.spin_once(timeout_sec=0.05)

    def play(self, *words):
        """Play to the end; return the exit code."""
        process = self.start("play", *words)
        self.wait(lambda: process.poll() is not None)
        end = time.monotonic() + 0.3  # what is under way
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.05)
        return process.wait()

    def close(self):
        for process in self.processes:
            process.kill()
            process.wait()
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()


@pytest.fixture
def graph(tmp_path):
    with reserved_domain() as domain:
        graph = Graph(domain, tmp_path)
        with contextlib.closing(graph):
            yield graph


ALL = notes(40, (NOTE, OTHER))
HERE, THERE = ([data for topic, _, data in ALL if topic == name] for name in (NOTE, OTHER))


def test_a_split_bag_is_played_whole(graph, tmp_path):
    parts = [ALL[k : k + 4] for k in range(0, 40, 4)]
    folder = split_bag(tmp_path / "bag", parts)
    lights = write(folder / "part_10.mcap", notes(20, ("/lights",)), kind="acme_msgs/msg/Lights")
    differing = notes(20, ("/differing",))
    write(folder / "part_11.mcap", differing, definition="int32 id\nstring data")
    text = (folder / "metadata.yaml").read_text()
    more = "- part_9.mcap\n" + "".join(f"  - part_{k}.mcap\n" for k in (10, 11))
    (folder / "metadata.yaml").write_text(text.replace("- part_9.mcap\n", more, 1))
    heard = [graph.hear(name) for name in (NOTE, OTHER)]
    assert graph.play(str(folder), "--rate", "4") == 0
    assert heard == [HERE, THERE]
    assert graph.said.count("/lights: the type acme_msgs/msg/Lights is not installed") == 1
    assert "its 20 messages are not played" in graph.said
    assert "int32 id, string data instead of string data" in graph.said
    assert "40 messages played" in graph.said
    assert graph.play(str(lights)) == 2
    assert "none of its topics can be played" in graph.said


def test_topics_offset_and_clock_are_rosbag2s(graph, tmp_path):
    stays = write(
        tmp_path / "bag_0.mcap",
        [("/map", ALL[0][1] - 50 * 10**9, cdr("map")), ("/map", ALL[2][1], cdr("map 2"))],
        quality="- {reliability: 1, durability: 1, depth: 1}",
    )
    write(stays.with_name("bag_1.mcap"), [*ALL, ("/clock", ALL[3][1], bytes(12))])
    heard, other, clock = graph.hear(NOTE), graph.hear(OTHER), graph.hear("/clock", Clock)
    maps = graph.hear("/map", durability=DurabilityPolicy.TRANSIENT_LOCAL)
    words = ("--start-offset", "2.0", "--clock", "--topics", NOTE, "/map", "/none")
    assert graph.play(str(tmp_path), *words) == 0
    assert heard == HERE[10:]  # each 0.2 s; the first one is of the very time
    assert maps[-1] == cdr("map 2")
    assert other == []
    assert "has no topic /none" in graph.said
    times = [message_time(data) for data in clock]
    assert times == sorted(times)
    assert ALL[20][1] - 10**9 <= times[0] <= times[-1] <= ALL[-1][1]
    assert len(times) > 20
    assert graph.play(str(tmp_path), "--topics", "/none") == 2
    assert "has none of these topics" in graph.said


def message_time(data):
    return int.from_bytes(data[4:8], "little") * 10**9 + int.from_bytes(data[8:12], "little")


def test_a_loop_goes_on_until_it_is_ended(graph, tmp_path):
    path = write(tmp_path / "a.mcap", ALL[:8])
    for sign, code in ((signal.SIGINT, 0), (signal.SIGKILL, -signal.SIGKILL)):
        heard = graph.hear(NOTE)  # anew: what the player before sent last may be under way
        process = graph.start("play", str(path), "--loop", "--rate", "4")
        graph.wait(lambda heard=heard: len(heard) > 9)
        assert heard[:8] == HERE[:4] * 2
        process.send_signal(sign)
        assert process.wait(LIMIT) == code


def test_any_topic_is_recorded(graph, tmp_path):
    lights = graph.node.create_publisher(String, "/lights", 10)
    graph.node.create_publisher(String, "/unasked", 10)
    process = graph.start("record", "/lights", "--topics", "later", "/never", "-o", "bag")
    graph.wait(lambda: "recording 1 topics to bag" in graph.said)
    later = graph.node.create_publisher(Int32, "/later", 10)
    graph.wait(lambda: later.get_subscription_count() and lights.get_subscription_count())
    start = time.time_ns()
    for number in range(5):
        lights.publish(String(data=f"{number}"))
        lights.publish(String(data="again"))  # each one counts
        later.publish(Int32(data=number))
        time.sleep(0.05)
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    assert process.wait(LIMIT) == 0
    assert "nobody publishes /never so far" in graph.said
    with closing(Bag(tmp_path / "bag")) as bag:
        assert bag.counts == {"/lights": 10, "/later": 5}
        assert bag.topics["/later"].type == "std_msgs/msg/Int32"
        messages = list(bag.messages(["/lights"]))
    assert [item.data for item in messages[::2]] == [cdr(str(number)) for number in range(5)]
    assert start <= messages[0].time <= messages[-1].time <= start + 10 * 10**9
    assert messages[2].time - messages[0].time > 3 * 10**7  # when they came, not when polled


def test_all_topics_are_recorded_with_simulated_time_where_there_is_one(graph, tmp_path):
    clock = graph.node.create_publisher(Clock, "/clock", 10)
    lights = graph.node.create_publisher(String, "/lights", 10)
    hidden = graph.node.create_publisher(String, "/_hidden", 10)
    stays = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    graph.node.create_publisher(String, "/stays", stays).publish(String(data="so"))
    process = graph.start("record", "-a", "-o", "bag")
    graph.wait(lambda: "recording" in graph.said and lights.get_subscription_count())
    message = Clock()
    for second in range(1, 5):
        message.clock.sec = second
        clock.publish(message)
        time.sleep(0.1)
        lights.publish(String(data=f"{second}"))
        time.sleep(0.1)
    process.send_signal(signal.SIGTERM)
    assert process.wait(LIMIT) == 0
    assert hidden.get_subscription_count() == 0
    with closing(Bag(tmp_path / "bag")) as bag:
        assert bag.counts == {"/clock": 4, "/lights": 4, "/stays": 1}
        times = [item.time for item in bag.messages(["/lights"])]
    assert times == [second * 10**9 for second in range(1, 5)]


def test_at_full_speed_everything_arrives(graph, tmp_path):
    many = notes(2000)
    path = write(tmp_path / "a.mcap", many)
    heard = graph.hear(NOTE)
    assert graph.play(str(path), "--rate", "1000000") == 0
    assert "2000 messages played" in graph.said
    graph.wait(lambda: len(heard) == len(many))
    assert heard == [data for _, _, data in many]
