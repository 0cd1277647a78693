"""A process keeps no room for large messages that it has taken, or a flood would make it grow."""

import os
import subprocess
import sys
import time

import psutil
import rclpy
from rclpy.context import Context
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from tests.fakes.ros_domains import reserved_domain

FLOOD = 200  # messages that wait at a time
LARGE = 100_000  # bytes each
KEPT = 5.0  # [MB] at most; pools that only grow keep 20
LISTENER = f"""
import ctypes, sys, rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from swarm_common.middleware.ros_poll import PolledTopic
rclpy.init()
node = rclpy.create_node("listener", enable_rosout=False)
topic = PolledTopic(node, String, "/flood", QoSProfile(depth={FLOOD}))
for line in sys.stdin:
    print(sum(1 for _ in iter(topic.take, None)), flush=True)
    ctypes.CDLL(None).malloc_trim(0)
    print("", flush=True)
"""


def test_room_for_a_flood_of_large_messages_is_given_back():
    context = Context()
    with reserved_domain() as domain:
        listener = subprocess.Popen(
            (sys.executable, "-c", LISTENER),
            env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        rclpy.init(context=context, domain_id=domain)
        node = rclpy.create_node("flooder", context=context, enable_rosout=False)
        try:
            publisher = node.create_publisher(String, "/flood", QoSProfile(depth=FLOOD))
            end = time.monotonic() + 30.0
            while publisher.get_subscription_count() == 0:
                assert time.monotonic() < end
                time.sleep(0.05)
            for _ in range(FLOOD):
                publisher.publish(String(data="small"))
            _take_all(listener, FLOOD)
            before = psutil.Process(listener.pid).memory_info().rss
            for _ in range(FLOOD):
                publisher.publish(String(data="x" * LARGE))
            _take_all(listener, FLOOD)
            after = psutil.Process(listener.pid).memory_info().rss
            assert (after - before) / 2**20 < KEPT
        finally:
            listener.kill()
            listener.communicate()
            node.destroy_node()
            context.try_shutdown()


def _take_all(listener, count):
    """Have the listener take all that waits at once, and what comes late."""
    assert listener.stdin is not None
    taken = 0
    end = time.monotonic() + 60.0
    while taken < count:
        assert time.monotonic() < end, f"{taken} of {count} came"
        time.sleep(1.0)
        print(file=listener.stdin, flush=True)
        taken += int(listener.stdout.readline())
        listener.stdout.readline()
