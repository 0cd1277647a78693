"""Poses in the frames of a robot's tree, and in no others."""

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from geometry_msgs.msg import PoseStamped

from swarm_common.model.records import Pose
from swarm_common.model.robot_parameters import frames_from_parameter, frames_parameter
from swarm_describe.robots.loading import fixed_frames
from swarm_nav.ros.nav2.goals import UnknownFrameError
from swarm_nav.ros.nav2.poses import pose_in_map

FRONT = Path(__file__).with_name("front_drive.urdf")
BRAIN: Any = SimpleNamespace(
    pose_map=Pose(3.0, 4.0, math.pi / 2.0), map_from_odom=Pose(1.0, 0.0, 0.0)
)
LINKS = {
    "base_footprint": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
    "base_link": (-0.15, 0.0, 0.06, 0.0, 0.0, 0.0, 1.0),
    "rear_laser": (-0.3, 0.0, 0.2, 0.0, 0.0, 1.0, 0.0),  # looks back
    "hung_laser": (0.1, 0.0, 0.2, 1.0, 0.0, 0.0, 0.0),  # upside down
    "optical": (0.2, 0.0, 0.3, -0.5, 0.5, -0.5, 0.5),  # z ahead, x to the right
}


def stamped(frame, x=0.0, y=0.0, z=0.0):
    message = PoseStamped()
    message.header.frame_id = frame
    place = message.pose.position
    place.x, place.y, place.z = x, y, z
    return message


@pytest.mark.parametrize(
    ("message", "wanted"),
    [
        (stamped("map", 1.0), (1.0, 0.0, 0.0)),
        (stamped("", 1.0), (1.0, 0.0, 0.0)),
        (stamped("odom", 1.0), (2.0, 0.0, 0.0)),
        (stamped("base_footprint", 1.0), (3.0, 5.0, math.pi / 2.0)),
        (stamped("base_link", 1.0), (3.0, 4.85, math.pi / 2.0)),
        (stamped("/base_link", 1.0), (3.0, 4.85, math.pi / 2.0)),
        (stamped("Srobot1/base_link", 1.0), (3.0, 4.85, math.pi / 2.0)),
        (stamped("Srobot1/odom", 1.0), (2.0, 0.0, 0.0)),
        (stamped("rear_laser", 1.0), (3.0, 2.7, -math.pi / 2.0)),
        (stamped("hung_laser", 1.0, 0.5), (3.5, 5.1, math.pi / 2.0)),
        (stamped("optical", 0.5, 0.0, 2.0), (3.5, 6.2, 0.0)),
    ],
)
def test_goals_are_brought_to_map(message, wanted):
    pose = pose_in_map(BRAIN, "Srobot1", LINKS, message)
    assert (pose.x, pose.y, pose.yaw) == pytest.approx(wanted)


@pytest.mark.parametrize("frame", ["base", "world", "Srobot2/base_link", "Srobot1/map", "Map"])
def test_other_frames_are_refused_with_the_known_ones(frame):
    with pytest.raises(UnknownFrameError, match="known: map, odom, base_footprint, base_link, rea"):
        pose_in_map(BRAIN, "Srobot1", LINKS, stamped(frame))


def test_shipped_robots_tell_their_fixed_links():
    """base_link of this robot lies behind the axle; wheels turn and are no frames of goals."""
    links = frames_from_parameter(frames_parameter(fixed_frames(FRONT)))
    assert links["base_link"][:3] == pytest.approx((-0.15, 0.0, 0.06))
    assert links["laser"][:3] == pytest.approx((-0.05, 0.0, 0.22))
    assert links["base_scan"][:3] == pytest.approx((-0.05, 0.0, 0.22))
    assert links["base_footprint"] == (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    assert "left_wheel" not in links
    assert fixed_frames("turtlebot3_waffle")["base_link"][2, 3] == pytest.approx(0.01)
