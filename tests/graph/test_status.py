"""The bytes of a status are what the ROS serialiser reads."""

import dataclasses
import math

import pytest
from rclpy.serialization import deserialize_message
from swarm_interfaces.msg import RobotStatus

from swarm_common.model.records import Pose
from swarm_nav.core.goals import Status
from swarm_nav.ros.status import StatusWriter

STATUS = Status(
    state="holding", detail="waits for Srobot2", pose_map=Pose(1.5, -2.25, 0.5),
    goal_map=Pose(3.0, 4.0, -1.0), station="loader_3", queue_place=2, distance_remaining=1.25,
    estimated_time_remaining=7.5, holding_since_tick=123, hold_time=2.5, wait_time=0.75,
    number_of_recoveries=1, goals_reached=2, goals_failed=3, pushes=4, retreats=5,
    deadlocks_resolved=6, replans=7, battery=0.625,
)  # fmt: skip
SAME = {field.name for field in dataclasses.fields(Status)} - {
    "pose_map", "goal_map", "holding_since_tick",
    "reach",  # told in the report of a tick, to a courier
}  # fmt: skip


@pytest.mark.parametrize("robot", ["Srobot1", "Srobot42", "Srobot100"])
@pytest.mark.parametrize("detail", ["", "a", "stands: Srobot9 does not hear it", "näher"])
@pytest.mark.parametrize("station", ["", "loader_3"])
def test_status(robot, detail, station):
    status = dataclasses.replace(STATUS, detail=detail, station=station)
    message = deserialize_message(StatusWriter(robot).encode(456, status), RobotStatus)
    assert message.robot == robot
    assert (message.stamp.sec, message.stamp.nanosec) == (45, 600_000_000)
    assert (message.holding_since.sec, message.holding_since.nanosec) == (12, 300_000_000)
    assert {name: getattr(message, name) for name in SAME} == {
        name: getattr(status, name) for name in SAME
    }
    assert (message.pose.x, message.pose.y, message.pose.theta) == (1.5, -2.25, 0.5)
    assert (message.goal.x, message.goal.y, message.goal.theta) == (3.0, 4.0, -1.0)


def test_no_goal_is_nan():
    status = dataclasses.replace(STATUS, goal_map=None)
    message = deserialize_message(StatusWriter("Srobot1").encode(0, status), RobotStatus)
    assert math.isnan(message.goal.x)
