"""swarm-teleop as a user drives it: toward another robot and a wall, then back to the mission."""

import math
import subprocess
import time
from contextlib import contextmanager

import pytest
import rclpy
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

from swarm_common.middleware.ros_io import pose_from_msg
from swarm_common.model.records import Pose, wrap_angle
from tests.fakes.real_swarm import command

LIMIT = 300.0  # [s] of wall time for a step, on a busy machine
ROBOTS = ("Srobot1", "Srobot2")


class Eyes:
    """Where the robots truly are, as somebody sees who drives one of them."""

    def __init__(self, context):
        self.poses: dict[str, Pose] = {}
        self._node = rclpy.create_node("eyes", context=context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self._node)
        for name in ROBOTS:

            def take(message, name=name):
                self.poses[name] = pose_from_msg(message.pose.pose)

            self._node.create_subscription(Odometry, f"/{name}/ground_truth", take, 10)

    def close(self):
        self._node.destroy_node()

    def watch(self, period):
        end = time.monotonic() + period
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)


@contextmanager
def eyes(domain):
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    seen = Eyes(context)
    yield seen
    seen.close()
    context.try_shutdown()


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_robot_driven_by_hand_touches_nothing_and_does_its_mission_afterwards(start):
    swarm = start(
        "--swarm-size", "2", "--mission", "loading_route", "--goals-per-robot", "1",
        "--until-done", "--speed", "1.5", "--headless", "--no-report",
    )  # fmt: skip
    with eyes(int(swarm.environment["ROS_DOMAIN_ID"])) as seen:
        swarm.wait_until(lambda: "active 2/2" in swarm.output)
        swarm.wait_until(lambda: seen.watch(0.2) or len(seen.poses) == 2)
        hand = subprocess.Popen(
            (*command("teleop"), "Srobot1", "--speed", "1.0"),
            env=swarm.environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert hand.stdout.readline() == "Srobot1 is yours\n"

        def press(key, period):
            hand.stdin.write(key)
            hand.stdin.flush()
            seen.watch(period)

        def turn_to(bearing):
            for _ in range(200):
                error = wrap_angle(bearing - seen.poses["Srobot1"].yaw)
                if abs(error) < 0.15:
                    press(" ", 0.3)
                    return
                press("a" if error > 0.0 else "d", 0.05)
            pytest.fail(f"it does not turn to {bearing:.2f}: {seen.poses}")

        before = seen.poses["Srobot1"]
        for _ in range(2):  # the other one drives meanwhile
            one, other = (seen.poses[name] for name in ROBOTS)
            turn_to(math.atan2(other.y - one.y, other.x - one.x))
            for _ in range(20):
                press("w", 0.1)
        for bearing in (math.pi / 2.0, math.pi):  # walls
            turn_to(bearing)
            for _ in range(40):
                press("w", 0.1)
        assert seen.poses["Srobot1"].distance(before) > 0.3
        assert hand.poll() is None
        press("q", 0.1)
        text, _ = hand.communicate(timeout=LIMIT)
        assert "Srobot1 is on its own again" in text
        assert hand.returncode == 0
        swarm.hurry()
        report = swarm.good_report(LIMIT)
    assert report["goals"] == {"sent": 2, "reached": 2, "failed": 0, "pending": 0}
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert report["min_clearance"] is None or report["min_clearance"] > 0.0
