"""Places and twists of robots and things as messages, and back."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import Pose as PoseMsg
from geometry_msgs.msg import Twist as TwistMsg

from swarm_common.middleware import ros_io
from swarm_common.model.records import Pose, Twist
from swarm_common.model.shapes import Transform, quaternion_of
from swarm_sim.world.request_checks import Reason, RefusedError

MAP = "map"
FRAMES = ("", MAP, "world")  # which all mean the same


def check_frame(frame: str) -> None:
    """Refuse a frame that is not the map's.

    Args:
        frame: Frame id of a header; empty means `map`.

    Raises:
        RefusedError: Naming it.
    """
    if frame not in FRAMES:
        raise RefusedError(
            Reason.BAD_PLACE, f"poses are in the frame '{MAP}'; '{frame}' is not known"
        )


def pose_in_map(frame: str, message: PoseMsg) -> Pose:
    """Return the planar part of a pose.

    Args:
        message: geometry_msgs/Pose; an all-zero quaternion counts as yaw 0.
    """
    check_frame(frame)
    try:
        return ros_io.pose_from_msg(message)
    except ValueError as error:
        raise RefusedError(Reason.BAD_PLACE, str(error)) from error


def place_in_map(message: PoseMsg) -> Transform:
    """Return a whole pose; an all-zero quaternion counts as no turn."""
    try:
        ros_io.pose_from_msg(message)
    except ValueError as error:
        raise RefusedError(Reason.BAD_PLACE, str(error)) from error
    point, q = message.position, message.orientation
    place = np.eye(4)
    place[:3, 3] = point.x, point.y, point.z
    norm = math.hypot(q.x, q.y, q.z, q.w)
    if norm > 0.0:
        x, y, z, w = (value / norm for value in (q.x, q.y, q.z, q.w))
        place[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    return place


def message_of(place: Transform) -> PoseMsg:
    """Return a transform as a pose."""
    message = PoseMsg()
    point, turn = message.position, message.orientation
    point.x, point.y, point.z = place[:3, 3].tolist()
    turn.x, turn.y, turn.z, turn.w = quaternion_of(place[:3, :3])
    return message


def twist_in_map(twist: Twist, yaw: float) -> TwistMsg:
    """Return a robot's twist as seen in the map frame."""
    speed = Pose(0.0, 0.0, yaw).compose(Pose(twist.vx, twist.vy, 0.0))
    message = TwistMsg()
    message.linear.x, message.linear.y, message.angular.z = speed.x, speed.y, twist.wz
    return message
