"""A process for each robot, as `swarm-up` starts them; this process sees them over ROS.

The world is paused, and makes as many steps as `advance` wants. One thread spins our node and does
all that concerns ROS; others hand it what to do.
"""

from __future__ import annotations

import atexit
import contextlib
import importlib.util
import json
import math
import os
import pickle
import queue
import signal
import socket
import subprocess
import tempfile
import threading
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from msgspec import structs

from swarm_common.files.map_io import MAP_FILE, load_map
from swarm_common.model.breaches import Collision
from swarm_common.model.errors import ConfigError, SwarmEndedError, SwarmError, UnknownNameError
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose, RobotSpec, Scan
from swarm_common.process import start
from swarm_common.process.signals import late_interrupt
from swarm_run.domain import HIGHEST_DOMAIN, DomainLock, domain_id
from swarm_run.plan import check_plan
from swarm_run.spec import LOOPBACK, VIEWER_PORT, RunSpec
from swarm_workbench.bench import figures_of
from swarm_workbench.goal import Goal
from swarm_workbench.history import RunTables
from swarm_workbench.report import Report
from swarm_workbench.trajectories import Trajectories

START_LIMIT = 600.0  # [s] of wall time; the first start of all compiles
ANSWER_LIMIT = 5.0  # [s] of wall time for a service or an action to be found, and to answer
END_LIMIT = 40.0  # [s] of wall time for the processes to end and to write their report
LOOK_PERIOD = 0.2  # [s] of wall time between two looks for overdue answers
NODE_LIMIT = 20.0  # [s] of wall time for the nodes of external robots to appear
REACHED = 0.25  # [m] of an external robot from its goal
LATELY = 5  # ticks without an answer after which a robot may have died
LOG_FILE = "console.log"
OUTCOMES = {"SUCCEEDED": "succeeded", "CANCELED": "canceled", "FAILED": "aborted"}
T = TypeVar("T")
_running: weakref.WeakSet[GraphBackend] = weakref.WeakSet()


class GraphBackend:
    """A swarm of real processes in a ROS domain of its own.

    Attributes:
        domain: ROS domain id.
        url: Address of the viewer; empty without one.
    """

    def __init__(self, spec: RunSpec) -> None:
        """Start it, and wait until every robot takes goals; the world stands at tick 0.

        Raises:
            SwarmError: If something is unusable or does not start; nothing is left running.
        """
        if importlib.util.find_spec("rclpy") is None:
            raise SwarmError(
                "this Python has no rclpy, which processes need: pip install"
                " 'ros-jazzy-rclpy[fastrtps]', or use Swarm(bench=True)"
            )
        from swarm_run.command_line import prepare_ros

        self.folder: Path | None = None
        spec = structs.replace(
            spec,
            port=_free_port() if spec.viewer else VIEWER_PORT,
            open=False,
            paused=True,
            report=False,
        )
        plan = check_plan(spec)
        prepare_ros()
        self.folder = self._folder = _new_folder(spec.run_dir)
        spec = structs.replace(spec, run_dir=str(self._folder))
        self.url = f"http://{LOOPBACK}:{spec.port}" if spec.viewer else ""
        self.sites = plan.sites
        self._external = spec.driven_by_users
        self.names: Sequence[str] = spec.robot_names
        self.specs: Sequence[RobotSpec] = [member.spec for member in plan.fleet.members]
        self._is_closed = False
        self._console = tempfile.TemporaryFile()
        self._child: subprocess.Popen[bytes] | None = None
        self._view: _View | None = None
        self.domain: int | None
        self.domain, lock = _claim_domain()
        _running.add(self)
        try:
            try:
                self._child = self._start_child(spec, lock)
            finally:
                lock.release()  # the child has it
            self.history = self._see().history
            self._wait_until_active(plan.alive)
            self.grid = load_map(self._folder / "trace" / MAP_FILE)
        except BaseException:
            self.close()
            raise

    def _see(self) -> _View:
        with late_interrupt():
            self._view = _View(self.domain or 0, self.names)
        return self._view

    # Processes

    def _start_child(self, spec: RunSpec, lock: DomainLock) -> subprocess.Popen[bytes]:
        child = subprocess.Popen(
            start.command("swarm_commander.cli.child", str(self._folder), str(lock.fileno())),
            pass_fds=(lock.fileno(),),
            stdin=subprocess.PIPE,
            stdout=self._console,
            stderr=subprocess.STDOUT,
            env=os.environ | {"ROS_DOMAIN_ID": str(self.domain)},
            start_new_session=True,  # Ctrl-C is ours; the child ends when we close it, or are gone
        )
        assert child.stdin is not None
        child.stdin.write(pickle.dumps(spec))
        child.stdin.flush()
        return child

    def _wait_until_active(self, alive: Sequence[str]) -> None:
        view = self._checked_view()
        deadline = time.monotonic() + START_LIMIT
        view.alive = numbers = [self.names.index(name) for name in alive]
        while not view.do(lambda: all(map(view.is_active, numbers))):
            self._check_child()
            if time.monotonic() > deadline:
                raise SwarmError(f"the robots did not become active within {START_LIMIT:g} s")
            time.sleep(0.05)

    def _check_child(self) -> None:
        """Raise an error if the processes have ended."""
        if self._is_closed or self._child is None:
            raise SwarmEndedError
        code = self._child.poll()
        if code is not None:
            lines = self._said()
            raise SwarmError(f"the swarm has ended with exit code {code}: {lines}")

    def _said(self) -> str:
        self._console.seek(0)
        lines = self._console.read().decode(errors="replace").split("\n")
        last = [line.strip() for line in lines if line.strip()]
        told = [line for line in last if line.startswith("swarm-up:")]
        return (told or last or ["it has said nothing"])[-1].removeprefix("swarm-up: ")

    def _checked_view(self) -> _View:
        if self._view is None:
            raise SwarmEndedError
        return self._view

    # Time

    @property
    def tick(self) -> int:
        """Control ticks since the start."""
        return self._checked_view().tick

    def advance(self, ticks: int) -> None:
        """Let time pass."""
        self._check_child()
        view = self._checked_view()
        target = view.tick + ticks
        step = view.do(partial(view.step, ticks))
        patience = time.monotonic() + NODE_LIMIT
        while not view.has_reached(target, step):
            self._check_child()
            if view.tick == 0 and self._external and time.monotonic() > patience:
                raise SwarmError(
                    f"time does not begin: no node drives {' or '.join(self._external)}; start an"
                    " ExternalRobot in this ROS domain"
                )
            view.changed.wait(LOOK_PERIOD)
            view.changed.clear()
        end = time.monotonic() + ANSWER_LIMIT
        while not view.has_answers(target, ticks) and time.monotonic() < end:
            view.changed.wait(LOOK_PERIOD)
            view.changed.clear()
        view.tick = target

    # Robots

    def true_poses(self) -> FloatArray:
        """Return x, y [m], yaw [rad] in map of each robot (n, 3)."""
        return self._checked_view().true_poses()

    def estimated_poses(self) -> FloatArray:
        """Return likewise what the robots believe; before its first beacon, where one started."""
        return self._checked_view().estimated_poses()

    def scan(self, robot: int) -> Scan | None:
        """Return a robot's latest scan."""
        return self._checked_view().scan(robot)

    def status(self, robot: int) -> Any:
        """Return a robot's status, a swarm_interfaces/RobotStatus."""
        return self._checked_view().statuses[robot]

    def drive(self, robot: int, goal: Goal, pose: Pose) -> None:
        """Send a robot to a pose in map; return when it has taken the goal.

        An external one gets it on `goal_pose`, and has reached it where its truth is near.
        """
        from nav2_msgs.action import NavigateToPose

        from swarm_common.middleware.ros_io import pose_stamped

        if goal.robot in self._external:
            view = self._checked_view()
            stamped = pose_stamped(pose, view.tick)
            self._wait_for(
                lambda: view.do(partial(view.lead, robot, goal, stamped)),
                f"no node takes goals on /{goal.robot}/goal_pose: start an ExternalRobot first",
            )
            return
        message = NavigateToPose.Goal(pose=pose_stamped(pose, 0))
        self._send(robot, goal, NavigateToPose, message)

    def send(self, robot: int, goal: Goal, fields: Mapping[str, Any] | Any) -> None:
        """Send a goal of any of Nav2's actions."""
        from nav2_msgs import action

        from swarm_ros2.text import fill

        kinds = {_snake(name): getattr(action, name) for name in dir(action) if name[0].isupper()}
        if goal.action not in kinds:
            raise UnknownNameError("action", goal.action, kinds)
        kind = kinds[goal.action]
        message = fields
        if isinstance(fields, Mapping):
            message = kind.Goal()
            try:
                fill(message, dict(fields))
            except SwarmError as error:
                raise ConfigError(f"{goal.action} of {goal.robot}: {error}") from None
        if not isinstance(message, kind.Goal):
            raise ConfigError(
                f"{goal.action} of {goal.robot}: expected fields or a {kind.__name__}.Goal, not a"
                f" {type(message).__name__}"
            )
        self._send(robot, goal, kind, message)

    def _send(self, robot: int, goal: Goal, kind: Any, message: Any) -> None:
        self._check_child()
        view = self._checked_view()
        if robot not in view.alive:
            raise ConfigError(f"{goal.robot} is external: its node takes go_to only, on goal_pose")
        task = view.do(partial(view.send, robot, goal, kind, message))
        self._wait_for(
            lambda: task.is_accepted,
            f"{goal.robot} does not answer: its navigator hangs, or is down",
        )

    def _wait_for(self, is_done: Callable[[], bool], otherwise: str) -> None:
        """Wait for wall time to pass; raise an error if that takes too long."""
        deadline = time.monotonic() + ANSWER_LIMIT
        self._check_child()
        while not is_done():
            self._check_child()
            if time.monotonic() > deadline:
                raise SwarmError(otherwise)
            time.sleep(0.01)

    def cancel(self, robot: int, goal: Goal) -> None:
        """Cancel a robot's goal."""
        self._check_child()
        view = self._checked_view()
        view.do(partial(view.cancel, robot, goal))

    def fail(self, robot: int) -> None:
        """Refuse; processes die in their own ways."""
        raise ConfigError(
            f"fail() of {self.names[robot]} is for the bench; here, end its process with kill"
        )

    # Results

    def report(self) -> Report:
        """Return the figures so far; after the end, those of report.json."""
        view = self._checked_view()
        full = _read_json(self._folder / "report.json") if self._is_closed else {}
        world = view.verdict
        counts = full.get("collisions", {})
        least = full.get("min_clearance", world.min_clearance if world else None)
        return Report(
            sim_time=full.get("sim_time") or view.tick * CONTROL_PERIOD,
            robot_robot=counts.get("robot_robot") or (world.collisions_robot_robot if world else 0),
            robot_world=counts.get("robot_world") or (world.collisions_robot_world if world else 0),
            near_misses=full.get("near_misses") or (world.near_misses if world else 0),
            min_clearance=math.inf if least is None else least,
            robots=[
                figures_of(name, status)
                for name, status in zip(self.names, view.statuses, strict=True)
            ],
            full=full,
        )

    def collisions(self) -> Sequence[Collision]:
        """Return the contact episodes of verdict.json, which is there after the end."""
        found = _read_json(self._folder / "config" / "verdict.json").get("collisions", [])
        return [Collision.from_json(each) for each in found]

    def trajectories(self) -> Trajectories:
        """Return where every robot was at each tick so far."""
        run = Trajectories.load(self._folder)
        believed = self._checked_view().believed
        for index, name in enumerate(run.names):
            if name not in self.names:
                continue
            known = dict(believed[self.names.index(name)])
            for row, tick in enumerate(np.rint(run.times / CONTROL_PERIOD).astype(int).tolist()):
                if tick in known:
                    run.estimated[row, index] = known[tick]
        return run

    def close(self) -> None:
        """End all processes, and leave the ROS graph."""
        if self._is_closed:
            return
        self._is_closed = True
        child = self._child
        if self._view is not None:
            self._view.is_ending = True
        try:
            if child is not None:
                _end(child)
        finally:
            if self._view is not None:
                self._view.close()
            with contextlib.suppress(OSError):
                self._console.seek(0)
                (self._folder / LOG_FILE).write_bytes(self._console.read())
            self._console.close()


class _View:
    """View of one node on a swarm; its own thread spins it.

    Attributes:
        alive: Indices of the robots that have a navigator of ours.
        tick: Tick that the world has reached, as `GraphBackend.advance` knows it.
        changed: Set when something was heard.
        statuses: Latest of each robot; idle before the first.
        history: History of all statuses, in the order of arrival.
        believed: Tick and pose of each beacon, per robot.
        verdict: Latest swarm_interfaces/Verdict.
        is_ending: Whether the swarm is about to be ended by us.
    """

    def __init__(self, domain: int, names: Sequence[str]) -> None:
        import rclpy
        from nav_msgs.msg import Odometry
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.signals import SignalHandlerOptions
        from sensor_msgs.msg import LaserScan
        from simulation_interfaces.srv import StepSimulation
        from swarm_interfaces.msg import Beacon, RobotStatus, Verdict

        from swarm_common.middleware import ros_io
        from swarm_common.middleware.cdr import OdometryReader
        from swarm_run.robots.client import RobotCommander

        self.tick = 0
        self.alive: Sequence[int] = ()
        self.changed = threading.Event()
        self.verdict: Any = None
        self.statuses: list[Any] = [RobotStatus(robot=name, state="idle") for name in names]
        self.history = RunTables(names)
        self.believed: list[list[tuple[int, tuple[float, float, float]]]] = [[] for _ in names]
        self._truth: list[bytes] = [b""] * len(names)
        self._scans: list[bytes] = [b""] * len(names)
        self._reader = OdometryReader()
        self._led: dict[int, Goal] = {}  # goals of external robots
        self._leads: dict[int, Any] = {}  # their publishers
        self._jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.is_ending = self._is_closed = False
        self._context = Context()
        rclpy.init(
            context=self._context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
        )
        self._node = node = rclpy.create_node(
            "workbench", context=self._context, enable_rosout=False, start_parameter_services=False
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(node)
        self._guard = node.create_guard_condition(self._work)
        self._steps = node.create_client(StepSimulation, "/sim/step_simulation")
        self._robots = [
            RobotCommander(node, name, partial(self._on_status, index), with_feedback=False)
            for index, name in enumerate(names)
        ]
        node.create_subscription(Verdict, "/sim/verdict", self._on_verdict, ros_io.RELIABLE)
        for index, name in enumerate(names):
            for kind, topic, take, quality in (
                (Odometry, "ground_truth", self._on_truth, ros_io.RELIABLE),
                (LaserScan, "scan", self._on_scan, ros_io.SENSOR),
                (Beacon, "beacon", self._on_beacon, ros_io.RELIABLE),
            ):
                node.create_subscription(
                    kind, f"/{name}/{topic}", partial(take, index), quality, raw=True
                )
        self._thread = threading.Thread(target=self._spin, name="swarm_workbench", daemon=True)
        self._thread.start()

    # The thread that spins

    def _spin(self) -> None:
        due = 0.0
        while not self._is_closed and self._context.ok():
            try:
                self._executor.spin_once(timeout_sec=LOOK_PERIOD)
            except Exception as error:  # of one message; the others count
                self._node.get_logger().error(f"{error!r}")
            now = time.monotonic()
            if now > due and not self.is_ending:  # who ends is not told that all have ended
                due = now + LOOK_PERIOD
                for robot in self._robots:
                    robot.look()

    def _work(self) -> None:
        with contextlib.suppress(queue.Empty):
            while True:
                self._jobs.get_nowait()()

    def do(self, job: Callable[[], T]) -> T:
        """Do something in the thread that spins; return what it returns.

        Raises:
            SwarmEndedError: If that thread has ended.
        """
        answer: queue.SimpleQueue[tuple[Any, BaseException | None]] = queue.SimpleQueue()

        def work() -> None:
            try:
                answer.put((job(), None))
            except BaseException as error:  # it is raised where it was asked for
                answer.put((None, error))

        self._jobs.put(work)
        self._guard.trigger()
        while self._thread.is_alive():
            with contextlib.suppress(queue.Empty):
                value, error = answer.get(timeout=LOOK_PERIOD)
                if error is not None:
                    raise error
                done: T = value
                return done
        raise SwarmEndedError

    def step(self, ticks: int) -> Any:
        """Ask for ticks; return the future of the answer."""
        from simulation_interfaces.srv import StepSimulation

        return self._steps.call_async(StepSimulation.Request(steps=ticks))

    def has_reached(self, target: int, step: Any) -> bool:
        """Whether every robot was seen at a tick.

        Raises:
            SwarmError: If the world refuses the steps.
        """
        answer = step.result() if step.done() else None
        if answer is not None and answer.result.error_message:
            raise SwarmError(f"the world does not go on: {answer.result.error_message}")
        return answer is not None and all(_tick_in(data) >= target for data in self._truth if data)

    def has_answers(self, target: int, ticks: int) -> bool:
        """Whether the answers to a tick were heard of all robots that have answered lately."""
        newest = [each[-1][0] for each in self.believed if each]
        return all(tick >= target for tick in newest if tick >= target - ticks - LATELY)

    def send(self, robot: int, goal: Goal, kind: Any, message: Any) -> Any:
        """Send a goal; return its task."""

        def end(task: Any) -> None:
            goal.settle(OUTCOMES.get(task.outcome.name, "aborted"), task.reason, self._heard())
            self.changed.set()

        return self._robots[robot].send(goal.action, kind, message, on_end=end)

    def lead(self, robot: int, goal: Goal, message: Any) -> bool:
        """Tell an external robot where to go; return False while nobody listens."""
        from geometry_msgs.msg import PoseStamped

        from swarm_common.middleware.ros_io import RELIABLE

        if robot not in self._leads:
            topic = f"/{goal.robot}/goal_pose"
            self._leads[robot] = self._node.create_publisher(PoseStamped, topic, RELIABLE)
        if not self._leads[robot].get_subscription_count():
            return False
        if robot in self._led:
            self._led[robot].settle("canceled", "preempted by a new goal", self._heard())
        self._led[robot] = goal
        self._leads[robot].publish(message)
        return True

    def cancel(self, robot: int, goal: Goal) -> None:
        """Cancel a robot's goal; an external robot is sent to where it is."""
        if self._led.get(robot) is not goal:
            self._robots[robot].cancelTask()
            return
        from swarm_common.middleware.ros_io import pose_stamped

        pose = Pose(*self.true_poses()[robot].tolist())
        self._leads[robot].publish(pose_stamped(pose, self.tick))
        del self._led[robot]
        goal.settle("canceled", "canceled", self._heard())

    def _heard(self) -> int:
        return max((_tick_in(data) for data in self._truth if data), default=self.tick)

    # What is heard

    def _on_status(self, index: int, message: Any) -> None:
        self.statuses[index] = message
        at = round(message.stamp.sec + 1e-9 * message.stamp.nanosec, 3)
        self.history.note(message.robot, message, at)
        self.changed.set()

    def _on_verdict(self, message: Any) -> None:
        self.verdict = message

    def _on_truth(self, index: int, data: bytes) -> None:
        self._truth[index] = data
        goal = self._led.get(index)
        if goal is not None and goal.pose is not None:
            if self._reader.read(data).pose_odom.distance(goal.pose) < REACHED:
                del self._led[index]
                goal.settle("succeeded", "", _tick_in(data))
        self.changed.set()

    def _on_scan(self, index: int, data: bytes) -> None:
        self._scans[index] = data

    def _on_beacon(self, index: int, data: bytes) -> None:
        from swarm_common.model.beacon import deserialize_beacon

        beacon = deserialize_beacon(data)
        x, y, yaw = beacon["pose"].tolist()
        self.believed[index].append((int(beacon["tick"]), (x, y, yaw)))
        self.changed.set()

    def is_active(self, robot: int) -> bool:
        """Whether a robot takes goals, and its truth is seen."""
        return bool(self._truth[robot]) and self._robots[robot].isReady()

    def true_poses(self) -> FloatArray:
        """Return the true poses (n, 3); NaN of a robot that was not seen."""
        poses = np.full((len(self._truth), 3), np.nan)
        for index, data in enumerate(self._truth):
            if data:
                pose = self._reader.read(data).pose_odom
                poses[index] = pose.x, pose.y, pose.yaw
        return poses

    def estimated_poses(self) -> FloatArray:
        """Return the estimated poses (n, 3); the true one of a robot that was not heard."""
        poses = self.true_poses()
        for index, each in enumerate(self.believed):
            if each:
                poses[index] = each[-1][1]
        return poses

    def scan(self, robot: int) -> Scan | None:
        """Return the latest scan."""
        from swarm_common.middleware.cdr import read_scan

        data = self._scans[robot]
        return read_scan(data) if data else None

    def close(self) -> None:
        """Leave the ROS graph."""
        self._is_closed = True
        self._thread.join(ANSWER_LIMIT)
        self._executor.shutdown(timeout_sec=1.0)
        with contextlib.suppress(Exception):  # the swarm may be half gone
            self._node.destroy_node()
        self._context.try_shutdown()


def _tick_in(data: bytes) -> int:
    from swarm_common.middleware.cdr import read_tick

    return read_tick(data)


def _snake(name: str) -> str:
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")


def _new_folder(chosen: str | None) -> Path:
    """Return the folder of a run; a new one of its own in runs/ unless it is chosen."""
    if chosen is not None:
        return Path(chosen).absolute()
    name, number = datetime.now().strftime("%Y-%m-%d_%H-%M-%S"), 1
    path = Path("runs").absolute() / name
    while path.exists():
        number += 1
        path = path.with_name(f"{name}-{number}")
    try:
        path.mkdir(parents=True)
    except OSError as error:
        raise ConfigError(
            f"cannot write the run folder {path}: {error.strerror}; choose another with run_dir=…"
        ) from None
    return path


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


def _claim_domain() -> tuple[int, DomainLock]:
    """Claim a ROS domain without a swarm, the user's own if it is free."""
    first = domain_id()
    for offset in range(HIGHEST_DOMAIN + 1):
        domain = (first + offset) % (HIGHEST_DOMAIN + 1)
        with contextlib.suppress(ConfigError):
            return domain, DomainLock(domain)
    raise SwarmError("every ROS domain of this machine has a swarm; close one")


def _end(child: subprocess.Popen[bytes]) -> None:
    """End the processes as Ctrl-C does; kill what does not end."""
    if child.stdin is not None:
        with contextlib.suppress(OSError):
            child.stdin.close()
    try:
        child.wait(END_LIMIT)
    except subprocess.TimeoutExpired:
        child.send_signal(signal.SIGINT)  # a second one kills the others
        try:
            child.wait(END_LIMIT / 4)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()


def _read_json(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


@atexit.register
def _close_all() -> None:
    for backend in list(_running):
        backend.close()
