"""The brain on ideal unicycles: goals and how they end."""

import itertools
import math

import numpy as np
import pytest

from swarm_common.model.records import Pose, wrap_angle
from swarm_nav.core.goals import ErrorCode, GoalEnded, GoalKind, Outcome, PlanError, StateChanged
from tests.fakes.navigation import Squad, config, room

HALL = room(8.0, 8.0)
START = Pose(2.0, 2.0, 0.0)
GOAL = Pose(5.0, 4.0, 2.0)
FAR = Pose(6.5, 6.5, 0.0)
EAST = Pose(6.0, 2.0, 0.0)


def squad(pose=START, **changes):
    return Squad(HALL, [pose], config(**changes))


def drive_to_the_end(one, ticks=600):
    one.run_until(lambda: bool(one.ended(0)), ticks)
    return one.ended(0)[-1]


def test_a_goal_is_reached_in_place_and_heading_also_tightly_or_beside_a_wall():
    one = squad()
    one.send(0, GOAL, goal_id=7)
    end = drive_to_the_end(one)
    assert end == GoalEnded(7, Outcome.SUCCEEDED, one.tick - 1)
    assert one.distance(0, GOAL) <= 0.25
    assert abs(wrap_angle(one.bodies[0].pose.yaw - GOAL.yaw)) <= 0.25
    assert abs(one.bodies[0].twist.vx) < 0.02
    assert one.robots[0].services.goal_id is None
    one = squad(goal_checker__yaw_goal_tolerance=0.04)
    one.send(0, GOAL)
    assert drive_to_the_end(one).outcome is Outcome.SUCCEEDED
    assert abs(wrap_angle(one.bodies[0].pose.yaw - GOAL.yaw)) <= 0.045
    one = squad()
    one.send(0, Pose(4.0, 0.10, 0.0))  # 0.2 m too near: moved to the nearest free place
    assert drive_to_the_end(one).outcome is Outcome.SUCCEEDED
    assert one.distance(0, Pose(4.0, 0.10, 0.0)) < 0.5 + 0.25


def test_nobody_starts_before_having_listened():
    one = squad()
    one.send(0, GOAL)
    one.run(16)
    assert one.distance(0, START) == 0.0
    assert int(one.beacons[0]["held_size"]) == 1
    one.run(20)
    assert one.distance(0, START) > 0.02


def test_a_goal_in_the_future_starts_at_its_tick():
    one = squad()
    one.run(30)
    one.send(0, EAST, start_tick=50)
    assert one.robots[0].services.goal_id == 0
    one.run(20)
    assert not one.events[0]
    one.run(1)
    assert one.events[0] == [StateChanged("driving", 50)]


def test_a_robot_pauses_between_a_goal_that_it_reached_and_the_next_one():
    """It was idle in report and viewer, whose legends call this pausing."""
    one = squad()
    one.run(30)
    one.send(0, EAST, start_tick=40)
    one.run(5)
    assert one.robots[0].status().state == "idle"  # it has not been anywhere yet
    one.run_until(lambda: bool(one.ended(0)), 600)
    assert one.robots[0].status().state == "idle"
    due = one.tick + 30
    one.send(0, START, goal_id=2, start_tick=due)
    one.run(1)
    assert one.robots[0].status().state == "pausing"
    one.run_until(lambda: one.tick > due, 40)
    assert one.robots[0].status().state == "driving"


def test_a_new_goal_preempts_the_one_in_hand():
    one = squad()
    one.send(0, FAR, goal_id=1)
    one.run(60)
    one.send(0, EAST, goal_id=2)
    assert drive_to_the_end(one).outcome is Outcome.CANCELED
    assert "preempted" in one.ended(0)[0].message
    one.run_until(lambda: len(one.ended(0)) == 2, 500)
    assert [(e.goal_id, e.outcome) for e in one.ended(0)] == [
        (1, Outcome.CANCELED), (2, Outcome.SUCCEEDED),
    ]  # fmt: skip
    assert one.distance(0, EAST) < 0.25


@pytest.mark.parametrize("after", [0, 5, 60])
def test_a_canceled_goal_ends_and_the_robot_stops(after):
    one = squad()
    one.send(0, FAR, goal_id=3)
    one.run(after)
    one.robots[0].services.cancel_goal()
    one.run(10)
    assert [(e.goal_id, e.outcome) for e in one.ended(0)] == [(3, Outcome.CANCELED)]
    assert abs(one.bodies[0].twist.vx) < 1e-6
    one.robots[0].services.cancel_goal()  # nothing in hand: nothing happens
    one.run(1)
    assert len(one.ended(0)) == 1


@pytest.mark.parametrize(
    ("goal", "code"), [(Pose(20.0, 2.0, 0.0), 204), (Pose(math.pi, 4.0, 0.0), 206)]
)
def test_an_impossible_goal_ends_at_once_with_nav2s_code(goal, code):
    one = Squad(room(8.0, 8.0, (2.0, 3.0, 5.0, 5.0)), [START])
    one.send(0, goal)
    end = drive_to_the_end(one, 40)
    assert (end.outcome, end.error_code) == (Outcome.ABORTED, code)
    assert end.message
    assert one.robots[0].status().goals_failed == 1


def test_a_goal_without_a_way_on_the_map_ends_without_a_recovery():
    split = room(8.0, 8.0, (4.0, 0.0, 4.15, 8.0))
    one = Squad(split, [START], config(progress_checker__number_of_retries=2))
    one.send(0, FAR)
    end = drive_to_the_end(one, 400)
    assert end.error_code is ErrorCode.NO_VALID_PATH
    assert one.robots[0].status().number_of_recoveries == 0


@pytest.mark.parametrize(
    ("kind", "code"),
    [
        (GoalKind.WAYPOINTS, ErrorCode.WAYPOINTS_UNKNOWN),
        (GoalKind.THROUGH, ErrorCode.NO_VIAPOINTS_GIVEN),
        (GoalKind.FOLLOW_PATH, ErrorCode.INVALID_PATH),
    ],
)
def test_a_goal_without_poses_ends_with_the_code_of_its_action(kind, code):
    one = squad()
    one.send(0, kind=kind)
    end = drive_to_the_end(one, 5)
    assert (end.outcome, end.error_code) == (Outcome.ABORTED, code)


def test_waypoints_are_reached_in_turn_and_the_missed_one_is_named():
    one = Squad(room(8.0, 8.0, (4.0, 4.0, 5.0, 8.0)), [START])
    one.send(0, EAST, Pose(4.5, 6.5, 0.0), Pose(6.0, 5.0, 1.0), kind=GoalKind.WAYPOINTS)
    visited: list[float] = []
    while not one.ended(0) and one.tick < 1500:
        one.run(1)
        visited.append(one.distance(0, EAST))
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert one.ended(0)[0].missed_waypoints == ((1, ErrorCode.GOAL_OCCUPIED),)
    assert min(visited) < 0.25
    assert one.distance(0, Pose(6.0, 5.0, 1.0)) < 0.25


def test_waypoints_are_repeated_for_each_loop_from_the_first_on():
    one = squad()
    near = Pose(3.0, 2.0, math.nan)
    one.send(0, near, Pose(2.0, 2.0, math.nan), kind=GoalKind.WAYPOINTS, loops=1)
    turns = 0
    previous = 0
    while not one.ended(0) and one.tick < 1500:
        one.run(1)
        feedback = one.robots[0].services.feedback()
        current = feedback.current_waypoint if feedback is not None else previous
        turns += current != previous
        previous = current
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert turns == 3
    one = squad()
    poses = (Pose(3.0, 2.0, math.nan), Pose(20.0, 2.0, math.nan), Pose(3.0, 3.0, math.nan))
    one.send(0, *poses, kind=GoalKind.WAYPOINTS, loops=1, first_index=2)
    visited: list[int] = []
    while not one.ended(0) and one.tick < 1500:
        one.run(1)
        feedback = one.robots[0].services.feedback()
        if feedback is not None and feedback.current_waypoint not in visited[-1:]:
            visited.append(feedback.current_waypoint)
    assert one.ended(0)[0].missed_waypoints == ((1, ErrorCode.GOAL_OUTSIDE_MAP),)
    assert [index for index in visited if index != 1] == [2, 0, 2]


def test_intermediate_poses_are_driven_through():
    one = squad()
    one.send(0, Pose(4.0, 2.5, 1.0), EAST, kind=GoalKind.THROUGH)
    one.run(40)
    feedback = one.robots[0].services.feedback()
    assert feedback.poses_remaining == 2
    speeds, nearest = [], 9.0
    while not one.ended(0) and one.tick < 600:
        one.run(1)
        nearest = min(nearest, one.distance(0, Pose(4.0, 2.5, 1.0)))
        if one.distance(0, EAST) > 1.0:
            speeds.append(one.bodies[0].twist.vx)
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert nearest <= 0.75
    assert np.mean(np.array(speeds) > 0.1) > 0.7  # at most a turn on the spot


def detour():
    legs = [(2.0, 2.0), (2.0, 5.5), (5.5, 5.5), (5.5, 2.0)]
    pieces = [np.linspace(a, b, 70, endpoint=False) for a, b in itertools.pairwise(legs)]
    return np.vstack((*pieces, legs[-1]))


def test_a_given_path_is_followed_unless_it_leads_through_a_wall():
    one = squad()
    path = detour()
    one.send(0, kind=GoalKind.FOLLOW_PATH, path_map=path)
    worst = 0.0
    while not one.ended(0) and one.tick < 900:
        one.run(1)
        here = one.bodies[0].pose
        worst = max(worst, float(np.hypot(*(path - (here.x, here.y)).T).min()))
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert worst < 0.12
    one = Squad(room(8.0, 8.0, (4.0, 0.0, 4.15, 5.0)), [START])
    straight = np.linspace((2.0, 2.0), (6.0, 2.0), 60)
    one.send(0, kind=GoalKind.FOLLOW_PATH, path_map=straight)
    end = drive_to_the_end(one, 900)
    assert end.outcome is Outcome.ABORTED
    assert end.error_code in (ErrorCode.NO_VALID_CONTROL, ErrorCode.FAILED_TO_MAKE_PROGRESS)
    assert one.bodies[0].pose.x < 3.8


def test_a_given_path_is_followed_backwards_if_that_is_asked_for():
    one = squad()
    one.send(0, Pose(6.0, 2.0, 0.0))
    one.run_until(lambda: one.bodies[0].twist.vx > 0.1, 100)  # it stops before it drives back
    x = one.bodies[0].pose.x
    legs = [np.linspace((x, 2.0), (x, 5.0), 60), np.linspace((x, 5.0), (5.0, 5.0), 60)]
    path = np.vstack(legs)
    one.send(0, kind=GoalKind.FOLLOW_PATH, path_map=path, is_reverse=True)
    worst, speeds = 0.0, []
    while not one.ended(0)[1:] and one.tick < 900:
        one.run(1)
        here, twist = one.bodies[0].pose, one.bodies[0].twist
        speeds.append(twist.vx)
        worst = max(worst, float(np.hypot(*(path - (here.x, here.y)).T).min()))
    assert one.ended(0)[1].outcome is Outcome.SUCCEEDED
    assert worst < 0.3
    still = next(k for k, speed in enumerate(speeds) if speed < 0.01)
    assert max(speeds[still:]) < 0.01
    assert min(speeds) < -0.1
    assert abs(one.bodies[0].pose.yaw) > 2.8  # it came from the west


@pytest.mark.parametrize(
    ("kind", "fields", "moved"),
    [
        (GoalKind.SPIN, {"angle": 1.57}, 0.0),
        (GoalKind.BACKUP, {"distance": 0.3, "speed": 0.15}, 0.3),
        (GoalKind.DRIVE_ON_HEADING, {"distance": 0.5, "speed": 0.2}, 0.5),
        (GoalKind.WAIT, {"duration": 2.0}, 0.0),
    ],
)
def test_behaviours_are_goals_too(kind, fields, moved):
    one = squad()
    one.run(20)
    one.send(0, kind=kind, goal_id=4, **fields)
    end = drive_to_the_end(one, 200)
    assert (end.goal_id, end.outcome) == (4, Outcome.SUCCEEDED)
    assert one.distance(0, START) == pytest.approx(moved, abs=0.07)


def test_feedback_counts_down_to_the_goal():
    one = squad()
    assert one.robots[0].services.feedback() is None
    one.send(0, EAST, goal_id=5)
    one.run(30)
    first = one.robots[0].services.feedback()
    one.run(60)
    later = one.robots[0].services.feedback()
    assert first.goal_id == 5
    assert first.distance_remaining == pytest.approx(4.0, abs=0.3)
    assert later.distance_remaining < first.distance_remaining - 1.0
    assert later.navigation_time == pytest.approx(first.navigation_time + 6.0)
    assert later.estimated_time_remaining == pytest.approx(later.distance_remaining / 0.26)


def test_plans_can_be_asked_for_without_driving():
    robot = squad().robots[0]
    path = robot.services.make_plan(None, [GOAL, FAR])
    assert np.allclose(path[0], (START.x, START.y))
    assert np.hypot(*(path - (GOAL.x, GOAL.y)).T).min() < 1e-6
    assert np.allclose(path[-1], (FAR.x, FAR.y))
    assert len(robot.services.make_plan(Pose(1.0, 1.0, 0.0), [])) == 0
    with pytest.raises(PlanError) as error:
        robot.services.make_plan(Pose(-1.0, 0.0, 0.0), [GOAL])
    assert error.value.code is ErrorCode.START_OUTSIDE_MAP
