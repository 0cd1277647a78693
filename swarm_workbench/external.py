"""A robot that a node of one's own drives; the others know its pose, body and stopping space."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import numpy as np

from swarm_common.model.beacon import FLAG_STUCK, HEARD_ENTRIES, BeaconArray, serialize_beacon
from swarm_common.model.errors import SwarmError
from swarm_common.model.records import CONTROL_PERIOD, Odometry, Pose, RobotSpec, Scan, Twist
from swarm_common.model.robot_names import RobotNames
from swarm_common.process.signals import late_interrupt
from swarm_describe.robots.loading import load_robot
from swarm_nav.behaviour.plain import plain_beacon
from swarm_nav.core.config import NavConfig
from swarm_run.domain import domain_id

STOP_POINTS = 6  # of the path to standstill in a beacon
POLL_PERIOD = 0.2  # [s] of wall time between two looks whether to end


@dataclass(frozen=True, slots=True)
class Sensed:
    """Measurements of the robot at a tick."""

    tick: int
    time: float  # [s] of simulated time
    pose: Pose  # in map, by odometry from the start
    twist: Twist
    scan: Scan | None  # the latest
    neighbors: BeaconArray  # beacons heard in this tick
    goal: Pose | None = None  # in map, as `go_to` or RViz sent it last


Decide = Callable[[Sensed], Twist]


class ExternalRobot:
    """A robot of a running swarm, driven by a function of one's own, in lockstep.

    Name it in `external:` of a fleet file, or in `Swarm(external=[...])`. The function gets what
    the robot senses at each tick and returns the twist to drive.
    """

    def __init__(
        self,
        name: str,
        decide: Decide,
        *,
        domain: int | None = None,
        robot: str = "turtlebot3_waffle",
        number: int | None = None,
    ) -> None:
        """Describe it; `start` or the `with` block connects it.

        Args:
            decide: Returns the twist of each tick.
            domain: ROS domain of the swarm; None for that of the environment.
            number: From 1, in the order of the swarm; None for that in a name like `Srobot1`.

        Raises:
            SwarmError: If there is no such model.
        """
        self.name = name
        self.error: BaseException | None = None
        self._decide = decide
        self._domain = domain_id() if domain is None else domain
        self._spec = load_robot(robot)
        self._number = RobotNames().number_of(name) if number is None else number
        if self._number < 1:
            raise SwarmError(f"'{name}' does not tell the robot's number: give number=...")
        self._scan: Scan | None = None
        self._odom: dict[int, Odometry] = {}
        self._heard: dict[int, BeaconArray] = {}
        self._known: dict[int, int] = {}  # tick of the newest beacon, by robot
        self._goal: Pose | None = None
        self._truth: Odometry | None = None
        self._map_from_odom: Pose | None = None
        self._last: tuple[int, bytes, bytes] | None = None
        self._is_closed = False
        self._thread: threading.Thread | None = None

    def start(self) -> ExternalRobot:
        """Connect it, and answer ticks in a thread of its own.

        Raises:
            SwarmError: If it was started before.
        """
        if self._thread is not None:
            raise SwarmError("an ExternalRobot starts once; make another one")
        from swarm_run.command_line import prepare_ros

        prepare_ros()
        self._connect()
        self._thread = threading.Thread(target=self._spin, name=self.name, daemon=True)
        self._thread.start()
        return self

    def close(self) -> None:
        """Leave the swarm, for which the robot has died then.

        Raises:
            SwarmError: If its function had raised an error, which is the cause.
        """
        self._is_closed = True
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()
        if self.error is not None:
            raise SwarmError(f"{self.name} stopped: {self.error!r}") from self.error

    def __enter__(self) -> ExternalRobot:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @late_interrupt()
    def _connect(self) -> None:
        import rclpy
        from geometry_msgs.msg import PoseStamped, TwistStamped
        from nav_msgs.msg import Odometry as OdometryMsg
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.signals import SignalHandlerOptions
        from sensor_msgs.msg import LaserScan
        from swarm_interfaces.msg import Beacon, NeighborArray

        from swarm_common.middleware import cdr, ros_io

        self._context = Context()
        rclpy.init(
            context=self._context,
            domain_id=self._domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self._node: Any = rclpy.create_node(
            "navigator", namespace=f"/{self.name}", context=self._context, enable_rosout=False
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._reader = cdr.OdometryReader()
        self._writer = cdr.CommandWriter("base_footprint")
        self._beacon = self._node.create_publisher(Beacon, "beacon", ros_io.RELIABLE)
        self._command = self._node.create_publisher(TwistStamped, "cmd_vel", ros_io.RELIABLE)
        for kind, topic, take in (
            (OdometryMsg, "ground_truth", self._on_truth),
            (LaserScan, "scan", self._on_scan),
            (NeighborArray, "neighbors", self._on_neighbors),
            (OdometryMsg, "odom", self._on_odom),
        ):
            self._node.create_subscription(kind, topic, take, ros_io.TICK_INPUT, raw=True)
        self._node.create_subscription(PoseStamped, "goal_pose", self._on_goal, ros_io.RELIABLE)

    def _spin(self) -> None:
        try:
            while not self._is_closed and self._context.ok():
                self._executor.spin_once(timeout_sec=POLL_PERIOD)
        except BaseException as error:  # of `decide`; told by `close`
            self.error = error
        finally:
            self._executor.shutdown(timeout_sec=1.0)
            self._node.destroy_node()
            self._context.try_shutdown()

    # What is heard

    def _on_truth(self, data: bytes) -> None:
        """Learn where the odometry began; the truth counts for nothing else."""
        if self._map_from_odom is None:
            self._truth = self._reader.read(data)
            self._answer(self._truth.tick)

    def _on_goal(self, message: Any) -> None:
        from swarm_common.middleware.ros_io import pose_from_msg

        self._goal = pose_from_msg(message.pose)

    def _on_scan(self, data: bytes) -> None:
        from swarm_common.middleware.cdr import read_scan

        self._scan = read_scan(data)

    def _on_odom(self, data: bytes) -> None:
        odom = self._reader.read(data)
        self._odom = {tick: each for tick, each in self._odom.items() if tick >= odom.tick}
        self._odom[odom.tick] = odom
        self._answer(odom.tick)

    def _on_neighbors(self, data: bytes) -> None:
        from swarm_common.middleware.radio_check import read_neighbors

        tick, beacons, _ = read_neighbors(data, self._number)
        self._heard = {at: each for at, each in self._heard.items() if at >= tick}
        self._heard[tick] = beacons
        for robot, at in zip(beacons["id"].tolist(), beacons["tick"].tolist(), strict=True):
            self._known[robot] = max(self._known.get(robot, 0), at)
        self._answer(tick)

    # The answer

    def _answer(self, tick: int) -> None:
        """Answer a tick once all of it is there, and once more if it is asked for again."""
        if self._last is not None and self._last[0] == tick:
            self._send()
            return
        odom, heard = self._odom.get(tick), self._heard.get(tick)
        truth = self._truth
        if self._map_from_odom is None and truth is not None and truth.tick in self._odom:
            odom_from_base = self._odom[truth.tick].pose_odom
            self._map_from_odom = truth.pose_odom.compose(odom_from_base.inverse())
        if odom is None or heard is None or self._map_from_odom is None:
            return
        pose = self._map_from_odom.compose(odom.pose_odom)
        sensed = Sensed(
            tick, tick * CONTROL_PERIOD, pose, odom.twist, self._scan, heard, self._goal
        )
        twist = self._decide(sensed)
        beacon = compose_beacon(self._spec, self._number, sensed, self._known)
        self._last = tick, serialize_beacon(beacon), self._writer.encode(tick, twist)
        self._send()

    def _send(self) -> None:
        assert self._last is not None
        _, beacon, command = self._last
        self._beacon.publish(beacon)
        self._command.publish(command)


def compose_beacon(spec: RobotSpec, number: int, sensed: Sensed, known: dict[int, int]) -> np.void:
    """Return a beacon of a robot that makes way for nobody.

    Args:
        known: Tick of the newest beacon that it has of each robot.
    """
    pose, twist = sensed.pose, sensed.twist
    beacon = plain_beacon(number, sensed.tick, spec, pose, twist, is_driving=True)
    beacon["radius"] += NavConfig().traffic.safety_margin
    beacon["flags"] |= FLAG_STUCK
    points = stopping_path(spec, pose, twist)
    beacon["held_size"] = len(points)
    beacon["held"][: len(points)] = points
    newest = sorted(known.items(), key=lambda item: item[1])[-HEARD_ENTRIES:]
    heard = [robot << 16 | tick & 0xFFFF for robot, tick in newest]
    beacon["heard"][: len(heard)] = heard
    return beacon


def stopping_path(spec: RobotSpec, pose: Pose, twist: Twist) -> list[tuple[float, float]]:
    """Return points [map] from a pose to standstill, one tick of reaction included.

    Args:
        twist: Now; the robot may reach its largest speed within the tick of reaction, so the
            largest change of speed in a tick is added.
    """
    sign = -1.0 if twist.vx < 0.0 else 1.0
    speed = min(spec.max_vel_x, abs(twist.vx) + spec.acc_lim_x * CONTROL_PERIOD)
    length = speed * 2.0 * CONTROL_PERIOD + speed * speed / (2.0 * spec.acc_lim_x)
    curvature = twist.wz / speed if abs(twist.vx) > 0.05 else 0.0
    points, x, y, yaw = [(pose.x, pose.y)], pose.x, pose.y, pose.yaw
    step = sign * length / STOP_POINTS
    for _ in range(STOP_POINTS):
        yaw += 0.5 * curvature * abs(step)
        x, y = x + step * math.cos(yaw), y + step * math.sin(yaw)
        yaw += 0.5 * curvature * abs(step)
        points.append((x, y))
    return points
