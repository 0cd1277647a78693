"""What a robot's status means for a fleet control."""

import math

import pytest
from swarm_interfaces.msg import RobotStatus

from swarm_common.model.records import Pose
from swarm_vda5050.pilot import _information, _velocity

NAMES = ("ann", "Srobot2")


@pytest.mark.parametrize(
    ("state", "detail", "others"),
    [
        ("waiting", "for ann, which drives", ["ann"]),
        ("yielding", "makes way for Srobot2, waits for ann, which stands", ["Srobot2", "ann"]),
        ("holding", "parked, waits for Srobot2: the narrow region ahead is full", ["Srobot2"]),
        ("holding", "parked, waits for room on the single lanes at dock", []),
        ("yielding", "leaves for others", []),
        ("waiting", "before an obstacle", []),
        ("driving", "", []),
    ],
)
def test_a_robot_that_waits_says_for_whom(state, detail, others):
    (info,) = _information(RobotStatus(state=state, detail=detail), NAMES)
    assert [each.reference_value for each in info.info_references or ()] == others
    assert info.info_type == state.upper()


def test_velocities_are_in_the_frame_of_the_robot():
    velocity = _velocity(Pose(0.0, 0.0, math.pi / 2), Pose(0.0, 1.0, math.pi / 2), 2.0)
    assert (velocity.vx, velocity.vy, velocity.omega) == (0.5, 0.0, 0.0)
    assert _velocity(Pose(0.0, 0.0, 3.0), Pose(0.0, 0.0, -3.0), 1.0).omega > 0.0
