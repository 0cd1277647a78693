"""Poses that arrive with a frame, in map."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

from geometry_msgs.msg import Pose as PoseMsg
from geometry_msgs.msg import PoseStamped, TransformStamped
from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from swarm_common.middleware.ros_io import STATIC_TRANSFORMS, pose_from_msg
from swarm_common.model.records import Pose
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.localisation.localiser import START_DEVIATION
from swarm_nav.ros.nav2.goals import UnknownFrameError

LEAST_DEVIATION, MOST_DEVIATION = 0.01, 2.0  # [m] and [rad] that a client's covariance may mean
BASE = "base_footprint"
PATIENCE, PERIOD = 2.0, 0.01  # [s] of wall time for `tf_static` to come, and between two polls
Place = tuple[float, float, float]  # x, y, z [m]
Quaternion = tuple[float, float, float, float]  # x, y, z, w


class RobotFrames:
    """The fixed frames of a robot, from its `tf_static`; nobody subscribes before one is asked."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._parents: dict[str, TransformStamped] = {}  # by child frame

    def to_base(self, frame: str, pose: PoseMsg) -> PoseMsg:
        """Return a pose of one of these frames in base_footprint.

        Raises:
            UnknownFrameError: If the robot has no such frame, or it moves; lists those that count.
        """
        if not self._parents:
            self._receive()
        place = pose.position.x, pose.position.y, pose.position.z
        q = pose.orientation
        turn = (q.x, q.y, q.z, q.w) if any((q.x, q.y, q.z, q.w)) else (0.0, 0.0, 0.0, 1.0)
        at = frame
        while at != BASE:
            if at not in self._parents:
                known = ", ".join(["map", "odom", BASE, *sorted(self._parents)])
                raise UnknownFrameError(f"frame '{frame}' is unknown; known: {known}")
            link = self._parents[at]
            offset, q = link.transform.translation, link.transform.rotation
            x, y, z = _rotated((q.x, q.y, q.z, q.w), place)
            place = offset.x + x, offset.y + y, offset.z + z
            turn = _product((q.x, q.y, q.z, q.w), turn)
            at = link.header.frame_id.lstrip("/")
        moved = PoseMsg()
        moved.position.x, moved.position.y, moved.position.z = place
        o = moved.orientation
        o.x, o.y, o.z, o.w = turn
        return moved

    def _receive(self) -> None:
        """Wait for the latched message; it is there at once where the world has published it."""
        subscription = self._node.create_subscription(
            TFMessage, "tf_static", lambda _: None, STATIC_TRANSFORMS
        )
        try:
            end = time.monotonic() + PATIENCE
            while not self._parents and time.monotonic() < end:
                with subscription.handle:
                    taken = subscription.handle.take_message(TFMessage, False)
                if taken is None:
                    time.sleep(PERIOD)
                    continue
                for item in taken[0].transforms:
                    self._parents[item.child_frame_id.lstrip("/")] = item
        finally:
            self._node.destroy_subscription(subscription)


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the quaternion a ∘ b."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _rotated(q: Quaternion, place: Place) -> Place:
    """Return a place turned by a unit quaternion."""
    x, y, z, w = q
    turned = _product(_product(q, (*place, 0.0)), (-x, -y, -z, w))
    return turned[0], turned[1], turned[2]


def pose_in_map(brain: Navigator, frames: RobotFrames, robot: str, stamped: PoseStamped) -> Pose:
    """Return a pose of one of the robot's frames in map.

    Args:
        brain: Knows where odom and the robot are in map.
        frames: The fixed frames of the robot.
        robot: Name, which may stand before a frame, as in `Srobot3/base_link`.
        stamped: In map, odom or a fixed frame of the robot; an empty frame means map.

    Raises:
        UnknownFrameError: If it is in another frame.
        ValueError: If a number is not finite or the quaternion is not of unit length.
    """
    pose = pose_from_msg(stamped.pose)
    frame = stamped.header.frame_id.lstrip("/").removeprefix(f"{robot}/")
    if frame in ("", "map"):
        return pose
    if frame == "odom":
        return brain.map_from_odom.compose(pose)
    if frame != BASE:
        pose = pose_from_msg(frames.to_base(frame, stamped.pose))
    return brain.pose_map.compose(pose)


def is_placeholder(stamped: PoseStamped) -> bool:
    """Whether BasicNavigator sent this because its user has never called setInitialPose.

    Args:
        stamped: Of `initialpose`; `pose_in_map` has taken it already.
    """
    stamp, pose = stamped.header.stamp, pose_from_msg(stamped.pose)
    return not (stamp.sec or stamp.nanosec) and pose == Pose(0.0, 0.0, 0.0)


def deviation_in(covariance: Sequence[float]) -> tuple[float, float]:
    """Return the standard deviations in a covariance, limited to what makes sense.

    Args:
        covariance: (36,) of geometry_msgs/PoseWithCovariance, by rows.

    Returns:
        Of x and y [m], the larger one, and of yaw [rad]; `START_DEVIATION` in place of zeros and of
        what is no variance.
    """
    variances = (max(covariance[0], covariance[7]), covariance[35])
    place, yaw = (
        min(MOST_DEVIATION, max(LEAST_DEVIATION, math.sqrt(value)))
        if math.isfinite(value) and value > 0.0
        else usual
        for value, usual in zip(variances, START_DEVIATION, strict=True)
    )
    return place, yaw
