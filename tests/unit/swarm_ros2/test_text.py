"""Messages as YAML text and back, and the statistics of `ros2 topic hz`."""

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowWaypoints
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from swarm_common.model.errors import SwarmError
from swarm_ros2 import text
from swarm_ros2.rate import RateMeter


def test_fields_keep_their_order_and_arrays_are_cut():
    lines = text.to_yaml(PoseStamped()).splitlines()
    assert lines[:5] == ["header:", "  stamp:", "    sec: 0", "    nanosec: 0", "  frame_id: ''"]
    scan = LaserScan(ranges=[1.0, 2.0, 3.0])
    assert text.to_plain(scan, longest=2)["ranges"] == [1.0, 2.0, "..."]
    assert text.to_plain(scan, arrays=False)["ranges"] == "<sequence type: float, length: 3>"
    assert text.to_plain(String(data="abcdef"), longest=3)["data"] == "abc..."
    assert text.to_plain(String(data="abc"), strings=False)["data"] == "<string length: <3>>"
    assert text.load("msg", "std_msgs/String") is String


def test_filling_nested_fields_and_arrays_of_messages():
    goal = FollowWaypoints.Goal()
    values = "{poses: [{header: {frame_id: map}, pose: {position: {x: 2}}}], number_of_loops: 3}"
    text.fill(goal, text.parse_values(values))
    assert goal.number_of_loops == 3
    assert goal.poses[0].header.frame_id == "map"
    assert goal.poses[0].pose.position.x == 2.0


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ("{position: 3}", "has no field 'position'; it has header, pose"),
        ("{pose: 3}", "pose: 3 is not a mapping"),
        ("{pose: {position: {x: near}}}", "x: could not convert string to float"),
        ("[1, 2]", "needs to be a dictionary"),
        ("{pose: [}", "is not YAML"),
    ],
)
def test_values_that_do_not_fit_are_named(values, message):
    with pytest.raises(SwarmError, match=message):
        text.fill(PoseStamped(), text.parse_values(values))


@pytest.mark.parametrize(
    "name", ["String", "std_msgs/srv/String", "std_msgs/msg/Sting", "no/msg/X"]
)
def test_unknown_types_are_refused(name):
    with pytest.raises(SwarmError, match="The passed message type is invalid"):
        text.load("msg", name)


def test_rate_meter_reports_once_per_news():
    meter = RateMeter()
    assert meter.report() is None
    for tick in range(5):
        meter.add(tick * 0.2)
    assert meter.report() == (
        "average rate: 5.000\n\tmin: 0.200s max: 0.200s std dev: 0.00000s window: 5"
    )
    assert meter.report() is None


def test_words_stay_words_and_only_times_are_stamped_at_sending():
    message, stamps = String(), []
    text.fill(message, {"data": "now"}, stamps)
    assert (message.data, stamps) == ("now", [])
    text.fill(message, {"data": "auto"})
    assert message.data == "auto"
    goal = FollowWaypoints.Goal()
    values = "{poses: [{header: auto}, {header: {stamp: now, frame_id: auto}}]}"
    text.fill(goal, text.parse_values(values), stamps)
    for stamp in stamps:
        stamp(Time(sec=7))
    assert [pose.header.stamp.sec for pose in goal.poses] == [7, 7]
    assert goal.poses[1].header.frame_id == "auto"


@pytest.mark.parametrize("values", ["{header: auto}", "{header: {stamp: now}}", "{header: now}"])
def test_services_and_actions_do_not_stamp(values):
    with pytest.raises(SwarmError, match="is not a mapping of"):
        text.fill(PoseStamped(), text.parse_values(values))
