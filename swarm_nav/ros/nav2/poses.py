"""Poses that arrive with a frame, in map."""

from __future__ import annotations

import math
from collections.abc import Sequence

from geometry_msgs.msg import PoseStamped

from swarm_common.middleware.ros_io import pose_from_msg
from swarm_common.model.records import Pose
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.localisation.localiser import START_DEVIATION
from swarm_nav.ros.nav2.goals import UnknownFrameError

LEAST_DEVIATION, MOST_DEVIATION = 0.01, 2.0  # [m] and [rad] that a client's covariance may mean


def pose_in_map(brain: Navigator, stamped: PoseStamped) -> Pose:
    """Return a pose of one of the robot's frames in map.

    Args:
        brain: Knows where odom and the robot are in map.
        stamped: In map, odom, base_footprint or base_link; an empty frame means map.

    Raises:
        UnknownFrameError: If it is in another frame.
        ValueError: If a number is not finite or the quaternion is not of unit length.
    """
    pose = pose_from_msg(stamped.pose)
    frame = stamped.header.frame_id.lstrip("/")
    if frame in ("", "map"):
        return pose
    if frame == "odom":
        return brain.map_from_odom.compose(pose)
    if frame in ("base_footprint", "base_link"):
        return brain.pose_map.compose(pose)
    raise UnknownFrameError(f"frame '{frame}' is unknown; use map, odom or base_footprint")


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
