"""Swarms of real processes from Python: goals, two in one program, and ends that leave nothing."""

import math
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import psutil
import pytest
import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.context import Context

from swarm_common.model.errors import SwarmError
from swarm_run.robots.swarm_watch import has_swarm
from swarm_workbench import ExternalRobot, Swarm, Trajectories, Twist
from tests.fakes.ros_domains import reserved_domain

END_LIMIT = 30.0  # [s] of wall time for processes to end, on a busy machine
TWO = """
import sys, time
from swarm_workbench import Swarm
with (
    Swarm(robots=1, drive="planar", run_dir=sys.argv[1] + "/a") as first,
    Swarm(robots=1, drive="planar", run_dir=sys.argv[1] + "/b") as second,
):
    first.run(seconds=0.5)
    second.run(seconds=0.2)
    print(first.time, second.time, flush=True)
    time.sleep(600)
"""


@pytest.fixture
def domain(monkeypatch):
    with reserved_domain() as reserved:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(reserved))
        yield reserved


def _processes(folder):
    return [
        process
        for process in psutil.process_iter(["cmdline"])
        if any(str(folder) in word for word in process.info["cmdline"] or ())
    ]


def _wait_until_gone(folder):
    end = time.monotonic() + END_LIMIT
    while left := _processes(folder):
        assert time.monotonic() < end, left
        time.sleep(0.2)


def _drive_and_fail(folder):
    """Use a swarm, lose its processes, and leave its block by an exception."""
    with Swarm(robots=2, drive="planar", run_dir=folder) as swarm:
        assert swarm.time == 0.0
        robot = swarm["Srobot1"]
        x, y = robot.true_pose.x, robot.true_pose.y
        swarm.run(until=1.0)
        goal = robot.go_to((x - 0.6, y))
        swarm.run(until=3.0)
        seen = swarm.true_poses
        assert goal.wait(timeout=60.0)
        assert abs(robot.true_pose.x - x + 0.6) < 0.26
        assert np.allclose(swarm.poses, swarm.true_poses, atol=0.05)
        assert robot.scan is not None
        assert swarm["Srobot2"].send("spin", {"target_yaw": 0.3}).wait(timeout=20.0)
        with pytest.raises(SwarmError, match="unknown action"):
            robot.send("fly", {})
        with pytest.raises(SwarmError, match="has no field 'yaw'"):
            robot.send("spin", {"yaw": 0.3})
        now = swarm.time
        time.sleep(0.3)
        assert swarm.time == now  # time stands still while nobody waits
        run = Trajectories.load(folder)
        assert run.times[-1] == pytest.approx(now)
        assert np.allclose(np.diff(run.times), 0.1)
        assert np.isfinite(swarm.trajectories.estimated[-1]).all()
        assert swarm.report.goals_reached == 1
        done = [(row[1], row[2]) for row in np.asarray(swarm.events).tolist()]
        assert done == [("Srobot1", "reached")]
        assert "driving" in [row[2] for row in np.asarray(swarm.states).tolist()]
        goal = robot.go_to("unload")
        child = next(p for p in _processes(folder) if "swarm_commander.cli.child" in p.cmdline())
        child.kill()
        start = time.monotonic()
        with pytest.raises(SwarmError, match="the swarm has ended"):
            goal.wait()
        with pytest.raises(SwarmError, match="the swarm has ended"):
            robot.go_to("unload")
        assert time.monotonic() - start < 5.0
        with Swarm(robots=2, bench=True) as bench:  # without ROS, all is the same
            bench.run(until=1.0)
            bench["Srobot1"].go_to((x - 0.6, y))
            bench.run(until=3.0)
            assert np.allclose(bench.true_poses, seen, atol=1e-5)
        raise ZeroDivisionError


def test_goals_over_ros_a_swarm_that_dies_and_an_exception(domain, tmp_path):
    with pytest.raises(ZeroDivisionError):
        _drive_and_fail(tmp_path / "run")
    _wait_until_gone(tmp_path)
    assert not has_swarm(domain)


class _PlainNode:
    """Drives a robot at a constant speed, by commands without a stamp, 20 times a second."""

    def __init__(self, domain, robot, speed):
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = rclpy.create_node("plain", context=self._context, enable_rosout=False)
        self._publisher = self._node.create_publisher(TwistStamped, f"/{robot}/cmd_vel", 10)
        self._message = TwistStamped()
        self._message.twist.linear.x = speed
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        while not self._end.wait(0.05):
            self._publisher.publish(self._message)

    def close(self):
        self._end.set()
        self._thread.join()
        self._node.destroy_node()
        self._context.try_shutdown()


def test_nodes_of_users_drive_robots_in_lockstep_or_without_stamps(domain, tmp_path):
    ticks, goals = [], set()

    def decide(seen):
        ticks.append(seen.tick)
        goals.add(seen.goal)
        return Twist(vx=0.1)

    options = {"robots": 3, "drive": "planar", "speed": 1.0, "run_dir": tmp_path / "run"}
    with Swarm(external=["Srobot1", "Srobot2"], **options) as swarm:
        plain = _PlainNode(swarm.domain, "Srobot2", 0.15)
        try:
            with ExternalRobot("Srobot1", decide, domain=swarm.domain):
                swarm.run(until=1.0)
                robot = swarm["Srobot1"]
                pose = robot.true_pose
                near = robot.go_to((pose.x + 0.35 * math.cos(pose.yaw), pose.y))
                far = robot.go_to((pose.x + 0.4 * math.cos(pose.yaw), pose.y))
                swarm.run(until=4.0)
                assert near.result.outcome == "canceled"
                assert far.result.outcome == "succeeded"
                assert far.pose in goals
                with pytest.raises(SwarmError, match="Srobot1 is external"):
                    robot.send("spin", {})
                with pytest.raises(SwarmError, match="no node takes goals on /Srobot2/goal_pose"):
                    swarm["Srobot2"].go_to("unload")
        finally:
            plain.close()
        run = swarm.trajectories
    assert ticks == list(range(41))  # each tick once, from the first on
    steps = np.hypot(*np.diff(run.true[20:, :2, :2], axis=0).transpose(2, 0, 1))
    assert steps[:, 0] == pytest.approx(0.01, abs=1e-3)
    assert steps[:, 1] == pytest.approx(0.015, abs=1e-3)  # no jerk
    assert np.allclose(run.estimated[20:, 0], run.true[20:, 0], atol=0.05)  # by its beacons
    assert swarm.report.full["external"] == ["Srobot1", "Srobot2"]
    assert swarm.report.full["broken"] == []
    _wait_until_gone(tmp_path)


def test_two_swarms_end_with_a_program_that_is_killed(domain, tmp_path):
    with subprocess.Popen(
        (sys.executable, "-c", TWO, str(tmp_path)), stdout=subprocess.PIPE, text=True
    ) as program:
        assert program.stdout.readline().split() == ["0.5", "0.2"]
        program.kill()
    _wait_until_gone(tmp_path)
    assert (tmp_path / "a" / "report.json").is_file()
    assert (tmp_path / "b" / "report.json").is_file()


def test_ctrl_c_during_the_start_leaves_nothing(domain, tmp_path):
    program = subprocess.Popen((sys.executable, "-c", TWO, str(tmp_path)), stderr=subprocess.PIPE)
    end = time.monotonic() + END_LIMIT
    while len(_processes(tmp_path)) < 2:  # the program, and the world
        assert time.monotonic() < end
        time.sleep(0.1)
    program.send_signal(signal.SIGINT)
    error = program.communicate(timeout=END_LIMIT)[1].decode()
    assert error.rstrip().endswith("KeyboardInterrupt")
    _wait_until_gone(tmp_path)
    assert not has_swarm(domain)


CELL = """
from swarm_workbench import Swarm
swarm = Swarm(robots=1, drive="planar", viewer=True, run_dir={folder!r}).start()
await swarm["Srobot1"].send("spin", {{"target_yaw": 0.2}})
swarm.show()
"""


def test_a_restarted_kernel_leaves_nothing(domain, tmp_path):
    pytest.importorskip("ipykernel")
    manager, client = pytest.importorskip("jupyter_client.manager").start_new_kernel()
    shown = []
    try:
        answer = client.execute_interactive(
            CELL.format(folder=str(tmp_path / "run")), timeout=120, output_hook=shown.append
        )
        assert answer["content"]["status"] == "ok", answer["content"]
        results = [m["content"]["data"] for m in shown if m["msg_type"] == "execute_result"]
        assert "<iframe" in results[-1]["text/html"]
        assert _processes(tmp_path)
        manager.restart_kernel(now=True)
        _wait_until_gone(tmp_path)
        assert (tmp_path / "run" / "report.json").is_file()
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)
