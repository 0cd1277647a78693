"""A navigator that was killed and started again knows where its robot is, and drives on."""

import json
import os
import signal

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile

from swarm_common.records import Pose
from swarm_common.ros_io import pose_from_msg, pose_stamped
from tests.graph.conftest import START_LIMIT, Process

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
DRIVEN = 1.5  # [m] before it is killed


@pytest.fixture(scope="module")
def swarm(start_swarm):
    started = start_swarm(2)
    started.wait_until_active()
    return started


@pytest.fixture
def truth(swarm):
    """Yield a list of the true poses of the first robot."""
    poses = []
    subscription = swarm.node.create_subscription(
        Odometry, "/Srobot1/ground_truth", lambda m: poses.append(pose_from_msg(m.pose.pose)), 10
    )
    swarm.spin_until(lambda: poses, START_LIMIT)
    yield poses
    swarm.node.destroy_subscription(subscription)


def send(swarm, pose_map):
    client = ActionClient(swarm.node, NavigateToPose, "/Srobot1/navigate_to_pose")
    swarm.spin_until(client.server_is_ready, START_LIMIT)
    goal = NavigateToPose.Goal(pose=pose_stamped(pose_map, 0))
    handle = swarm.result_of(client.send_goal_async(goal), START_LIMIT)
    assert handle.accepted
    return handle


def restart(swarm, name):
    """Kill a navigator and start another in its place, as an operator would; return it."""
    os.kill(swarm.pid_of(name), signal.SIGKILL)
    swarm.host.wait_for("died")
    os.write(swarm.world.control_fd, json.dumps({"cmd": "dead", "robot": name}).encode() + b"\n")
    config = swarm.folder / "again.json"
    robots = [{"name": name, "params": str(swarm.folder / f"{name}.yaml")}]
    config.write_text(json.dumps({"robots": robots}), encoding="utf-8")
    return Process("swarm_nav.host", config, swarm.domain, swarm.folder / "again.log")


@pytest.mark.timeout(400)
def test_a_restarted_navigator_goes_on_where_its_robot_is(swarm, truth):
    home = truth[-1]
    ahead = home.compose(Pose(4.0, 0.0, 0.0))
    send(swarm, ahead)
    swarm.spin_until(lambda: truth[-1].distance(home) > DRIVEN, START_LIMIT)
    again = restart(swarm, "Srobot1")
    try:
        again.wait_for("active")
        swarm.spin_until(lambda: swarm.world.named("progress")[-1]["answering"] == 2, START_LIMIT)
        estimates = []
        subscription = swarm.node.create_subscription(
            PoseWithCovarianceStamped,
            "/Srobot1/amcl_pose",
            lambda m: estimates.append(pose_from_msg(m.pose.pose)),
            LATCHED,
        )
        result = swarm.result_of(send(swarm, home).get_result_async(), START_LIMIT)
        assert result.result.error_code == 0
        swarm.spin_until(lambda: estimates and estimates[-1].distance(truth[-1]) < 0.1)
        swarm.node.destroy_subscription(subscription)
        assert truth[-1].distance(home) < 0.3
        collisions = swarm.world.named("progress")[-1]["collisions"]
        assert set(collisions.values()) == {0}
    finally:
        again.end()
