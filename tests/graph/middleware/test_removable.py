"""Publishers and subscriptions that end while an executor has their node; events come late."""

import sys

import pytest

from tests.fakes.programs import run_program
from tests.fakes.ros_domains import reserved_domain

# Somebody with a quality that does not fit appears after the end, before the executor's next turn.
CODE = """
import os, time, rclpy
from rclpy.context import Context
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from swarm_common.middleware import rclpy_compat
from swarm_common.middleware.ros_poll import drain

def turn():
    for _ in range(5):
        drain(executor)
        time.sleep(0.02)

rclpy.init()
node = rclpy.create_node("world", enable_rosout=False)
executor = rclpy_compat.SafeExecutor()
executor.add_node(node)
other = Context()
rclpy.init(context=other)
tool = rclpy.create_node("tool", context=other, enable_rosout=False)
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
if "{kind}" == "publisher":
    mine = rclpy_compat.removable_publisher(node, String, "/topic", QoSProfile(depth=1))
    turn()
    node.destroy_publisher(mine)
    theirs = tool.create_subscription(String, "/topic", print, latched)
else:
    mine = rclpy_compat.removable_subscription(node, String, "/topic", print, latched)
    turn()
    node.destroy_subscription(mine)
    theirs = tool.create_publisher(String, "/topic", QoSProfile(depth=1))
del mine
time.sleep(1.0)
turn()
print("lives", flush=True)
os._exit(0)
"""


@pytest.mark.parametrize("kind", ["publisher", "subscription"])
def test_a_late_event_of_what_has_ended_does_not_end_the_process(kind):
    with reserved_domain() as domain:
        done = run_program(
            (sys.executable, "-c", CODE.replace("{kind}", kind)), {"ROS_DOMAIN_ID": str(domain)}
        )
    assert "lives" in done.stdout, done.stderr
