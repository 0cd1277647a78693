"""Which statuses the operator's side believes."""

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Pose2D
from swarm_interfaces.msg import RobotStatus

from swarm_common.middleware.rejections import Rejections
from swarm_common.model.records import stamp_from_tick
from swarm_common.process.pipes import EventWriter
from swarm_run.robots.status_check import FASTEST, SLACK, StatusCheck

NAMES = ("Srobot1", "Srobot2", "Srobot3")


def status(name, tick):
    sec, nanosec = stamp_from_tick(tick)
    return RobotStatus(robot=name, stamp=Time(sec=sec, nanosec=nanosec))


@pytest.fixture
def rejections():
    return Rejections(EventWriter(None), lambda _: None)


@pytest.fixture
def door(rejections):
    door = StatusCheck(rejections)
    for name in NAMES:
        assert door.admits(name, status(name, 100), 50.0)
    return door


@pytest.mark.parametrize("ahead", [SLACK + 1, 36_000, 10_000_000])
def test_a_stamp_of_the_future_is_rejected_and_the_robot_goes_on(door, rejections, ahead):
    """At b11a34e its mission counted the goals of all others as failed: they were behind."""
    assert not door.admits("Srobot2", status("Srobot2", 100 + ahead), 50.0)
    assert rejections.counts == {"status": 1}
    for tick in (105, 110):
        assert all(door.admits(name, status(name, tick), 50.5) for name in NAMES)


def test_no_single_forger_moves_the_time_bit_by_bit(door):
    tick = 100
    for turn in range(100):
        tick += SLACK
        if not door.admits("Srobot2", status("Srobot2", tick), 50.0 + 0.01 * turn):
            break
    assert tick <= 100 + 2 * SLACK + FASTEST * 1.0


def test_a_swarm_may_be_fast_paused_or_down_to_one_robot(door):
    assert door.admits("Srobot1", status("Srobot1", 100 + 500), 51.0)  # 50 times real time
    assert door.admits("Srobot1", status("Srobot1", 601), 5000.0)
    for second in range(100):  # alone, the others are dead
        assert door.admits("Srobot1", status("Srobot1", 700 + 400 * second), 5001.0 + second)


def test_a_robot_whose_navigator_was_started_again_is_where_it_was(door):
    """A fleet control was told its initial pose, and its next order was refused: 14.7 m off."""
    there, start = Pose2D(x=5.0, y=4.8), Pose2D(x=-5.5, y=-5.5)
    for tick, pose, expected in ((110, there, there), (0, start, there), (0, start, there)):
        message = status("Srobot1", tick)
        message.pose = pose
        assert door.admits("Srobot1", message, 51.0)
        assert message.pose == expected
    newcomer = status("Srobot4", 0)
    newcomer.pose = start
    assert door.admits("Srobot4", newcomer, 51.0)
    assert newcomer.pose == start
