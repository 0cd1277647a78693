"""One robot's topics on the side of the world."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist as TwistMsg
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry as OdometryMsg
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import BatteryState, JointState, LaserScan
from sensor_msgs.msg import Imu as ImuMsg
from std_msgs.msg import String
from swarm_interfaces.msg import Beacon, NeighborArray
from tf2_msgs.msg import TFMessage

from swarm_common.middleware import cdr, ros_io
from swarm_common.middleware.radio_check import read_beacon
from swarm_common.middleware.rclpy_compat import removable_publisher
from swarm_common.middleware.rejections import RejectedError
from swarm_common.middleware.ros_poll import PolledTopic, SoleTopic
from swarm_common.model.beacon import serialize_neighbors
from swarm_common.model.records import CONTROL_PERIOD, Pose, RobotSpec, Twist, stamp_from_tick
from swarm_common.model.sensors import IDEAL, SensorErrors
from swarm_sim.ros.robots.foreign import NAVIGATOR, Foreigners
from swarm_sim.ros.robots.frames import Joint, fixed_transforms, moving_transforms, read_joints
from swarm_sim.ros.robots.round_trip import LEAST, RoundTrip
from swarm_sim.ros.settings import Settings
from swarm_sim.sensing.drift import Drift
from swarm_sim.sensing.motion_sensors import Imu
from swarm_sim.world.world import Observation

BASE = "base_footprint"
IMU_FRAME = "imu_link"
# [s] before an answer is asked for again on one host, at least and at most: no link there comes and
# goes, but what others send may push a message out of a queue.
LOCAL_LIMITS = 0.25, 0.4
NEWCOMER_REPEATS = 4  # for one side of a topic may know the other earlier than the reverse


class RobotLink:
    """Publishes what a robot senses and collects what it answers.

    Attributes:
        command: Twist of the answer to the present tick, None until it is there.
        beacon: Beacon of that answer.
        newest_tick: Newest tick that a command of the robot has answered.
        is_gone: Whether the robot was taken out of the world.
        trip: Round trip of its answers.
    """

    def __init__(
        self,
        node: Node,
        gallery: Node,
        name: str,
        spec: RobotSpec,
        urdf: str,
        settings: Settings,
        robot_id: int,
        on_answer: Callable[[], None],
        foreigners: Foreigners,
        errors: SensorErrors,
        is_external: bool = False,
    ) -> None:
        """Create the topics of `/name`.

        Args:
            robot_id: Id that the robot's beacons must have; 0 for any.
            on_answer: Called when command and beacon of the present tick are both there.
            foreigners: Receives what is not the robot's, and what makes no sense.
            is_external: Whether a node of the user drives it, which may send commands without the
                stamp of a tick; then nobody waits for it.
        """
        self.name = name
        self.is_gone = False
        self.newest_tick = -1
        self.command: Twist | None = None
        self.beacon: np.void | None = None
        self._robot_id = robot_id
        self.trip = RoundTrip(*LOCAL_LIMITS)
        self._on_answer = on_answer
        self._foreigners = foreigners
        self._listeners = 0
        self._repeats_due = 0
        self._is_free_run = settings.free_run
        self._is_external = is_external
        self._last_truth: tuple[int, bytes] = (-1, b"")  # tick and message
        self.is_unstamped = False  # whether it drives without regard to ticks
        self._has_beacon = not is_external  # whether its answers have one
        self._tick = 0
        self._published = -1  # tick
        self._other: Twist | None = None
        self._joints: list[Joint] = read_joints(urdf)
        self._odom_writer = cdr.OdometryWriter("odom", BASE)
        self._drift = Drift(errors, spec)
        self._drifts = errors != IDEAL
        self._odom_writer.set_variances(self._drift.of_pose, self._drift.of_twist)
        self._truth_writer = cdr.OdometryWriter("map", BASE)
        self._scan_writer = cdr.ScanWriter("base_scan", spec.lidar.period_ticks * CONTROL_PERIOD)
        self._supply = spec.battery
        self._create_publishers(node, gallery, f"/{name}")
        self._description.publish(String(data=urdf))
        self._tf_static.publish(TFMessage(transforms=fixed_transforms(self._joints)))
        kind: Any = TwistStamped if settings.cmd_vel_stamped else TwistMsg
        self._command_reader = cdr.CommandReader()
        self._read_command = (
            self._receive_stamped if settings.cmd_vel_stamped else self._receive_plain
        )
        self._commands = self._subscribe(node, kind, "cmd_vel")
        self._beacons = self._subscribe(node, Beacon, "beacon")
        self._truth_viewers = 0
        self.poll_viewers()

    def _create_publishers(self, node: Node, gallery: Node, space: str) -> None:
        make = partial(removable_publisher, node)
        self._odom = make(OdometryMsg, f"{space}/odom", ros_io.RELIABLE)
        self._scan = make(LaserScan, f"{space}/scan", ros_io.SCAN)
        self._neighbors: Publisher | None = make(
            NeighborArray, f"{space}/neighbors", ros_io.RELIABLE
        )
        show = partial(removable_publisher, gallery)
        self._truth = show(OdometryMsg, f"{space}/ground_truth", ros_io.RELIABLE)
        self._joint_states = show(JointState, f"{space}/joint_states", ros_io.RELIABLE)
        self._imu = show(ImuMsg, f"{space}/imu", ros_io.RELIABLE)
        self._tf = show(TFMessage, f"{space}/tf", ros_io.TRANSFORMS)
        self._tf_static = show(TFMessage, f"{space}/tf_static", ros_io.STATIC_TRANSFORMS)
        self._description = show(String, f"{space}/robot_description", ros_io.LATCHED)
        self._battery = None
        sensed = [self._odom, self._scan, self._neighbors]
        if self._supply is not None:
            self._battery = make(BatteryState, f"{space}/{ros_io.BATTERY}", ros_io.RELIABLE)
            sensed.append(self._battery)
        shown = (
            self._truth,
            self._joint_states,
            self._imu,
            self._tf,
            self._tf_static,
            self._description,
        )
        self._publishers = [(node, sensed), (gallery, [*shown])]

    def move_out(self) -> None:
        """Record that the navigator is on another host: its beacons go there in a batch."""
        self.trip = RoundTrip(LEAST)
        if self._neighbors is not None and not self.is_gone:
            node, publishers = self._publishers[0]
            publishers.remove(self._neighbors)
            node.destroy_publisher(self._neighbors)
            self._neighbors = None

    def _subscribe(self, node: Node, kind: Any, name: str) -> SoleTopic:
        """Listen to the robot's navigator; in free run to any node of the robot, or any other.

        Another commander, for manual driving, would be another rightful node.
        """
        topic, navigator = f"/{self.name}/{name}", f"/{self.name}/{NAVIGATOR}"
        own, is_free_run = f"/{self.name}/", self._is_free_run
        return SoleTopic(
            node,
            kind,
            topic,
            ros_io.TICK_INPUT,
            lambda who: who.startswith(own) if is_free_run else who == navigator,
            lambda who: self._foreigners.ignore(topic, who),
            is_shared=is_free_run,
        )

    def poll_viewers(self) -> bool:
        """See which topics for viewers have a subscriber; return whether the truth has more.

        The truth of the present tick is published again for them.
        """
        if self.is_gone:
            return False
        before, self._truth_viewers = self._truth_viewers, self._truth.get_subscription_count()
        self.wants_truth = self._truth_viewers > 0
        self.wants_imu = self._imu.get_subscription_count() > 0
        self.wants_joints = self._joint_states.get_subscription_count() > 0
        self.wants_tf = self._tf.get_subscription_count() > 0
        return self._truth_viewers > before

    def destroy(self) -> None:
        """Withdraw all topics: the robot is not there any more."""
        self.is_gone = True
        self.command = self._other = None
        self.beacon = None
        self.wants_truth = self.wants_joints = self.wants_tf = self.wants_imu = False
        for topic in (self._commands, self._beacons):
            topic.destroy()
        for node, publishers in self._publishers:
            for publisher in publishers:
                node.destroy_publisher(publisher)

    def open(self, tick: int) -> None:
        """Begin a tick: forget the last answer."""
        self._tick = tick
        self.command = self._other = None
        self.beacon = None

    def publish(self, observation: Observation) -> None:
        """Publish what the robot senses at the present tick; may be repeated."""
        if self.is_gone:
            return
        odom, scan = observation.odom, observation.scan
        if self._drifts and odom.tick > self._published:
            self._published = odom.tick
            self._drift.add(odom.twist)
            self._odom_writer.set_variances(self._drift.of_pose, self._drift.of_twist)
        self._odom.publish(self._odom_writer.encode(odom.tick, odom.pose_odom, odom.twist))
        if scan is not None:
            self._scan.publish(self._scan_writer.encode(scan))
        if observation.battery is not None and self._battery is not None:
            assert self._supply is not None
            message = ros_io.battery_message(observation.battery, self._supply)
            self._battery.publish(message)
        if self._is_external and self._last_truth[0] == odom.tick:  # it may have missed this, too
            self._truth.publish(self._last_truth[1])
        if self._neighbors is not None:
            stamp = stamp_from_tick(odom.tick)
            self._neighbors.publish(serialize_neighbors(*stamp, observation.neighbors))

    def is_newcomer(self) -> bool:
        """Whether somebody listens since few calls ago: what it was sent first may be lost."""
        listeners = 0 if self.is_gone else self._odom.get_subscription_count()
        self._repeats_due = NEWCOMER_REPEATS if listeners > self._listeners else self._repeats_due
        self._listeners = listeners
        self._repeats_due -= 1
        return self._repeats_due >= 0

    @property
    def has_answered(self) -> bool:
        """Whether the whole answer to the present tick is there."""
        return self.command is not None and (self.beacon is not None or not self._has_beacon)

    @property
    def lag(self) -> int:
        """Ticks by which the newest answer is behind."""
        return self._tick - self.newest_tick

    @property
    def awaited(self) -> PolledTopic:
        """Topic on which the rest of the answer comes; robots send the command last."""
        return self._commands if self.command is None else self._beacons

    def receive_answers(self) -> None:
        """Receive what the robot has sent; in lockstep no more than its answer."""
        if self.is_gone:
            return
        while self.command is None or self._is_free_run:
            if (data := self._commands.take()) is None:
                break
            self._pass("cmd_vel", self._read_command, data)
        if self.command is None and not self._is_free_run:
            return  # robots send it last: most looks end here, and each costs
        while self.beacon is None or self._is_free_run:
            if (data := self._beacons.take()) is None:
                break
            self._pass("beacon", self._receive_beacon, data)

    def _pass(self, name: str, take: Callable[[bytes], None], data: bytes) -> None:
        try:
            take(data)
        except RejectedError as error:
            self._foreigners.rejections.reject(name, self.name, error)

    def publish_for_viewers(
        self, pose_odom: Pose, joints: tuple[list[str], list[float], list[float]] | None
    ) -> None:
        """Publish tf and joint_states, as far as somebody wants them.

        Args:
            joints: Names, positions [rad] and velocities [rad/s] of the wheels; None if they are
                not known.
        """
        tick = self._tick
        names, positions, velocities = joints or ([], [], [])
        if self.wants_tf:
            transforms = [ros_io.planar_transform("odom", BASE, pose_odom, tick)]
            by_name = dict(zip(names, positions, strict=True))
            transforms += moving_transforms(self._joints, by_name, tick)
            self._tf.publish(TFMessage(transforms=transforms))
        if self.wants_joints:
            message = JointState(header=ros_io.header(tick, ""))
            message.name, message.position, message.velocity = names, positions, velocities
            self._joint_states.publish(message)

    def publish_imu(self, imu: Imu) -> None:
        """Publish what the IMU reads; a variance of 0 stands for unknown."""
        message = ImuMsg(header=ros_io.header(imu.tick, IMU_FRAME))
        half = 0.5 * imu.yaw
        message.orientation.z, message.orientation.w = math.sin(half), math.cos(half)
        message.angular_velocity.z = imu.yaw_rate
        acceleration = message.linear_acceleration
        acceleration.x, acceleration.y, acceleration.z = imu.acceleration
        self._imu.publish(message)

    def publish_truth(self, pose_map: Pose, twist: Twist) -> None:
        """Publish the true pose for the operator."""
        self._last_truth = self._tick, self._truth_writer.encode(self._tick, pose_map, twist)
        self._truth.publish(self._last_truth[1])

    def fresh_command(self) -> Twist | None:
        """Return the answer's command; in free run else any other that came during this tick."""
        return self.command if self.command is not None else self._other

    def _receive_stamped(self, data: bytes) -> None:
        tick, twist = self._command_reader.read(data)
        if self._is_external and tick != self._tick:
            if tick == 0 or not tick <= self.newest_tick:  # else an answer that is repeated
                self.is_unstamped, self._other = True, twist
            return
        if tick > self._tick and not self._is_free_run:
            raise RejectedError(f"the stamp is of tick {tick}; it is tick {self._tick} now")
        self.newest_tick = max(self.newest_tick, tick)
        self._take(twist, tick == self._tick)

    def _receive_plain(self, data: bytes) -> None:
        self._take(cdr.read_plain_command(data), False)

    def _take(self, twist: Twist, is_answer: bool) -> None:
        if self._is_free_run:  # in lockstep, a late answer is not a command for this tick
            self._other = twist
        if is_answer and self.command is None:
            self.command, self.is_unstamped = twist, False
            self._record_answer()

    def _receive_beacon(self, data: bytes) -> None:
        beacon = read_beacon(data, self._robot_id, self._tick)
        is_answer = beacon["tick"] == self._tick or self._is_free_run
        self._has_beacon = True
        if is_answer and self.beacon is None:
            self.beacon = beacon
            self._record_answer()

    def _record_answer(self) -> None:
        if self.has_answered:
            self._on_answer()
