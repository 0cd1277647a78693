"""A navigator that was killed and started again knows where its robot is, and drives on."""

import json
import os
import signal

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile

from swarm_common.middleware.ros_io import pose_from_msg, pose_stamped
from swarm_common.model.records import Pose
from swarm_run.robots.client import RobotCommander
from swarm_run.robots.task import TaskResult
from tests.graph.conftest import START_LIMIT, Process

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
DRIVEN = 1.5  # [m] before it is killed


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


@pytest.fixture(scope="module")
def robot(swarm):
    """Return a client that repeats what was lost.

    DDS takes the killed navigator for alive for 10 s more, so that a plain action client is ready
    before it has found the new one.
    """
    return RobotCommander(swarm.node, "Srobot1")


def send(swarm, robot, pose_map):
    swarm.spin_until(robot.isReady, START_LIMIT)
    robot.goToPose(pose_stamped(pose_map, 0))


def restart(swarm, name):
    """Kill a navigator and start another in its place, as an operator would; return it."""
    os.kill(swarm.pid_of(name), signal.SIGKILL)
    swarm.host.wait_for("died")
    os.write(swarm.world.control_fd, json.dumps({"cmd": "dead", "robot": name}).encode() + b"\n")
    config = swarm.folder / "again.json"
    robots = [{"name": name, "params": str(swarm.folder / f"{name}.yaml")}]
    config.write_text(json.dumps({"robots": robots}), encoding="utf-8")
    return Process(
        "swarm_nav.launch.fork_server_main", config, swarm.domain, swarm.folder / "again.log"
    )


@pytest.mark.timeout(400)
def test_a_restarted_navigator_goes_on_where_its_robot_is(swarm, robot, truth):
    home = truth[-1]
    ahead = home.compose(Pose(4.0, 0.0, 0.0))
    send(swarm, robot, ahead)
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
        send(swarm, robot, home)
        swarm.spin_until(robot.isTaskComplete, START_LIMIT)
        assert robot.getResult() is TaskResult.SUCCEEDED
        swarm.spin_until(lambda: estimates and estimates[-1].distance(truth[-1]) < 0.1)
        swarm.node.destroy_subscription(subscription)
        assert truth[-1].distance(home) < 0.3
        collisions = swarm.world.named("progress")[-1]["collisions"]
        assert set(collisions.values()) == {0}
    finally:
        again.end()
