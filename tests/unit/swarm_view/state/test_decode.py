import math

import pytest
from rclpy.serialization import serialize_message
from swarm_interfaces.msg import RobotStatus

from swarm_common.model.records import Pose
from swarm_view.state import decode


@pytest.mark.parametrize("robot", ["Srobot1", "Srobot10", "Srobot100", "r"])
@pytest.mark.parametrize("station", ["", "loader_1", "ä"])
def test_a_status_is_read_as_the_ros_serialiser_writes_it(robot, station):
    status = RobotStatus(robot=robot, state="driving", detail="to " + station, station=station)
    status.pose.x, status.pose.y, status.pose.theta = 1.0, 2.0, 0.5
    status.goal.x, status.goal.y, status.goal.theta = 3.0, 4.0, -0.5
    status.queue_place, status.goals_reached, status.goals_failed = 2, 5, 1
    status.distance_remaining, status.hold_time, status.wait_time = 1.5, 2.5, 3.5
    status.number_of_recoveries, status.pushes, status.replans = 7, 8, 9
    state = decode.robot_state(serialize_message(status))
    assert (state.state, state.detail, state.station) == ("driving", "to " + station, station)
    assert state.pose_map == Pose(1.0, 2.0, 0.5)
    assert state.goal_map == Pose(3.0, 4.0, -0.5)
    assert (state.queue_place, state.goals_reached, state.goals_failed) == (2, 5, 1)
    assert (state.distance_remaining, state.hold_time, state.wait_time) == (1.5, 2.5, 3.5)
    status.battery = 0.625
    data = serialize_message(status)
    assert decode.robot_state(data).battery == 0.625
    assert math.isnan(decode.robot_state(data[:-4]).battery)  # as earlier releases recorded it
    status.goal.x = math.nan
    assert decode.robot_state(serialize_message(status)).goal_map is None
    status.goal.x, status.state = 1.0, "driven by hand"  # its goal is its own place
    assert decode.robot_state(serialize_message(status)).goal_map is None
