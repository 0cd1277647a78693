"""One RViz for all robots: `swarm-commander frames` beside a running swarm, seen by its clients."""

import itertools
import math
import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
import yaml
from geometry_msgs.msg import PolygonStamped, PoseWithCovarianceStamped
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Path as PathMsg
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray
from yourdfpy import URDF

from swarm_commander.viewers.layouts import layouts, write_rviz
from swarm_common.middleware.ros_io import LATCHED, pose_stamped
from swarm_common.model.records import Pose
from swarm_run.domain import DomainLock
from tests.fakes.rviz_topics import named_topics
from tests.graph.conftest import START_LIMIT

STATIC = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # tf2_ros's listener

TYPES = {  # of the displays with headers
    "Map": OccupancyGrid,
    "MarkerArray": MarkerArray,
    "Path": PathMsg,
    "Polygon": PolygonStamped,
}


@pytest.fixture(scope="module")
def relay(swarm, tmp_path_factory):
    log = tmp_path_factory.mktemp("relay") / "log"
    lock = DomainLock(swarm.domain)  # as swarm-up, without which swarm-commander looks for nobody
    program = "from swarm_commander.cli.main import commander; commander()"
    with log.open("w") as output:
        process = subprocess.Popen(
            [sys.executable, "-c", program, "frames"],
            env=os.environ | {"ROS_DOMAIN_ID": str(swarm.domain)},
            stderr=output,
        )
    yield process, log
    if process.poll() is None:
        process.kill()
        process.wait()
    lock.release()


class Tree:
    """What tf2 would know: the parent of each frame and where the frame is in it."""

    def __init__(self, swarm):
        self.parents = {}
        self.places = {}
        make = swarm.node.create_subscription
        make(TFMessage, "/tf", self._take, 100)
        make(TFMessage, "/tf_static", self._take, STATIC)

    def _take(self, message):
        for one in message.transforms:
            parent = self.parents.setdefault(one.child_frame_id, one.header.frame_id)
            assert parent == one.header.frame_id, "a frame with two parents"
            move, turn = one.transform.translation, one.transform.rotation
            self.places[one.child_frame_id] = (move.x, move.y, 2.0 * math.atan2(turn.z, turn.w))

    def way(self, frame):
        frames = [frame]
        while frames[-1] in self.parents:
            frames.append(self.parents[frames[-1]])
        return frames

    def in_map(self, frame):
        """Return the planar place of a frame; all of ours above it are upright."""
        x, y, yaw = 0.0, 0.0, 0.0
        for name in self.way(frame)[:-1]:
            dx, dy, turn = self.places[name]
            x, y = (dx + x * math.cos(turn) - y * math.sin(turn),
                    dy + x * math.sin(turn) + y * math.cos(turn))  # fmt: skip
            yaw += turn
        return x, y, yaw


def latched(swarm, kind, topic):
    heard = []
    subscription = swarm.node.create_subscription(kind, topic, heard.append, LATCHED)
    swarm.spin_until(lambda: heard, START_LIMIT)
    swarm.node.destroy_subscription(subscription)
    return heard[-1]


def test_every_link_of_every_model_is_in_one_tree_under_map(swarm, relay, tmp_path):
    """What a RobotModel display needs: its description, and a frame for each link of it."""
    write_rviz(tmp_path, swarm.names)
    config = yaml.safe_load((tmp_path / "merged.rviz").read_text())
    groups = [
        d for d in config["Visualization Manager"]["Displays"] if d["Class"].endswith("Group")
    ]
    models = [d for group in groups for d in group["Displays"] if d["Class"].endswith("RobotModel")]
    assert len(models) == 2
    links = {}
    for model in models:
        text = latched(swarm, String, model["Description Topic"]["Value"]).data
        path = tmp_path / "robot.urdf"
        path.write_text(text)
        robot = URDF.load(str(path), load_meshes=False, build_scene_graph=False)
        links[model["TF Prefix"]] = [link.name for link in robot.robot.links]
    tree = Tree(swarm)
    wanted = {f"{prefix}/{name}" for prefix, names in links.items() for name in names}
    assert len(wanted) == 2 * len(links["Srobot1"]) > 4
    swarm.spin_until(lambda: wanted <= tree.parents.keys(), START_LIMIT)
    swarm.spin_until(lambda: all(tree.way(frame)[-1] == "map" for frame in wanted))
    for prefix in links:
        way = tree.way(f"{prefix}/base_footprint")
        assert way == [f"{prefix}/base_footprint", f"{prefix}/odom", "map"]
        pose = latched(swarm, PoseWithCovarianceStamped, f"/{prefix}/amcl_pose").pose.pose
        x, y, _ = tree.in_map(f"{prefix}/base_footprint")
        assert (x, y) == pytest.approx((pose.position.x, pose.position.y), abs=0.02)
    for one, other in itertools.combinations(links, 2):
        assert tree.in_map(f"{one}/base_scan") != tree.in_map(f"{other}/base_scan")


def frames_of(message):
    parts = getattr(message, "markers", None)
    return {part.header.frame_id for part in ([message] if parts is None else parts)}


def test_every_topic_of_the_window_brings_messages_in_a_frame_of_the_tree(swarm, relay):
    """Heard as RViz listens: by the type of the display, with the quality that the file names."""
    tree, heard = Tree(swarm), {}
    shown = [
        one for one in named_topics(layouts("rviz", swarm.names)["merged"]) if one.shown_by in TYPES
    ]
    assert {one.shown_by for one in shown} == set(TYPES)
    for one in shown:
        quality = QoSProfile(
            depth=5,
            reliability=ReliabilityPolicy[one.reliability.upper().replace(" ", "_")],
            durability=DurabilityPolicy[one.durability.upper().replace(" ", "_")],
        )
        swarm.node.create_subscription(
            TYPES[one.shown_by], one.name, partial(heard.__setitem__, one.name), quality
        )
    clients = [
        ActionClient(swarm.node, NavigateToPose, f"/{r}/navigate_to_pose") for r in swarm.names
    ]
    for client in clients:
        swarm.spin_until(client.server_is_ready, START_LIMIT)
        goal = NavigateToPose.Goal(pose=pose_stamped(Pose(0.5, 0.0, 0.0), 0))
        goal.pose.header.frame_id = "base_footprint"
        client.send_goal_async(goal)
    # a world in which nobody walks has no movers to show
    wanted = {one.name for one in shown if one.name != "/sim/movers"}
    swarm.spin_until(lambda: wanted <= heard.keys(), START_LIMIT)
    for name, message in heard.items():
        for frame in frames_of(message):
            swarm.spin_until(lambda frame=frame: tree.way(frame)[-1] == "map", START_LIMIT)
            assert frame == "map", name  # robots have other frames in common names only
    for client in clients:
        client.destroy()


def test_it_says_whose_frames_and_ctrl_c_ends_it(swarm, relay):
    process, log = relay
    swarm.spin_until(lambda: "Srobot1, Srobot2; Ctrl-C" in Path(log).read_text(), START_LIMIT)
    process.send_signal(signal.SIGINT)
    assert process.wait(20.0) == 130
    assert "Traceback" not in Path(log).read_text()
