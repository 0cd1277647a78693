"""Poses that arrive with a frame, in map."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from geometry_msgs.msg import Pose as PoseMsg
from geometry_msgs.msg import PoseStamped

from swarm_common.middleware.rejections import RejectedError
from swarm_common.middleware.ros_io import pose_from_msg
from swarm_common.model.records import FloatArray, Pose
from swarm_nav.core.localisation_config import START_DEVIATION
from swarm_nav.interfaces import Localised
from swarm_nav.ros.nav2.goals import UnknownFrameError

BASE = "base_footprint"
LEAST_DEVIATION, MOST_DEVIATION = 0.01, 2.0  # [m] and [rad] that a client's covariance may mean
PATIENCE, PERIOD = 2.0, 0.01  # [s] of wall time for `tf_static` to come, and between two polls
Place = tuple[float, float, float]  # x, y, z [m]
Quaternion = tuple[float, float, float, float]  # x, y, z, w


def pose_in_map(
    robot: Localised, name: str, links: Mapping[str, Sequence[float]], stamped: PoseStamped
) -> Pose:
    """Return a pose of one of the robot's frames in map.

    Args:
        robot: Knows where odom and the robot are in map.
        name: Name of the robot; its frames may have it in front, like `Srobot3/base_link`.
        links: Place of each fixed link in base_footprint: x, y, z [m] and quaternion x, y, z, w.
        stamped: In map, odom, or a fixed link; an empty frame means map.

    Raises:
        UnknownFrameError: If it is in another frame; the message lists the known ones.
        ValueError: If a number is not finite or the quaternion is not of unit length.
    """
    pose = pose_from_msg(stamped.pose)
    frame = stamped.header.frame_id.removeprefix("/")
    if frame in ("", "map"):
        return pose
    frame = frame.removeprefix(f"{name}/")
    if frame == "odom":
        return robot.map_from_odom.compose(pose)
    if frame == BASE:
        return robot.pose_map.compose(pose)
    if frame in links:
        return robot.pose_map.compose(_in_base(links[frame], stamped.pose))
    known = ", ".join(dict.fromkeys(("map", "odom", BASE, *links)))
    raise UnknownFrameError(f"frame '{stamped.header.frame_id}' is unknown; known: {known}")


def _in_base(link: Sequence[float], message: PoseMsg) -> Pose:
    """Return the planar part in base_footprint of a pose in a link's frame, which may be tilted."""
    place, turn = message.position, message.orientation
    if not math.isfinite(place.z):
        raise RejectedError("the pose has a number that is not finite")
    base_from_link = _rotation(*link[3:])
    x, y, _ = base_from_link @ (place.x, place.y, place.z) + link[:3]
    heading = base_from_link @ _rotation(turn.x, turn.y, turn.z, turn.w)[:, 0]
    return Pose(float(x), float(y), math.atan2(heading[1], heading[0]))


def _rotation(x: float, y: float, z: float, w: float) -> FloatArray:
    """Return the matrix (3, 3) of a quaternion of about unit length; zeros count as no turn."""
    square = x * x + y * y + z * z + w * w
    if square == 0.0:
        return np.eye(3)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: FloatArray = np.eye(3) + 2.0 * (w * cross + cross @ cross) / square
    return turned


def is_placeholder(stamped: PoseStamped) -> bool:
    """Whether BasicNavigator sent this because its user has never called setInitialPose.

    Args:
        stamped: The pose of `initialpose`, which `pose_in_map` has accepted already.
    """
    stamp, pose = stamped.header.stamp, pose_from_msg(stamped.pose)
    return not (stamp.sec or stamp.nanosec) and pose == Pose(0.0, 0.0, 0.0)


def deviation_in(covariance: Sequence[float]) -> tuple[float, float]:
    """Return the standard deviations in a covariance, limited to what makes sense.

    Args:
        covariance: (36,) of geometry_msgs/PoseWithCovariance, by rows.

    Returns:
        Deviations of x and y [m], the larger one, and of yaw [rad]; `START_DEVIATION` in place of
        zeros and of what is no variance.
    """
    variances = (max(covariance[0], covariance[7]), covariance[35])
    place, yaw = (
        min(MOST_DEVIATION, max(LEAST_DEVIATION, math.sqrt(value)))
        if math.isfinite(value) and value > 0.0
        else usual
        for value, usual in zip(variances, START_DEVIATION, strict=True)
    )
    return place, yaw
