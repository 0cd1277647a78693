"""However `swarm-teleop` is ended, the robot is given back; and it notices the swarm's end."""

import os
import pty
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import rclpy
from geometry_msgs.msg import Twist
from nav2_msgs.action import AssistedTeleop
from rclpy.action import ActionServer
from rclpy.executors import MultiThreadedExecutor
from std_msgs.msg import Empty
from swarm_interfaces.msg import RobotStatus

from swarm_run.domain import DomainLock
from tests.graph.conftest import reserved_domain

ROOT = Path(__file__).resolve().parents[2]
CODE = "import sys; from swarm_commander.cli.main import teleop; sys.exit(teleop())"
LIMIT = 60.0  # [s] of wall time, on a busy machine


class Robot:
    """A robot that may be driven by hand, in a domain that a swarm has."""

    def __init__(self, domain):
        self.domain = domain
        self.lock = DomainLock(domain)
        self.is_given_back = threading.Event()
        rclpy.init(domain_id=domain)
        self._node = rclpy.create_node("navigator", namespace="Srobot1")
        for name in ("max_vel_x", "max_vel_theta"):
            self._node.declare_parameter(name, 0.2)
        status = self._node.create_publisher(RobotStatus, "status", 10)
        self._node.create_timer(0.5, lambda: status.publish(RobotStatus(robot="Srobot1")))
        self._node.create_subscription(Empty, "preempt_teleop", self._receive_end, 10)
        self._node.create_subscription(Twist, "cmd_vel_teleop", lambda _: None, 10)
        self._server = ActionServer(self._node, AssistedTeleop, "assisted_teleop", self._execute)
        self._executor = MultiThreadedExecutor(2)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._executor.spin, daemon=True)
        self._thread.start()

    def _receive_end(self, _):
        self.is_given_back.set()

    def _execute(self, goal):
        self.is_given_back.wait(LIMIT)
        goal.succeed()
        return AssistedTeleop.Result()

    def close(self):
        self.is_given_back.set()
        self.lock.release()
        time.sleep(0.2)  # for the goal to end
        self._executor.shutdown()
        self._thread.join(10.0)
        self._server.destroy()
        self._node.destroy_node()
        rclpy.shutdown()


@pytest.fixture
def robot():
    with reserved_domain() as domain:
        one = Robot(domain)
        yield one
        one.close()


def drive(robot, **streams):
    environment = os.environ | {"PYTHONPATH": str(ROOT), "ROS_DOMAIN_ID": str(robot.domain)}
    command = (sys.executable, "-c", CODE, "Srobot1")
    return subprocess.Popen(command, env=environment, **streams)


def read_until(descriptor, sign):
    text, end = b"", time.monotonic() + LIMIT
    while sign not in text:
        assert time.monotonic() < end, text
        text += os.read(descriptor, 4096)
    return text


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_gives_the_robot_back(robot, number):
    process = drive(robot, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    read_until(process.stdout.fileno(), b"Srobot1 is yours")
    process.send_signal(number)
    text, _ = process.communicate(timeout=LIMIT)
    assert b"Srobot1 is on its own again" in text
    assert robot.is_given_back.is_set()
    assert process.returncode == 0


def test_a_closed_terminal_gives_the_robot_back(robot):
    outer, inner = pty.openpty()
    process = drive(
        robot, stdin=inner, stdout=inner, stderr=subprocess.DEVNULL, start_new_session=True
    )
    os.close(inner)
    read_until(outer, b"Srobot1 is yours")
    os.close(outer)
    assert process.wait(LIMIT) == 0
    assert robot.is_given_back.is_set()


def test_the_end_of_the_swarm_ends_it(robot):
    with drive(
        robot, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        read_until(process.stdout.fileno(), b"Srobot1 is yours")
        robot.lock.release()
        assert process.wait(10.0) == 3
        assert b"the swarm has ended" in process.stderr.read()
