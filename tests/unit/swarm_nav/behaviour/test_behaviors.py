"""Spin, back up, drive on heading and wait on an ideal unicycle."""

import math

import pytest

from swarm_common.model.records import Pose, Twist, wrap_angle
from swarm_nav.behaviour.behaviors import Behavior, BehaviorEnd, recovery_goal
from swarm_nav.control.controller import Controller
from swarm_nav.core.config import ControllerConfig
from swarm_nav.core.goals import ErrorCode, Goal, GoalKind
from tests.fakes.decisions import step
from tests.fakes.navigation import Squad, Unicycle, robot_in, room

HALL = room(6.0, 6.0)
MIDDLE = Pose(3.0, 3.0, 0.0)


def perform(goal, pose=MIDDLE, ticks=200):
    """Run a behaviour with all of its path held; return its end, the robot and the speeds."""
    s = robot_in(HALL, pose)
    body, controller = Unicycle(pose), Controller(ControllerConfig())
    behavior = Behavior(goal, s)
    speeds = []
    for _ in range(ticks):
        s.tick += 1
        s.pose, s.twist = body.pose, body.twist
        command = step(behavior, s, controller)
        s.tube.stop = len(s.tube.points) - 1
        if behavior.end is not None:
            return behavior.end, body, speeds
        speeds.append(command.vx)
        body.step(command)
    raise AssertionError(f"{goal.kind} did not end")


@pytest.mark.parametrize("angle", [1.57, -1.57, 3.0, 7.0, -7.0])
def test_a_spin_turns_by_its_angle_on_the_spot(angle):
    end, body, _ = perform(Goal(kind=GoalKind.SPIN, angle=angle))
    assert end.code is ErrorCode.NONE
    assert abs(wrap_angle(body.pose.yaw - angle)) < 0.1
    assert body.pose.distance(MIDDLE) < 0.01


def test_backing_up_goes_straight_back_and_does_not_turn_about():
    end, body, speeds = perform(Goal(kind=GoalKind.BACKUP, distance=0.3, speed=0.15))
    assert end.code is ErrorCode.NONE
    assert body.pose.x == pytest.approx(2.7, abs=0.06)
    assert max(speeds) <= 0.0
    assert abs(body.pose.yaw) < 0.05
    # It turned by itself, to drive what was left of its path forwards.
    squad = Squad(HALL, [MIDDLE])
    squad.send(0, kind=GoalKind.BACKUP, distance=0.3, speed=0.1)
    squad.run_until(lambda: bool(squad.ended(0)), 100)
    yaws = []
    for _ in range(40):
        squad.run(1)
        yaws.append(squad.bodies[0].pose.yaw)
    assert max(map(abs, yaws)) < 0.05
    s = robot_in(HALL, MIDDLE)
    s.twist = Twist(0.2, 0.0, 0.0)
    behavior = Behavior(Goal(kind=GoalKind.BACKUP, distance=0.3, speed=0.1), s)
    assert step(behavior, s, Controller(ControllerConfig())) == Twist()
    assert len(s.tube.points) == 1


def test_driving_on_goes_straight_ahead_or_back():
    end, body, _ = perform(
        Goal(kind=GoalKind.DRIVE_ON_HEADING, distance=0.5, speed=0.2), Pose(3.0, 3.0, 1.2)
    )
    assert end.code is ErrorCode.NONE
    assert body.pose.distance(Pose(3.0, 3.0, 1.2)) == pytest.approx(0.5, abs=0.06)
    assert body.pose.yaw == pytest.approx(1.2, abs=0.05)
    end, body, speeds = perform(
        Goal(kind=GoalKind.DRIVE_ON_HEADING, distance=0.3, speed=0.15, is_reverse=True)
    )
    assert end.code is ErrorCode.NONE
    assert body.pose.x == pytest.approx(2.7, abs=0.06)
    assert max(speeds) <= 0.0


@pytest.mark.parametrize("kind", [GoalKind.BACKUP, GoalKind.DRIVE_ON_HEADING])
def test_the_asked_speed_is_not_exceeded(kind):
    _, _, speeds = perform(Goal(kind=kind, distance=0.5, speed=0.1))
    assert max(abs(v) for v in speeds) == pytest.approx(0.1, abs=0.01)


@pytest.mark.parametrize(
    ("kind", "pose", "code"),
    [
        (GoalKind.BACKUP, Pose(0.5, 3.0, 0.0), ErrorCode.BACKUP_COLLISION_AHEAD),
        (GoalKind.DRIVE_ON_HEADING, Pose(5.5, 3.0, 0.0), ErrorCode.DRIVE_COLLISION_AHEAD),
    ],
)
def test_a_wall_in_the_way_is_seen_before_the_first_move(kind, pose, code):
    end, body, speeds = perform(Goal(kind=kind, distance=1.0, speed=0.2), pose)
    assert end.code is code
    assert not speeds
    assert body.pose == pose


@pytest.mark.parametrize(
    ("kind", "code"),
    [
        (GoalKind.BACKUP, ErrorCode.BACKUP_TIMEOUT),
        (GoalKind.DRIVE_ON_HEADING, ErrorCode.DRIVE_TIMEOUT),
    ],
)
def test_a_drive_may_take_its_time_allowance_only(kind, code):
    end, _, _ = perform(Goal(kind=kind, distance=2.0, speed=0.2, duration=1.0))
    assert end.code is code


def test_waiting_takes_as_long_as_asked_and_does_not_move():
    end, body, speeds = perform(Goal(kind=GoalKind.WAIT, duration=2.0))
    assert end.code is ErrorCode.NONE
    assert len(speeds) == pytest.approx(20, abs=1)
    assert body.pose == MIDDLE


def test_recoveries_come_in_nav2s_order():
    s = robot_in(HALL, MIDDLE)
    goals = [recovery_goal(attempt, s) for attempt in range(5)]
    assert [goal and goal.kind for goal in goals] == [
        None, GoalKind.BACKUP, GoalKind.SPIN, GoalKind.WAIT, None,
    ]  # fmt: skip
    backup, spin, wait = goals[1:4]
    assert (backup.distance, backup.speed) == (0.30, 0.15)
    assert spin.angle == pytest.approx(math.pi / 2, abs=1e-3)
    assert wait.duration == 5.0


def test_a_drive_goes_on_with_the_rest_after_the_robot_made_way():
    s = robot_in(HALL, MIDDLE)
    body, controller = Unicycle(MIDDLE), Controller(ControllerConfig())
    behavior = Behavior(Goal(kind=GoalKind.DRIVE_ON_HEADING, distance=1.0, speed=0.2), s)
    for tick in range(200):
        s.tick += 1
        if tick == 20:
            driven = body.pose.x - 3.0
            body = Unicycle(Pose(4.0, 4.0, 0.3))  # pushed aside
            s.pose, s.twist = body.pose, body.twist
            s.tube.reset(s.pose)
            behavior.resume(s)
        s.pose, s.twist = body.pose, body.twist
        command = step(behavior, s, controller)
        s.tube.stop = len(s.tube.points) - 1
        if behavior.end is not None:
            break
        body.step(command)
    assert behavior.end == BehaviorEnd()
    assert driven + body.pose.distance(Pose(4.0, 4.0, 0.3)) == pytest.approx(1.0, abs=0.08)
