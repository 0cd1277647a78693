"""swarm-teleop as a user drives it: toward another robot and a wall, then back to the mission."""

import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import rclpy
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

from swarm_common.middleware.ros_io import pose_from_msg
from swarm_common.model.records import Pose, wrap_angle
from tests.fakes.ros_domains import reserved_domain

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 300.0  # [s] of wall time for a step, on a busy machine
ROBOTS = ("Srobot1", "Srobot2")


class Eyes:
    """Where the robots truly are, as somebody sees who drives one of them."""

    def __init__(self, context: Context) -> None:
        self.poses: dict[str, Pose] = {}
        self._node = rclpy.create_node("eyes", context=context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self._node)
        for name in ROBOTS:

            def take(message: Odometry, name: str = name) -> None:
                self.poses[name] = pose_from_msg(message.pose.pose)

            self._node.create_subscription(Odometry, f"/{name}/ground_truth", take, 10)

    def close(self) -> None:
        self._node.destroy_node()

    def watch(self, period: float) -> None:
        end = time.monotonic() + period
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)


@contextmanager
def eyes(domain: int) -> Iterator[Eyes]:
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    seen = Eyes(context)
    yield seen
    seen.close()
    context.try_shutdown()


def call(name: str) -> tuple[str, ...]:
    code = f"import sys; from swarm_commander.cli.main import {name}; sys.exit({name}())"
    return (sys.executable, "-c", code)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_robot_driven_by_hand_touches_nothing_and_does_its_mission_afterwards(tmp_path):
    log = tmp_path / "up.log"
    with reserved_domain() as domain, log.open("w") as output, eyes(domain) as seen:
        environment = os.environ | {"PYTHONPATH": str(ROOT), "ROS_DOMAIN_ID": str(domain)}
        flags = ("--swarm-size", "2", "--mission", "loading_route", "--goals-per-robot", "2",
                 "--until-done", "--speed", "1.5", "--headless", "--no-report")  # fmt: skip
        swarm = subprocess.Popen(
            (*call("swarm_up"), *flags, "--run-dir", "run"),
            env=environment, cwd=tmp_path, stdout=output, stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            end = time.monotonic() + LIMIT
            while len(seen.poses) < 2 or "active 2/2" not in log.read_text():
                assert swarm.poll() is None, log.read_text()
                assert time.monotonic() < end, log.read_text()
                seen.watch(0.2)
            hand = subprocess.Popen(
                (*call("teleop"), "Srobot1", "--speed", "1.0"),
                env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            )  # fmt: skip
            assert hand.stdout is not None
            assert hand.stdin is not None
            assert hand.stdout.readline() == "Srobot1 is yours\n"

            def press(key: str, period: float) -> None:
                hand.stdin.write(key)
                hand.stdin.flush()
                seen.watch(period)

            def turn_to(bearing: float) -> None:
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
            code = swarm.wait(LIMIT)
        finally:
            if swarm.poll() is None:
                swarm.terminate()
                swarm.wait(60.0)
    assert code == 0, log.read_text()
    report = json.loads((tmp_path / "run" / "report.json").read_text())
    assert report["goals"] == {"sent": 4, "reached": 4, "failed": 0, "pending": 0}
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert report["min_clearance"] is None or report["min_clearance"] > 0.0
