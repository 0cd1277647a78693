"""Several navigators in one process: each its own node, and its own failure."""

import os

import pytest
from nav_msgs.msg import Odometry

from swarm_common import ros_io

NO_ODOMETRY = b"\x00\x01\x00\x00 not an odometry"


@pytest.fixture(scope="module")
def swarm(start_swarm):
    started = start_swarm(3, pack=3)
    started.wait_until_active()
    return started


def navigators_in(swarm):
    return {name for name in swarm.node.get_node_names_and_namespaces() if name[0] == "navigator"}


def test_a_pack_is_one_process_with_a_node_for_each_robot(swarm):
    pids = {event["pid"] for event in swarm.host.named("active")}
    assert len(pids) == 1
    assert os.getpid() not in pids
    expected = {("navigator", f"/{name}") for name in swarm.names}
    swarm.spin_until(lambda: navigators_in(swarm) == expected)


def test_one_that_fails_leaves_the_others_alone(swarm):
    publisher = swarm.node.create_publisher(Odometry, "/Srobot2/odom", ros_io.RELIABLE)
    swarm.spin_until(lambda: publisher.get_subscription_count() > 0)
    while not swarm.host.named("died"):
        publisher.publish(NO_ODOMETRY)
        swarm.spin(0.2)
    swarm.node.destroy_publisher(publisher)
    assert swarm.host.named("died") == [{"event": "died", "robot": "Srobot2", "returncode": 1}]
    os.write(swarm.world.control_fd, b'{"cmd": "dead", "robot": "Srobot2"}\n')
    before = swarm.sim_time()
    swarm.spin_until(lambda: swarm.sim_time() > before + 2.0)
    others = {("navigator", "/Srobot1"), ("navigator", "/Srobot3")}
    swarm.spin_until(lambda: navigators_in(swarm) == others)
    assert "struct.error" in (swarm.folder / "Srobot1.log").read_text(encoding="utf-8")
