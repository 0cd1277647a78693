"""Nav2's action goals, feedback and results, to and from the brain's."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import (
    BackUp,
    DriveOnHeading,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    Spin,
    Wait,
)
from nav2_msgs.msg import MissedWaypoint

from swarm_common.errors import SwarmError
from swarm_common.records import CONTROL_PERIOD, Pose
from swarm_common.ros_io import pose_stamped, tick_of
from swarm_nav.goals import ErrorCode, Feedback, Goal, GoalEnded, GoalKind, PlanError

ACTIONS: dict[GoalKind, Any] = {
    GoalKind.NAVIGATE: NavigateToPose,
    GoalKind.THROUGH: NavigateThroughPoses,
    GoalKind.WAYPOINTS: FollowWaypoints,
    GoalKind.FOLLOW_PATH: FollowPath,
    GoalKind.SPIN: Spin,
    GoalKind.BACKUP: BackUp,
    GoalKind.DRIVE_ON_HEADING: DriveOnHeading,
    GoalKind.WAIT: Wait,
}

ToMap = Callable[[PoseStamped], Pose]  # raises UnknownFrameError, ValueError for bad numbers
THROUGH_OFFSET = 100  # ComputePathThroughPoses has 300 where ComputePathToPose has 200


class UnknownFrameError(SwarmError, ValueError):
    """A pose lies in a frame that the navigator does not know."""


def seconds(duration: Duration) -> float:
    """Return a duration in seconds."""
    return float(duration.sec) + 1e-9 * float(duration.nanosec)


def duration_msg(value: float) -> Duration:
    """Return a duration; what is not finite or negative becomes zero."""
    if not math.isfinite(value) or value <= 0.0:
        return Duration()
    sec = math.floor(value)
    return Duration(sec=sec, nanosec=int(1e9 * (value - sec)))


def goal_from_request(kind: GoalKind, goal_id: int, request: Any, to_map: ToMap) -> Goal:
    """Return the brain's goal.

    Raises:
        ValueError: If the request makes no sense; the message says why.
    """
    if kind is GoalKind.NAVIGATE:
        return pose_goal(goal_id, request.pose, to_map)
    if kind in (GoalKind.THROUGH, GoalKind.WAYPOINTS):
        poses = tuple(to_map(pose) for pose in request.poses)
        start = tick_of(request.poses[0].header.stamp) if poses else 0
        if kind is GoalKind.THROUGH:
            return Goal(kind=kind, goal_id=goal_id, poses_map=poses, start_tick=start)
        first = int(request.goal_index)
        if poses and first >= len(poses):
            raise ValueError(f"goal_index is {first}; there are {len(poses)} poses")
        return Goal(
            kind=kind,
            goal_id=goal_id,
            poses_map=poses,
            first_index=first if poses else 0,
            loops=int(request.number_of_loops),
            start_tick=start,
        )
    if kind is GoalKind.FOLLOW_PATH:
        return _path_goal(goal_id, request, to_map)
    return _behavior_goal(kind, goal_id, request)


def pose_goal(goal_id: int, pose: PoseStamped, to_map: ToMap) -> Goal:
    """Return the goal of navigate_to_pose; a stamp in the future delays it."""
    return Goal(
        kind=GoalKind.NAVIGATE,
        goal_id=goal_id,
        poses_map=(to_map(pose),),
        start_tick=tick_of(pose.header.stamp),
    )


def _path_goal(goal_id: int, request: Any, to_map: ToMap) -> Goal:
    for stamped in request.path.poses:
        stamped.header.frame_id = stamped.header.frame_id or request.path.header.frame_id
    poses = tuple(to_map(stamped) for stamped in request.path.poses)
    points = np.array([(pose.x, pose.y) for pose in poses]).reshape(-1, 2)
    return Goal(kind=GoalKind.FOLLOW_PATH, goal_id=goal_id, poses_map=poses[-1:], path_map=points)


def _behavior_goal(kind: GoalKind, goal_id: int, request: Any) -> Goal:
    if kind is GoalKind.WAIT:
        return Goal(kind=kind, goal_id=goal_id, duration=seconds(request.time))
    allowance = seconds(request.time_allowance)
    if kind is GoalKind.SPIN:
        angle = _finite(request.target_yaw, "target_yaw")
        return Goal(kind=kind, goal_id=goal_id, angle=angle, duration=allowance)
    distance = abs(_finite(request.target.x, "target.x"))
    if request.target.y or request.target.z:
        raise ValueError("target may have an x only; the robot drives straight")
    speed = abs(_finite(request.speed, "speed"))
    if speed == 0.0:
        raise ValueError("speed is 0")
    return Goal(kind=kind, goal_id=goal_id, distance=distance, speed=speed, duration=allowance)


def _finite(value: float, name: str) -> float:
    if not math.isfinite(value):
        raise ValueError(f"{name} is {value}")
    return float(value)


def plan_error_code(error: PlanError | ValueError, is_through: bool) -> int:
    """Return the code of ComputePathToPose or ComputePathThroughPoses for what went wrong."""
    if isinstance(error, UnknownFrameError):
        code = ErrorCode.PLAN_TF_ERROR
    else:
        code = error.code if isinstance(error, PlanError) else ErrorCode.NO_VALID_PATH
    is_shifted = is_through and code is not ErrorCode.NO_VIAPOINTS_GIVEN
    return int(code) + (THROUGH_OFFSET if is_shifted else 0)


def feedback_msg(goal: Goal, feedback: Feedback, started_tick: int, tick: int) -> Any:
    """Return the feedback message of the action that a goal belongs to."""
    kind = goal.kind
    message = ACTIONS[kind].Feedback()
    if kind in (GoalKind.NAVIGATE, GoalKind.THROUGH):
        message.current_pose = pose_stamped(feedback.pose_map, tick)
        message.navigation_time = duration_msg(feedback.navigation_time)
        message.estimated_time_remaining = duration_msg(feedback.estimated_time_remaining)
        message.number_of_recoveries = feedback.number_of_recoveries
        message.distance_remaining = float(feedback.distance_remaining)
        if kind is GoalKind.THROUGH:
            message.number_of_poses_remaining = feedback.poses_remaining
    elif kind is GoalKind.WAYPOINTS:
        message.current_waypoint = feedback.current_waypoint
    elif kind is GoalKind.FOLLOW_PATH:
        message.distance_to_goal = float(feedback.distance_remaining)
        message.speed = float(feedback.speed)
    elif kind is GoalKind.SPIN:
        message.angular_distance_traveled = float(feedback.angle_traveled)
    elif kind is GoalKind.WAIT:
        message.time_left = duration_msg(goal.duration - CONTROL_PERIOD * (tick - started_tick))
    else:
        message.distance_traveled = float(feedback.distance_traveled)
    return message


def result_msg(goal: Goal, ended: GoalEnded, started_tick: int) -> Any:
    """Return the result message of the action that a goal belongs to."""
    kind = goal.kind
    result = ACTIONS[kind].Result()
    result.error_code = int(ended.error_code)
    result.error_msg = ended.message
    if kind is GoalKind.WAYPOINTS:
        result.missed_waypoints = [
            MissedWaypoint(
                index=index,
                goal=pose_stamped(goal.poses_map[index], ended.tick),
                error_code=int(code),
            )
            for index, code in ended.missed_waypoints
        ]
    if hasattr(result, "total_elapsed_time"):
        result.total_elapsed_time = duration_msg(CONTROL_PERIOD * (ended.tick - started_tick))
    return result
