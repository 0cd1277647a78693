"""What a page is made of, without a browser: links, the time line, messages, driving by hand."""

from unittest.mock import MagicMock

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from swarm_interfaces.msg import RobotStatus

from swarm_common.middleware.ros_io import time_msg
from swarm_common.model.records import Twist
from swarm_common.process.messages import KernelsCompiled
from swarm_view.page.driving import Driving
from swarm_view.page.inbox import LONGEST, numbers, parse
from swarm_view.page.panel_text import robot_html
from swarm_view.page.past import Past
from swarm_view.page.time_line import next_mark, strip_html
from swarm_view.state.decode import robot_state
from swarm_view.state.history import History, Kind, Mark
from swarm_view.state.link import Viewpoint, place_of
from swarm_view.state.swarm import Swarm
from swarm_view.viewer import Notice

MARKS = [
    Mark(5.0, Kind.GOAL, "Srobot1 reaches its goal"),
    Mark(10.0, Kind.COLLISION, "<b>robot</b> touches robot"),
    Mark(20.0, Kind.WAIT, "Srobot2 waits", "Srobot2", 90.0),
]


def test_a_link_brings_back_camera_robot_and_time():
    place = Viewpoint("Srobot3", np.array([[1.0, 2.0, 3.0], [4.0, 5.5, 0.0]]), 12.3, True)
    again = place_of(*(value for _, value in place.pairs()))
    assert (again.robot, again.time, again.is_dark) == ("Srobot3", 12.3, True)
    assert again.camera is not None
    np.testing.assert_allclose(again.camera, place.camera)


@pytest.mark.parametrize("camera", ["", "1,2", "1,2,3,4,5,x", "1,2,3,1,2,3", "nan,0,0,0,0,1"])
def test_what_is_no_camera_is_left_out(camera):
    assert place_of("", camera, "", "").camera is None
    assert place_of("", "", "inf", "").time is None


def test_the_past_has_marks_and_hatches_what_is_not_known():
    text = strip_html(MARKS, 0.0, 100.0, 42.0, is_live=False)
    assert "collisions 1" in text
    assert "near misses 0" in text
    assert "goals 1" in text
    assert "10.00%" in text
    assert "left:42.00%" in text
    assert "width:70.00%" in text
    assert "&lt;b&gt;robot" in text
    assert "<b>robot" not in text
    assert "Live" not in text
    assert "Live" in strip_html(MARKS, 0.0, 100.0, 42.0, is_live=True)
    text = strip_html(MARKS, 0.0, 100.0, 42.0, is_live=True, gaps=[(30.0, 50.0)])
    assert "30.0 s to 50.0 s: not known" in text
    assert "left:30.00%;width:20.00%" in text
    assert next_mark(MARKS, 0.0, 1) is MARKS[1]
    assert next_mark(MARKS, 10.0, 1) is MARKS[2]
    assert next_mark(MARKS, 20.0, -1) is MARKS[1]
    assert next_mark(MARKS, 10.0, -1) is None


def test_the_past_steps_over_what_is_not_known():
    history, swarm = History(), Swarm()
    for tick in (*range(0, 101), *range(500, 601)):
        if tick == 500:
            history.interrupt()
        history.add_poses(tick, ["Srobot1"], np.array([[0.1 * tick, 0.0, 0.0]]))
        if tick == 20:
            message = RobotStatus(stamp=time_msg(tick), robot="Srobot1", state="driving")
            history.add_status("Srobot1", robot_state(serialize_message(message)))
    past = Past(MagicMock(), swarm, history)
    past.fleet = MagicMock(names=[])
    assert past.go(30.0, 0.0)
    assert past.time == pytest.approx(10.0)  # from the present one comes to the beginning
    assert past.go(10.1, 0.0)
    assert past.time == pytest.approx(50.0)
    assert past.go(49.9, 0.0)
    assert past.time == pytest.approx(10.0)
    assert past.go(8.0, 0.0)
    text = robot_html("Srobot1", past.swarm.states, "/x", is_past=True)
    assert "(8.00, 0.00, 0.00)" in text  # where it was, not what it said last
    assert "estimate" not in text
    assert "to go" not in text
    past.is_playing = True
    past.play(0.0)
    past.play(3.0)
    assert past.time == pytest.approx(50.0)


def test_messages_of_the_page_are_read_with_care():
    assert parse('{"kind": "seek", "value": 3.5, "count": 1}') == ("seek", 3.5)
    for text in ("", "[]", "{", '{"kind": 3}', "[" * 1000, '{"kind":"' + "x" * LONGEST + '"}'):
        assert parse(text) is None
    assert numbers([1, 2.5], 2) == (1.0, 2.5)
    for value in ([1], [1, "x"], None, [1, float("nan")], [1, 1e30]):
        assert numbers(value, 2) is None


class Robot:
    """A robot that is driven."""

    def __init__(self):
        self.wishes: list[Twist] = []
        self.given_back = 0

    def begin_drive(self, robot, tell, on_end):
        self.end = on_end

    def full_speed(self, robot):
        return Twist(0.2, 0.0, 1.0)

    def wish(self, robot, twist):
        self.wishes.append(twist)

    def end_drive(self, robot):
        self.given_back += 1


def test_a_robot_stops_half_a_second_after_the_last_key():
    robot = Robot()
    driving = Driving(robot)
    driving.begin("Srobot1", lambda _: None, lambda: None)
    driving.steer(1.0, -3.0, 0.0)
    for now in (0.1, 0.3, 0.7, 0.9):
        driving.update(now)
    assert robot.wishes == [Twist(0.1, 0.0, -0.5)] * 2 + [Twist()] * 2
    driving.end()
    driving.update(1.0)
    assert robot.given_back == 1
    assert len(robot.wishes) == 4


def test_a_robot_that_takes_itself_back_is_driven_no_more():
    robot, ended = Robot(), []
    driving = Driving(robot)
    driving.begin("Srobot1", lambda _: None, lambda: ended.append(True))
    robot.end()
    assert ended == [True]
    assert driving.robot == ""
    driving.end()
    assert robot.given_back == 0


def test_a_page_says_that_the_swarm_is_starting_until_it_lives():
    said = [[], [KernelsCompiled(34, 118), KernelsCompiled(35, 118)], [], [], []]
    swarm, notice = Swarm(), Notice(lambda: said.pop(0))
    assert notice.text(swarm, is_paused=False) == "The swarm is starting."
    for _ in range(2):
        assert "35 of 118 kernels" in notice.text(swarm, is_paused=False)
    swarm.markers = []
    assert notice.text(swarm, is_paused=True) == ""
    swarm.tick = 1
    assert notice.text(swarm, is_paused=False) == ""
