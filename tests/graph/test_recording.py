"""Recordings and RViz configurations against a swarm that runs."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter, defaultdict
from pathlib import Path

import pytest
import rclpy
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from swarm_interfaces.msg import RobotStatus

from swarm_commander.viewers.layouts import layouts
from swarm_common.middleware.topic_table import ORDERS, all_topics, robot_topic
from swarm_recording.bag import Bag
from swarm_recording.selection import select
from swarm_recording.topic_source import message_class, quality
from swarm_ros2 import command_line
from swarm_run.domain import DomainLock
from tests.fakes.ros_domains import reserved_domain
from tests.fakes.rviz_topics import named_topics
from tests.graph.conftest import Process

PATTERNS = "status,odom,scan,tf,tf_static,robot_description,plan,amcl_pose,beacon,particle_cloud"
TYPES = {  # what each display and tool of RViz is made for
    "Map": "nav_msgs/msg/OccupancyGrid",
    "RobotModel": "std_msgs/msg/String",
    "LaserScan": "sensor_msgs/msg/LaserScan",
    "Path": "nav_msgs/msg/Path",
    "Polygon": "geometry_msgs/msg/PolygonStamped",
    "ParticleCloud": "nav2_msgs/msg/ParticleCloud",
    "PoseWithCovariance": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "MarkerArray": "visualization_msgs/msg/MarkerArray",
    "SetInitialPose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "SetGoal": "geometry_msgs/msg/PoseStamped",
}
Heard = dict[str, list[bytes]]


@pytest.fixture(scope="module")
def swarm(start_swarm):
    swarm = start_swarm(2)
    swarm.wait_until_active()
    return swarm


@pytest.fixture
def recorder(swarm, tmp_path):
    config = {
        "path": str(tmp_path / "recording.mcap"),
        "robots": swarm.names,
        "topics": PATTERNS,
        "rate": None,
        "about": {"seed": "0"},
        "awaited": None,
    }
    path = tmp_path / "recorder.json"
    path.write_text(json.dumps(config), encoding="utf-8")
    process = Process("swarm_recording.recorder", path, swarm.domain, tmp_path / "recorder.log")
    yield process
    process.end()


def listen(node, names):
    """Hear the same topics as the recorder, by rclpy's own subscriptions."""
    heard: Heard = defaultdict(list)
    subscriptions = [
        node.create_subscription(
            message_class(topic.type),
            topic.name,
            heard[topic.name].append,
            quality(topic, 500),
            raw=True,
        )
        for topic in select(PATTERNS, names)
    ]
    return heard, subscriptions


def read_with_mcap(path):
    found: Heard = defaultdict(list)
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            found[channel.topic].append(message.data)
    return found


def read_with_rosbags(path):
    found: Heard = defaultdict(list)
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        for link, _, data in reader.messages():
            reader.deserialize(data, link.msgtype)
            found[link.topic].append(bytes(data))
    return found


def test_a_bag_holds_what_was_published(swarm, recorder, tmp_path):
    heard, subscriptions = listen(swarm.node, swarm.names)
    recorder.wait_for("recording")
    swarm.spin(2.0)  # until everybody has found everybody
    for messages in heard.values():
        messages.clear()
    swarm.spin(4.0)
    # What was published again, unchanged, is recorded once.
    expected = {name: list(dict.fromkeys(messages)) for name, messages in heard.items()}
    for subscription in subscriptions:
        swarm.node.destroy_subscription(subscription)
    recorder.popen.terminate()
    swarm.spin_until(lambda: recorder.named("recorded"))
    assert "lost" not in recorder.named("recorded")[0]
    assert recorder.end() == 0
    path = tmp_path / "recording.mcap"
    found = read_with_mcap(path)
    assert found == read_with_rosbags(path) == read_with_rosbags(tmp_path)
    odom = found["/Srobot1/odom"]
    assert len(set(odom)) == len(odom)
    for name in ("odom", "scan", "status", "tf", "plan", "amcl_pose"):
        assert len(expected[f"/Srobot1/{name}"]) >= 3, name
    for name, messages in expected.items():
        missing = Counter(messages) - Counter(found[name])
        assert not missing, f"{sum(missing.values())} of {len(messages)} of {name} are missing"
    assert len(found["/Srobot2/robot_description"]) == len(found["/map"]) == 1


def test_messages_that_a_recorder_missed_are_counted(swarm, recorder, tmp_path):
    """One that was stopped for a while had a gap without a word."""
    flood = swarm.node.create_publisher(RobotStatus, "/Srobot1/status", 10)
    recorder.wait_for("recording")
    swarm.spin(2.0)
    flood.publish(RobotStatus())
    swarm.spin(0.5)
    recorder.popen.send_signal(signal.SIGSTOP)
    for _ in range(5000):  # more than wait for the recorder
        flood.publish(RobotStatus())
    recorder.popen.send_signal(signal.SIGCONT)
    swarm.spin(2.0)
    swarm.node.destroy_publisher(flood)
    recorder.popen.terminate()
    swarm.spin_until(lambda: recorder.named("recorded"))
    (ended,) = recorder.named("recorded")
    assert ended["lost"]["/Srobot1/status"] > 100  # of 5000, fewer on a busy machine
    with contextlib.closing(Bag(tmp_path / "recording.mcap")) as bag:
        assert bag.lost == ended["lost"]


def test_a_run_is_recorded_from_the_middle_and_told_of_as_rosbag2_does(swarm, tmp_path, capsys):
    folder = tmp_path / "bag"
    words = ("bag", "record", "--output", str(folder), "odom", "status")
    environ = os.environ | {"ROS_DOMAIN_ID": str(swarm.domain)}
    lock = DomainLock(swarm.domain)  # as swarm-up, without which swarm-commander looks for nobody
    with (
        contextlib.ExitStack() as stack,
        subprocess.Popen(
            (sys.executable, "-m", "swarm_ros2", *words),
            env=environ,
            stderr=subprocess.PIPE,
            text=True,
        ) as process,
    ):
        stack.callback(lock.release)
        assert process.stderr.readline().startswith("recording 2 robots to ")
        swarm.spin_until((folder / "metadata.yaml").exists)
        swarm.spin(3.0)
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 0
    found = read_with_rosbags(folder)
    assert len(found["/Srobot1/odom"]) > 5
    told = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert told["starting_time"]["nanoseconds_since_epoch"] > 0  # the map's stamp is 0
    assert command_line.run(["bag", "info", str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "Files:             recording.mcap"
    assert f"Messages:          {sum(map(len, found.values()))}" in lines
    count = len(found["/Srobot2/odom"])
    row = f"Topic: /Srobot2/odom | Type: nav_msgs/msg/Odometry | Count: {count} |"
    assert any(row in line for line in lines)


def test_the_clock_is_fine_while_somebody_listens_and_odometry_has_variances(swarm):
    stamps: list[float] = []
    odometry: list[Odometry] = []

    def note(message):
        stamps.append(message.clock.sec + 1e-9 * message.clock.nanosec)

    make = swarm.node.create_subscription
    subscriptions = [
        make(Clock, "/clock", note, 100),
        make(Odometry, "/Srobot1/odom", odometry.append, 10),
    ]
    swarm.spin(2.0)  # until the world has seen it
    stamps.clear()
    start = time.monotonic()
    swarm.spin(2.0)
    rate = len(stamps) / (time.monotonic() - start)
    assert stamps == sorted(set(stamps))
    assert rate > 30.0  # 50, less on a busy machine
    ticks = [round(10.0 * stamp) for stamp in stamps if abs(stamp - round(stamp, 1)) < 1e-6]
    assert len(ticks) > 5
    assert ticks == list(range(ticks[0], ticks[-1] + 1)), (
        "each has its time, whatever comes between"
    )
    for covariance in (odometry[-1].pose.covariance, odometry[-1].twist.covariance):
        assert [covariance[place] for place in (0, 7, 35)] == [1e-9] * 3  # sensors do not err
    for subscription in subscriptions:
        swarm.node.destroy_subscription(subscription)


def test_a_subscription_of_default_quality_gets_scans(swarm):
    """Scans were best effort: it got none, and rclpy's default is reliable."""
    scans: list[LaserScan] = []
    subscription = swarm.node.create_subscription(LaserScan, "/Srobot1/scan", scans.append, 10)
    swarm.spin_until(lambda: len(scans) > 3)
    swarm.node.destroy_subscription(subscription)


def test_the_delay_by_the_simulations_clock_is_short(swarm):
    """By the wall clock, as without the option, the messages are as old as the epoch."""
    words = ("topic", "delay", "--use-sim-time", "/Srobot1/odom")
    environ = os.environ | {"ROS_DOMAIN_ID": str(swarm.domain)}
    with subprocess.Popen(
        (sys.executable, "-m", "swarm_ros2", *words), env=environ, stdout=subprocess.PIPE, text=True
    ) as process:
        line = process.stdout.readline()
        process.kill()
    assert abs(float(line.removeprefix("average delay: "))) < 5.0


def test_fields_are_read_by_the_schemas_of_the_bag(swarm, recorder, tmp_path):
    recorder.wait_for("recording")
    swarm.spin(2.0)
    recorder.end()
    compared = 0
    with (tmp_path / "recording.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for schema, _, message, decoded in reader.iter_decoded_messages():
            ours = deserialize_message(message.data, message_class(schema.name))
            if hasattr(ours, "pose") and hasattr(ours, "header"):  # odom, amcl_pose
                assert decoded.header.stamp.nanosec == ours.header.stamp.nanosec
                assert decoded.pose.pose.position.x == ours.pose.pose.position.x
                assert list(decoded.pose.covariance) == list(ours.pose.covariance)
                compared += 1
    assert compared > 10


def test_kill_9_leaves_a_readable_bag(swarm, recorder, tmp_path):
    recorder.wait_for("recording")
    swarm.spin(4.0)
    os.kill(recorder.popen.pid, signal.SIGKILL)
    recorder.popen.wait()
    path = tmp_path / "recording.mcap"
    found = read_with_mcap(path)
    assert found == read_with_rosbags(path)
    assert len(found["/Srobot1/odom"]) > 10
    bag = Bag(path)
    assert not bag.was_cut
    bag.close()


def test_a_bag_is_played_on_the_graph(swarm, recorder, tmp_path):
    recorder.wait_for("recording")
    swarm.spin(2.5)
    recorder.end()
    path = tmp_path / "recording.mcap"
    expected = read_with_mcap(path)
    with reserved_domain() as domain, listener(domain) as (node, executor):
        heard, _ = listen(node, swarm.names)
        own_path = str(Path(sys.executable).parent)  # no other ros2 is on it
        process = subprocess.Popen(  # it becomes swarm-replay --ros
            [sys.executable, "-m", "swarm_ros2", "bag", "play", str(path), "--rate", "2"],
            env=os.environ | {"ROS_DOMAIN_ID": str(domain), "PATH": own_path},
            stdout=subprocess.DEVNULL,
        )
        try:
            while process.poll() is None:
                executor.spin_once(timeout_sec=0.1)
        finally:
            process.kill()
            process.wait()
        assert process.returncode == 0
    assert heard["/map"] == expected["/map"]
    odom, played = expected["/Srobot1/odom"], heard["/Srobot1/odom"]
    assert len(played) > 5
    assert played == odom[-len(played) :]


@contextlib.contextmanager
def listener(domain):
    """Yield a node in a domain of its own."""
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    node = rclpy.create_node("listener", context=context, enable_rosout=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        yield node, executor
    finally:
        executor.shutdown()
        node.destroy_node()
        context.try_shutdown()


def graph_types(swarm):
    return dict(swarm.node.get_topic_names_and_types())


def test_the_table_of_topics_is_that_of_the_graph(swarm):
    wanted = [topic for topic in all_topics(swarm.names) if not topic.is_optional]
    swarm.spin_until(lambda: {t.name for t in wanted} <= graph_types(swarm).keys())
    for topic in wanted:
        assert graph_types(swarm)[topic.name] == [topic.type]
        offers = swarm.node.get_publishers_info_by_topic(topic.name)
        assert len(offers) == 1 + topic.many, topic.name
        for offer in offers:
            is_reliable = offer.qos_profile.reliability == ReliabilityPolicy.RELIABLE
            is_latched = offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
            assert (is_reliable, is_latched) == (topic.is_reliable, topic.is_latched), topic.name
    for robot in swarm.names:
        for order in ORDERS:
            name = robot_topic(robot, order.name).name
            swarm.spin_until(lambda name=name: swarm.node.count_subscribers(name) > 0)
            readers = swarm.node.get_subscriptions_info_by_topic(name)
            assert [reader.topic_type for reader in readers] == [order.type], name


@pytest.mark.parametrize("window", ["Srobot1", "Srobot2", "swarm", "merged"])
def test_rviz_shows_what_is_there(swarm, window):
    wanted = named_topics(layouts("rviz", swarm.names)[window])
    assert len(wanted) >= 10
    swarm.spin_until(lambda: {t.name for t in wanted} <= graph_types(swarm).keys())
    for topic in wanted:
        assert graph_types(swarm)[topic.name] == [TYPES[topic.shown_by]], topic
        if topic.shown_by.startswith("Set"):
            assert swarm.node.count_subscribers(topic.name) == 1, topic
            continue
        for offer in swarm.node.get_publishers_info_by_topic(topic.name):
            offered = offer.qos_profile
            if topic.reliability == "Reliable":
                assert offered.reliability == ReliabilityPolicy.RELIABLE, topic
            is_latched = offered.durability == DurabilityPolicy.TRANSIENT_LOCAL
            assert is_latched == (topic.durability == "Transient Local"), topic
