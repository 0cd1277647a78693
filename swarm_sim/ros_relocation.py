"""Tells a navigator that its robot was put elsewhere, and notices that it knows."""

from __future__ import annotations

from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from swarm_common import ros_io
from swarm_common.records import Pose, wrap_angle
from swarm_common.ros_poll import PolledTopic

LIMIT = 5.0  # [s] of wall time in which a living navigator takes note
SAME_PLACE, SAME_TURN = 0.3, 0.3  # [m], [rad] within which a pose is taken for the new one
DEVIATIONS = (0.05, 0.05)  # [m], [rad] of the pose that is told


class Relocation:
    """One robot's move: `/SrobotK/initialpose` out, `amcl_pose` back."""

    def __init__(self, node: Node, name: str, pose_map: Pose, tick: int, deadline: float) -> None:
        """Begin to tell.

        Args:
            node: Of the world.
            name: Of the robot.
            pose_map: Where it is now.
            tick: Control tick in hand.
            deadline: Wall time until which it is worth waiting.
        """
        self.deadline = deadline
        self._node = node
        self._pose = pose_map
        self._tick = tick
        self._is_told = False
        space = f"/{name}"
        self._publisher = node.create_publisher(
            PoseWithCovarianceStamped, f"{space}/initialpose", ros_io.RELIABLE
        )
        self._poses = PolledTopic(
            node, PoseWithCovarianceStamped, f"{space}/amcl_pose", ros_io.LATCHED
        )

    def is_known(self) -> bool:
        """Tell it if somebody listens; return whether the navigator says that it is there."""
        if not self._is_told and self._publisher.get_subscription_count() > 0:
            self._is_told = True
            self._publisher.publish(self._message())
        while (data := self._poses.take()) is not None:
            message = deserialize_message(data, PoseWithCovarianceStamped)
            if self._is_told and is_near(ros_io.pose_from_msg(message.pose.pose), self._pose):
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


def is_near(pose: Pose, other: Pose) -> bool:
    """Whether a pose may be taken for another."""
    turn = abs(wrap_angle(pose.yaw - other.yaw))
    return pose.distance(other) < SAME_PLACE and turn < SAME_TURN
