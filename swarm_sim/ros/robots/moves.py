"""Tells navigators that their robots were put elsewhere, and holds these until they know."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from swarm_common.middleware import ros_io
from swarm_common.middleware.rclpy_compat import removable_publisher
from swarm_common.middleware.ros_poll import PolledTopic
from swarm_common.model.records import Pose, Twist, wrap_angle

# [s] of wall time for which the tick waits; then the robot is told between the ticks, and stands
# until its beacon says that it knows.
LIMIT = 0.5
# [s] of wall time between two times of telling: the navigator may not know our topic yet, or hear
REPEAT_PERIOD = 0.3  # somebody else in between
SLICE = 0.01  # [s] of wall time between two looks whether it has
SAME_PLACE, SAME_TURN = 0.3, 0.3  # [m], [rad] within which a pose is taken for the new one
DEVIATIONS = (0.05, 0.05)  # [m], [rad] of the pose that is told


class Relocation:
    """One robot's move: `initialpose` out, `amcl_pose` back."""

    def __init__(self, node: Node, name: str, pose_map: Pose, tick: int, deadline: float) -> None:
        """Begin to tell."""
        self.deadline = deadline
        self._node = node
        self._pose = pose_map
        self._tick = tick
        self._is_told = False
        self._due = 0.0  # wall time at which it is told, or told again
        space = f"/{name}"
        self._publisher = removable_publisher(
            node, PoseWithCovarianceStamped, f"{space}/initialpose", ros_io.RELIABLE
        )
        self._poses = PolledTopic(
            node, PoseWithCovarianceStamped, f"{space}/amcl_pose", ros_io.LATCHED
        )

    def is_known(self) -> bool:
        """Send it if somebody listens; return whether the navigator says that it is there."""
        now = time.monotonic()
        if now >= self._due and self._publisher.get_subscription_count() > 0:
            self._is_told, self._due = True, now + REPEAT_PERIOD
            self._publisher.publish(self._message())
        while (data := self._poses.take()) is not None:
            pose_map = _pose_in(data)
            if self._is_told and pose_map is not None and is_near(pose_map, self._pose):
                return True
        return False

    def destroy(self) -> None:
        """Withdraw the topics."""
        self._poses.destroy()
        self._node.destroy_publisher(self._publisher)

    def _message(self) -> PoseWithCovarianceStamped:
        message = PoseWithCovarianceStamped(header=ros_io.header(self._tick, "map"))
        message.pose.pose = ros_io.pose_msg(self._pose)
        place, turn = (value**2 for value in DEVIATIONS)
        message.pose.covariance[0] = message.pose.covariance[7] = place
        message.pose.covariance[35] = turn
        return message


def _pose_in(data: bytes) -> Pose | None:
    """Return the pose in a message that anybody may have sent; None if there is none."""
    try:
        message = deserialize_message(data, PoseWithCovarianceStamped)
        return ros_io.pose_from_msg(message.pose.pose)
    except (ValueError, RuntimeError, MemoryError):  # RMWError is a RuntimeError
        return None


class Moves:
    """All robots that were put elsewhere and may not know it yet."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._relocations: dict[int, Relocation] = {}
        self._unsure: dict[int, Pose] = {}  # whose beacons have not said yet that they know

    def tell(
        self, robot: int, name: str, pose_map: Pose, tick: int, patience: float, speaks: bool
    ) -> None:
        """Begin to tell a robot.

        Args:
            patience: [s] of wall time for which it is worth waiting.
            speaks: Whether it sends beacons.
        """
        self.forget(robot)
        deadline = time.monotonic() + patience
        self._relocations[robot] = Relocation(self._node, name, pose_map, tick, deadline)
        if speaks:
            self._unsure[robot] = pose_map

    def forget(self, robot: int) -> None:
        """Stop sending to a robot."""
        self._unsure.pop(robot, None)
        if robot in self._relocations:
            self._relocations.pop(robot).destroy()

    def settle(self, is_stopped: Callable[[], bool]) -> None:
        """Wait until all know, or it is not worth waiting any more."""
        while self._relocations and not is_stopped():
            now = time.monotonic()
            for robot, relocation in list(self._relocations.items()):
                if relocation.is_known():
                    self._relocations.pop(robot).destroy()
            if all(now >= relocation.deadline for relocation in self._relocations.values()):
                return  # no navigator answers; the robot stands until one does
            time.sleep(SLICE)

    def hold(self, commands: list[Twist | None], beacons: list[np.void | None]) -> list[int]:
        """Let robots stand, and nobody hear them, that think that they are elsewhere.

        The radio speaks for them meanwhile.

        Args:
            commands: One per robot; those of robots that do not know are replaced by a stop.
            beacons: One per robot; those of robots that do not know are replaced by None.

        Returns:
            Robots that know their place since this tick.
        """
        settled = []
        for robot, pose_map in list(self._unsure.items()):
            beacon = beacons[robot]
            if beacon is not None and is_near(Pose(*beacon["pose"].tolist()), pose_map):
                del self._unsure[robot]
                settled.append(robot)
            else:
                commands[robot], beacons[robot] = Twist(), None
        return settled


def is_near(pose: Pose, other: Pose) -> bool:
    """Whether a pose may be taken for another."""
    turn = abs(wrap_angle(pose.yaw - other.yaw))
    return pose.distance(other) < SAME_PLACE and turn < SAME_TURN
