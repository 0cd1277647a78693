"""Nav2's requests and results on the way to and from the brain, without a graph."""

import math

import pytest
from nav2_msgs.action import (
    AssistedTeleop,
    BackUp,
    ComputePathThroughPoses,
    ComputePathToPose,
    DriveOnHeading,
    FollowPath,
    FollowWaypoints,
    SmoothPath,
    Spin,
    Wait,
)
from nav2_msgs.msg import SpeedLimit

from swarm_common.middleware.rejections import RejectedError
from swarm_common.middleware.ros_io import (
    ANY_HEADING,
    BACKWARDS,
    pose_from_msg,
    pose_stamped,
    start_in,
)
from swarm_common.model.records import Pose
from swarm_nav.core.goals import (
    UNKNOWN_CODES,
    ErrorCode,
    Goal,
    GoalEnded,
    GoalKind,
    Outcome,
    PlanError,
)
from swarm_nav.ros.nav2.goals import (
    ACTIONS,
    UnknownFrameError,
    goal_from_request,
    plan_error_code,
    result_msg,
    speed_limit_in,
)
from swarm_nav.ros.nav2.map_bounds import MapBounds, OffMapError

CONTROL, PLAN, THROUGH = FollowPath.Result, ComputePathToPose.Result, ComputePathThroughPoses.Result
NAV2 = {
    ErrorCode.NONE: PLAN.NONE,
    ErrorCode.CONTROL_UNKNOWN: CONTROL.UNKNOWN,
    ErrorCode.INVALID_PATH: CONTROL.INVALID_PATH,
    ErrorCode.FAILED_TO_MAKE_PROGRESS: CONTROL.FAILED_TO_MAKE_PROGRESS,
    ErrorCode.NO_VALID_CONTROL: CONTROL.NO_VALID_CONTROL,
    ErrorCode.CONTROLLER_TIMED_OUT: CONTROL.CONTROLLER_TIMED_OUT,
    ErrorCode.PLAN_UNKNOWN: PLAN.UNKNOWN,
    ErrorCode.PLAN_TF_ERROR: PLAN.TF_ERROR,
    ErrorCode.START_OUTSIDE_MAP: PLAN.START_OUTSIDE_MAP,
    ErrorCode.GOAL_OUTSIDE_MAP: PLAN.GOAL_OUTSIDE_MAP,
    ErrorCode.START_OCCUPIED: PLAN.START_OCCUPIED,
    ErrorCode.GOAL_OCCUPIED: PLAN.GOAL_OCCUPIED,
    ErrorCode.PLAN_TIMEOUT: PLAN.TIMEOUT,
    ErrorCode.NO_VALID_PATH: PLAN.NO_VALID_PATH,
    ErrorCode.NO_VIAPOINTS_GIVEN: THROUGH.NO_VIAPOINTS_GIVEN,
    ErrorCode.WAYPOINTS_UNKNOWN: FollowWaypoints.Result.UNKNOWN,
    ErrorCode.SPIN_UNKNOWN: Spin.Result.UNKNOWN,
    ErrorCode.BACKUP_UNKNOWN: BackUp.Result.UNKNOWN,
    ErrorCode.DRIVE_UNKNOWN: DriveOnHeading.Result.UNKNOWN,
    ErrorCode.TELEOP_UNKNOWN: AssistedTeleop.Result.UNKNOWN,
    ErrorCode.WAIT_UNKNOWN: Wait.Result.UNKNOWN,
    ErrorCode.SPIN_TIMEOUT: Spin.Result.TIMEOUT,
    ErrorCode.BACKUP_TIMEOUT: BackUp.Result.TIMEOUT,
    ErrorCode.BACKUP_COLLISION_AHEAD: BackUp.Result.COLLISION_AHEAD,
    ErrorCode.DRIVE_TIMEOUT: DriveOnHeading.Result.TIMEOUT,
    ErrorCode.DRIVE_COLLISION_AHEAD: DriveOnHeading.Result.COLLISION_AHEAD,
    ErrorCode.SMOOTH_BAD_ID: SmoothPath.Result.INVALID_SMOOTHER,
    ErrorCode.SMOOTH_COLLISION: SmoothPath.Result.SMOOTHED_PATH_IN_COLLISION,
    ErrorCode.SMOOTH_BAD_PATH: SmoothPath.Result.INVALID_PATH,
    ErrorCode.TELEOP_TIMEOUT: AssistedTeleop.Result.TIMEOUT,
}
REACH = MapBounds((-10.0, -5.0), (10.0, 10.0))
POSES = (Pose(1.0, 2.0, 0.0), Pose(3.0, 4.0, 0.5), Pose(5.0, 6.0, 1.0))


def to_map(stamped):
    return pose_from_msg(stamped.pose)


def waypoints(first, loops=0, poses=POSES):
    request = FollowWaypoints.Goal(goal_index=first, number_of_loops=loops)
    request.poses = [pose_stamped(pose, 0) for pose in poses]
    return goal_from_request(GoalKind.WAYPOINTS, 7, request, to_map, REACH)


@pytest.mark.parametrize("code", ErrorCode)
def test_every_code_is_the_constant_of_nav2s_action(code):
    assert int(code) == NAV2[code]


@pytest.mark.parametrize(
    ("error", "one", "through"),
    [
        (PlanError(ErrorCode.GOAL_OCCUPIED, ""), PLAN.GOAL_OCCUPIED, THROUGH.GOAL_OCCUPIED),
        (UnknownFrameError(""), PLAN.TF_ERROR, THROUGH.TF_ERROR),
        (OffMapError(""), PLAN.GOAL_OUTSIDE_MAP, THROUGH.GOAL_OUTSIDE_MAP),
        (ValueError("x is nan"), PLAN.NO_VALID_PATH, THROUGH.NO_VALID_PATH),
    ],
)
def test_a_plan_that_fails_has_the_code_of_the_action_that_asked(error, one, through):
    assert plan_error_code(error, is_through=False) == one
    assert plan_error_code(error, is_through=True) == through


def test_waypoints_keep_their_poses_and_first_index():
    goal = waypoints(2, loops=3)
    assert [(pose.x, pose.y) for pose in goal.poses_map] == [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)]
    assert (goal.goal_id, goal.first_index, goal.loops) == (7, 2, 3)
    assert waypoints(2, poses=()).first_index == 0
    with pytest.raises(ValueError, match="goal_index is 3; there are 3 poses"):
        waypoints(3)


def test_goals_have_codes_starts_and_missed_waypoints():
    """Preempted, or of a navigator that was deactivated, it had 0, which is success."""
    ended = GoalEnded(7, Outcome.CANCELED, 50, message="preempted by a new goal")
    for kind, code in UNKNOWN_CODES.items():
        result = result_msg(Goal(kind=kind), ended, 10, is_asked=False)
        assert (result.error_code, result.error_msg) == (code, ended.message)
    assert set(UNKNOWN_CODES) == set(GoalKind)
    assert result_msg(waypoints(1), ended, 10, is_asked=True).error_code == 0
    assert [start_in(text) for text in ("start_at_tick 1200", "", "/a/b.xml")] == [1200, 0, 0]
    missed = ((1, ErrorCode.GOAL_OCCUPIED), (2, ErrorCode.FAILED_TO_MAKE_PROGRESS))
    ended = GoalEnded(7, Outcome.SUCCEEDED, 50, missed_waypoints=missed)
    result = result_msg(waypoints(1), ended, 10, is_asked=False)
    assert [(one.index, one.error_code) for one in result.missed_waypoints] == [(1, 206), (2, 105)]
    assert [one.goal.pose.position.x for one in result.missed_waypoints] == [3.0, 5.0]


def test_a_goal_of_position_only_has_no_heading_at_its_end():
    """It had the heading from where the robot began: it turned, which nobody had ordered."""

    def read(kind, **fields):
        request = ACTIONS[kind].Goal(behavior_tree=ANY_HEADING, **fields)
        return goal_from_request(kind, 7, request, lambda p: pose_from_msg(p.pose), None)

    first, last = pose_stamped(Pose(1.0, 2.0, 0.5), 0), pose_stamped(Pose(3.0, 4.0, 0.5), 0)
    (target,) = read(GoalKind.NAVIGATE, pose=last).poses_map
    assert (target.x, target.y) == (3.0, 4.0)
    assert math.isnan(target.yaw)
    passed, end = read(GoalKind.THROUGH, poses=[first, last]).poses_map
    assert passed.yaw == pytest.approx(0.5)
    assert math.isnan(end.yaw)


@pytest.mark.parametrize(
    ("name", "is_reverse"), [("", False), ("FollowPath", False), (BACKWARDS, True)]
)
def test_a_path_says_whether_it_is_driven_backwards(name, is_reverse):
    request = ACTIONS[GoalKind.FOLLOW_PATH].Goal(controller_id=name)
    request.path.poses = [pose_stamped(Pose(x, 0.0, 0.0), 0) for x in (0.0, 1.0)]
    goal = goal_from_request(
        GoalKind.FOLLOW_PATH, 7, request, lambda p: pose_from_msg(p.pose), REACH
    )
    assert goal.is_reverse is is_reverse


@pytest.mark.parametrize("text", ["abc", "-5", "1.5", "", "1 2", "9" * 13, "\u0663"])
def test_a_start_that_is_no_tick_is_refused(text):
    """It began at once, or never."""
    with pytest.raises(RejectedError, match="expected start_at_tick and the number of a control"):
        start_in(f"start_at_tick {text}")


def test_a_speed_limit_is_that_of_nav2_or_says_why_not():
    assert speed_limit_in(SpeedLimit(percentage=True, speed_limit=40.0)) == (40.0, True)
    assert speed_limit_in(SpeedLimit(speed_limit=0.0)) == (0.0, False)
    for percentage, limit, said in ((True, 140.0, "140 %"), (False, -1.0, "-1 m/s")):
        with pytest.raises(RejectedError, match=said):
            speed_limit_in(SpeedLimit(percentage=percentage, speed_limit=limit))
    with pytest.raises(RejectedError, match="nan"):
        speed_limit_in(SpeedLimit(speed_limit=float("nan")))
