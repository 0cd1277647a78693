"""Our CDR bytes are what the ROS serialiser writes and reads."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped as PoseMsg
from geometry_msgs.msg import Twist as TwistMsg
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry as OdometryMsg
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from swarm_common.middleware import cdr
from swarm_common.middleware.ros_io import pose_from_msg
from swarm_common.model.records import Pose, Scan, Twist

POSE, TWIST = Pose(1.25, -2.5, 0.75), Twist(0.25, 0.0, -0.5)


@pytest.mark.parametrize("frame", ["odom", "o", "a_longer_name", "näme"])
@pytest.mark.parametrize("child", ["base_footprint", "base", ""])
def test_odometry(frame, child):
    data = cdr.OdometryWriter(frame, child).encode(123, POSE, TWIST)
    message = deserialize_message(data, OdometryMsg)
    assert (message.header.frame_id, message.child_frame_id) == (frame, child)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 300_000_000)
    assert message.pose.pose.position.y == POSE.y
    assert message.twist.twist.angular.z == TWIST.wz
    reader = cdr.OdometryReader()
    reader.read(cdr.OdometryWriter("other", child).encode(1, Pose(0.0, 0.0, 0.0), TWIST))
    odom = reader.read(serialize_message(message))
    assert (odom.tick, odom.twist) == (123, TWIST)
    assert odom.pose_odom.yaw == pytest.approx(POSE.yaw)


@pytest.mark.parametrize("frame", ["map", "m", "a_longer_name"])
def test_pose_with_covariance(frame):
    writer = cdr.CovariantPoseWriter(frame)
    writer.encode(1, Pose(0.0, 0.0, 0.0), (9.0, 9.0, 9.0))
    message = deserialize_message(writer.encode(123, POSE, (0.1, 0.2, 0.3)), PoseMsg)
    assert message.header.frame_id == frame
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 300_000_000)
    assert (message.pose.pose.position.x, message.pose.pose.position.y) == (POSE.x, POSE.y)
    assert pose_from_msg(message.pose.pose).yaw == pytest.approx(POSE.yaw)
    assert {i: v for i, v in enumerate(message.pose.covariance) if v} == {0: 0.1, 7: 0.2, 35: 0.3}


def test_scan():
    ranges = np.linspace(0.1, 3.0, 7, dtype=np.float32)
    ranges[3] = math.inf
    scan = Scan(4, -1.0, 0.25, 0.125, 3.5, ranges)
    message = deserialize_message(cdr.ScanWriter("base_scan", 0.2).encode(scan), LaserScan)
    assert message.header.frame_id == "base_scan"
    assert message.angle_max == pytest.approx(-1.0 + 6 * 0.25)
    assert list(message.ranges) == list(ranges)
    message.intensities = [1.0] * 7
    again = cdr.read_scan(serialize_message(message))
    assert (again.tick, again.angle_min, again.range_max) == (4, -1.0, 3.5)
    np.testing.assert_array_equal(again.ranges, ranges)


@pytest.mark.parametrize("frame", ["", "base_link", "b"])
def test_command(frame):
    message = deserialize_message(cdr.CommandWriter(frame).encode(9, TWIST), TwistStamped)
    assert message.header.frame_id == frame
    assert message.twist.linear.x == TWIST.vx
    assert cdr.CommandReader().read(serialize_message(message)) == (9, TWIST)


def test_plain_command():
    message = TwistMsg()
    message.linear.x, message.angular.z = TWIST.vx, TWIST.wz
    assert cdr.read_plain_command(serialize_message(message)) == TWIST


def test_a_message_that_is_no_plain_cdr_is_refused():
    with pytest.raises(ValueError, match="plain CDR"):
        cdr.read_tick(b"\x00\x03\x00\x00" + bytes(20))


@pytest.mark.parametrize("names", [[], ["a"], ["Srobot9/base", "Srobot10/base", "näme"]])
def test_transforms(names):
    writer = cdr.TransformsWriter("map", names)
    poses = np.array([[i + 0.5, -i, 0.25 * i] for i in range(len(names))]).reshape(-1, 3)
    writer.encode(7, np.ones_like(poses))
    data = writer.encode(123, poses)
    message = deserialize_message(data, TFMessage)
    assert [item.child_frame_id for item in message.transforms] == names
    reader = cdr.TransformsReader()
    for copy in (data, serialize_message(message), data):
        tick, found, values = reader.read(copy)
        assert tick == (123 if names else 0)
        assert found == names
        assert values == pytest.approx(poses)
    others = [f"other_{name}" for name in names] + ["one more"]
    again = cdr.TransformsWriter("map", others).encode(124, np.ones((len(others), 3)))
    assert reader.read(again)[:2] == (124, others)
    assert reader.read(data)[1] == names
