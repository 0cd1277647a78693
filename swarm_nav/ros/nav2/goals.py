"""Nav2's action goals, feedback and results, to and from the brain's."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import (
    AssistedTeleop,
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

from swarm_common.middleware.cdr import MOST_SPEED
from swarm_common.middleware.rejections import RejectedError
from swarm_common.middleware.ros_io import ANY_HEADING, BACKWARDS, pose_stamped, start_in
from swarm_common.model.records import CONTROL_PERIOD, Pose, Twist
from swarm_nav.core.goals import (
    UNKNOWN_CODES,
    ErrorCode,
    Feedback,
    Goal,
    GoalEnded,
    GoalKind,
    Outcome,
    PlanError,
)
from swarm_nav.ros.nav2.map_bounds import MapBounds, OffMapError

ACTIONS: dict[GoalKind, Any] = {
    GoalKind.NAVIGATE: NavigateToPose,
    GoalKind.THROUGH: NavigateThroughPoses,
    GoalKind.WAYPOINTS: FollowWaypoints,
    GoalKind.FOLLOW_PATH: FollowPath,
    GoalKind.SPIN: Spin,
    GoalKind.BACKUP: BackUp,
    GoalKind.DRIVE_ON_HEADING: DriveOnHeading,
    GoalKind.WAIT: Wait,
    GoalKind.TELEOP: AssistedTeleop,
}

ToMap = Callable[[PoseStamped], Pose]  # raises UnknownFrameError, ValueError for bad numbers
NOT_ACTIVE = "the navigator is not active"  # and takes no goals
CLIENT = "a client"  # of an action or a service: rclpy does not say which
MOST_POSES = 1000  # of one goal
MOST_LOOPS = 10_000  # through them
MOST_POINTS = 20_000  # of a path
MOST_ANGLE = 1000.0  # [rad] of a turn
MOST_SECONDS = 1e6  # [s] of a pause or a time allowance
MOST_DELAY = 864_000  # ticks, a day, that a goal may begin later
THROUGH_OFFSET = 100  # ComputePathThroughPoses has 300 where ComputePathToPose has 200


class UnknownFrameError(RejectedError):
    """A pose lies in a frame that the navigator does not know."""


def seconds(duration: Duration) -> float:
    """Return a duration in seconds."""
    return float(duration.sec) + 1e-9 * float(duration.nanosec)


def duration_msg(value: float) -> Duration:
    """Return a duration; a negative or infinite one becomes zero.

    Args:
        value: [s]
    """
    if not math.isfinite(value) or value <= 0.0:
        return Duration()
    sec = math.floor(value)
    return Duration(sec=sec, nanosec=int(1e9 * (value - sec)))


def goal_from_request(
    kind: GoalKind, goal_id: int, request: Any, to_map: ToMap, reach: MapBounds
) -> Goal:
    """Return the brain's goal: the door of all navigation actions.

    `Tasks` calls it before it accepts a request. It checks frame,
    numbers and lengths, and that places lie within 1000 m of the map (`MapBounds.check`). The
    planner finds out later whether a place is free and can be reached; if it is not, the accepted
    goal fails with Nav2's code.
    A tick at which the goal is to begin travels in `behavior_tree`, see `start_in`; or that the
    robot keeps the heading in which it arrives (`ANY_HEADING`): the last pose's yaw is NaN then.
    `controller_id` of a path says whether it is driven `BACKWARDS`.

    Args:
        to_map: Brings a pose of a known frame to map; refuses one more than 1000 m off it.

    Raises:
        ValueError: If the request makes no sense; the message says why.
    """
    if kind is GoalKind.NAVIGATE:
        start = start_in(request.behavior_tree)
        poses = _targets([request.pose], request.behavior_tree, to_map)
        return Goal(kind=kind, goal_id=goal_id, poses_map=poses, start_tick=start)
    if kind in (GoalKind.THROUGH, GoalKind.WAYPOINTS):
        check_count(request.poses, MOST_POSES)
        if kind is GoalKind.THROUGH:
            start = start_in(request.behavior_tree)
            poses = _targets(request.poses, request.behavior_tree, to_map)
            return Goal(kind=kind, goal_id=goal_id, poses_map=poses, start_tick=start)
        poses = tuple(to_map(pose) for pose in request.poses)
        first, loops = int(request.goal_index), int(request.number_of_loops)
        if poses and first >= len(poses):
            raise RejectedError(f"goal_index is {first}; there are {len(poses)} poses")
        if loops > MOST_LOOPS:
            raise RejectedError(f"number_of_loops is {loops}; at most {MOST_LOOPS} are driven")
        return Goal(
            kind=kind,
            goal_id=goal_id,
            poses_map=poses,
            first_index=first if poses else 0,
            loops=loops,
        )
    if kind is GoalKind.FOLLOW_PATH:
        goal = path_goal(goal_id, request, to_map, reach)
        return dataclasses.replace(goal, is_reverse=request.controller_id == BACKWARDS)
    return _behavior_goal(kind, goal_id, request, reach)


def _targets(poses: Sequence[PoseStamped], tree: str, to_map: ToMap) -> tuple[Pose, ...]:
    """Return the poses in map; the yaw of the last is NaN if any heading is right there."""
    targets = tuple(to_map(pose) for pose in poses)
    if tree != ANY_HEADING or not targets:
        return targets
    return *targets[:-1], dataclasses.replace(targets[-1], yaw=math.nan)


def twist_from_msg(message: Any) -> Twist:
    """Return the twist that an operator commands.

    Args:
        message: geometry_msgs/Twist in base_footprint; only its planar part counts.

    Raises:
        RejectedError: If it is not a speed that a robot can have.
    """
    speeds = message.linear.x, message.linear.y, message.angular.z
    vx, vy, wz = (_at_most(value, MOST_SPEED, "a speed") for value in speeds)
    return Twist(vx, vy, wz)


def speed_limit_in(message: Any) -> tuple[float, bool]:
    """Return the limit in a nav2_msgs/SpeedLimit, 0 for none, and whether it is in percent.

    Args:
        message: Its limit is in [m/s], or in [%] of the robot's largest speed.

    Raises:
        RejectedError: If the limit makes no sense.
    """
    limit, is_percentage = float(message.speed_limit), bool(message.percentage)
    most = 100.0 if is_percentage else MOST_SPEED
    if not 0.0 <= limit <= most:  # nor a NaN
        unit = "%" if is_percentage else "m/s"
        raise RejectedError(f"a speed limit of {limit:g} {unit}; expected 0 (none) to {most:g}")
    return limit, is_percentage


def check_count(poses: Sequence[Any], most: int) -> None:
    """Refuse more poses than make sense.

    Args:
        most: Number that is taken at most.

    Raises:
        RejectedError: Saying how many there are.
    """
    if len(poses) > most:
        raise RejectedError(f"{len(poses)} poses; at most {most} are taken")


def pose_goal(goal_id: int, pose: PoseStamped, to_map: ToMap) -> Goal:
    """Return the goal of navigate_to_pose; its stamp, of whichever clock, delays nothing.

    Args:
        pose: Pose of base_footprint, in any frame that `to_map` knows.
        to_map: Brings a pose of a known frame to map; refuses one more than 1000 m off it.

    Raises:
        ValueError: If `to_map` refuses the pose; the message says why.
    """
    return Goal(kind=GoalKind.NAVIGATE, goal_id=goal_id, poses_map=(to_map(pose),))


def start_tick(goal: Goal, now: int) -> int:
    """Return the tick at which a goal begins: the one after `now`, or the one that it asks for.

    Args:
        goal: Its `start_tick` is 0 if it is to begin at once.
        now: Tick that it is now.

    Raises:
        RejectedError: If that is more than a day ahead.
    """
    if goal.start_tick > now + MOST_DELAY:
        raise RejectedError(f"it is to begin at tick {goal.start_tick}; it is tick {now}")
    return max(goal.start_tick, now + 1)


def path_goal(goal_id: int, request: Any, to_map: ToMap, reach: MapBounds) -> Goal:
    """Return the goal of a request with a path; see `goal_from_request`.

    Args:
        request: Goal message with a `path`; poses without a frame get that of the path.
        to_map: Brings a pose of a known frame to map; refuses one more than 1000 m off it.
        reach: Size of the current map; it limits the length of the path.

    Raises:
        ValueError: If the path makes no sense; the message says why.
    """
    check_count(request.path.poses, MOST_POINTS)
    for stamped in request.path.poses:
        stamped.header.frame_id = stamped.header.frame_id or request.path.header.frame_id
    poses = tuple(to_map(stamped) for stamped in request.path.poses)
    points = np.array([(pose.x, pose.y) for pose in poses]).reshape(-1, 2)
    length = float(np.hypot(*np.diff(points, axis=0).T).sum()) if len(points) > 1 else 0.0
    if length > reach.longest_path:
        raise RejectedError(f"the path is {length:g} m long; at most {reach.longest_path:.0f} m")
    return Goal(kind=GoalKind.FOLLOW_PATH, goal_id=goal_id, poses_map=poses[-1:], path_map=points)


def _behavior_goal(kind: GoalKind, goal_id: int, request: Any, reach: MapBounds) -> Goal:
    if kind is GoalKind.WAIT:
        duration = _at_most(seconds(request.time), MOST_SECONDS, "time")
        return Goal(kind=kind, goal_id=goal_id, duration=duration)
    allowance = _at_most(seconds(request.time_allowance), MOST_SECONDS, "time_allowance")
    if kind is GoalKind.TELEOP:
        return Goal(kind=kind, goal_id=goal_id, duration=allowance)
    if kind is GoalKind.SPIN:
        angle = _at_most(request.target_yaw, MOST_ANGLE, "target_yaw")
        return Goal(kind=kind, goal_id=goal_id, angle=angle, duration=allowance)
    distance = _at_most(request.target.x, reach.diagonal, "target.x")
    if request.target.y or request.target.z:
        raise RejectedError("target may have an x only; the robot drives straight")
    speed = _at_most(request.speed, MOST_SPEED, "speed")
    if speed == 0.0:
        raise RejectedError("speed is 0")
    is_on = kind is GoalKind.DRIVE_ON_HEADING  # backing up ignores signs, as Nav2's does
    if is_on and distance and (distance < 0.0) != (speed < 0.0):
        raise RejectedError(f"target.x is {distance:g} and speed {speed:g}; both have one sign")
    return Goal(
        kind=kind,
        goal_id=goal_id,
        distance=abs(distance),
        is_reverse=is_on and distance < 0.0,
        speed=abs(speed),
        duration=allowance,
    )


def _at_most(value: float, most: float, name: str) -> float:
    if not -most <= value <= most:  # also of NaN
        raise RejectedError(f"{name} is {value:g}; expected at most {most:g} in size")
    return float(value)


def plan_error_code(error: PlanError | ValueError, is_through: bool) -> int:
    """Return the code of ComputePathToPose or ComputePathThroughPoses for what went wrong.

    Args:
        error: From the planner, or from the checks of the request.
        is_through: Whether the action is ComputePathThroughPoses, whose codes are others.
    """
    if isinstance(error, UnknownFrameError):
        code = ErrorCode.PLAN_TF_ERROR
    else:
        code = error.code if isinstance(error, PlanError | OffMapError) else ErrorCode.NO_VALID_PATH
    is_shifted = is_through and code is not ErrorCode.NO_VIAPOINTS_GIVEN
    return int(code) + (THROUGH_OFFSET if is_shifted else 0)


def feedback_msg(goal: Goal, feedback: Feedback, started_tick: int, tick: int) -> Any:
    """Return the feedback message of the action that a goal belongs to.

    Args:
        started_tick: Tick at which the goal was accepted.
    """
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
    elif kind is GoalKind.TELEOP:
        elapsed = CONTROL_PERIOD * (tick - started_tick)
        message.current_teleop_duration = duration_msg(elapsed)
    else:
        message.distance_traveled = float(feedback.distance_traveled)
    return message


def result_msg(goal: Goal, ended: GoalEnded, started_tick: int, is_asked: bool) -> Any:
    """Return the result message of the action that a goal belongs to.

    Args:
        started_tick: Tick at which the goal was accepted.
        is_asked: Whether the client wants it to end; otherwise a goal that is canceled counts as
            aborted, and has a code.
    """
    kind = goal.kind
    result = ACTIONS[kind].Result()
    is_aborted = ended.outcome is Outcome.CANCELED and not is_asked
    result.error_code = int(UNKNOWN_CODES[kind] if is_aborted else ended.error_code)
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
