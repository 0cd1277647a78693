"""What the viewer remembers of a run: marks, states, curves, places."""

from dataclasses import replace

import numpy as np
import pytest
from swarm_interfaces.msg import Verdict

from swarm_common.middleware import ros_io
from swarm_common.model.records import Pose
from swarm_view.state.decode import ReportedState
from swarm_view.state.history import History, Kind

IDLE = ReportedState(0, "idle", "", Pose(0.0, 0.0, 0.0), None, "", 0, 0.0, 0.0, 0.0, 0, 0)


def said(tick, state, detail="", **values):
    return replace(IDLE, tick=tick, state=state, detail=detail, **values)


def verdict(tick, robots=0, world=0, near=0):
    message = Verdict(stamp=ros_io.time_msg(tick), min_clearance=0.2 - 0.001 * tick)
    message.collisions_robot_robot, message.collisions_robot_world = robots, world
    message.near_misses = near
    return message


def texts(history, kind):
    return [(round(mark.time, 1), mark.text) for mark in history.marks if mark.kind is kind]


def test_what_takes_long_is_marked_from_its_beginning():
    history = History()
    for tick in range(0, 1500, 5):
        state = "driving" if tick < 100 or tick >= 1200 else "waiting" if tick % 2 else "yielding"
        history.add_status("Srobot1", said(tick, state, f"for Srobot{2 + tick % 3}"))
        history.add_status("Srobot2", said(tick, "holding" if tick < 500 else "driving"))
    (mark,) = [mark for mark in history.marks if mark.kind is Kind.WAIT]
    assert mark.robot == "Srobot1"
    assert (mark.time, mark.end) == pytest.approx((10.0, 119.5))
    history = History()
    history.add_status("Srobot1", said(470, "idle"))
    since = history.state_since("Srobot1", 91.0)
    assert since == pytest.approx(47.0)
    assert not history.saw_begin("Srobot1", 47.0)
    history.add_status("Srobot1", said(500, "driving"))
    assert history.saw_begin("Srobot1", 50.0)
    history.add_status("Srobot2", said(600, "idle"))  # it came later
    assert history.saw_begin("Srobot2", 60.0)


def test_goals_faults_collisions_and_near_misses_are_marked():
    history = History()
    history.add_status("Srobot1", said(0, "driving", station="loader_1"))
    history.add_status("Srobot1", said(10, "idle", goals_reached=1))
    history.add_status("Srobot1", said(20, "recovering", "lost", goals_reached=1))
    history.add_status("Srobot1", said(30, "recovering", "lost", goals_reached=1, goals_failed=1))
    history.add_status("Srobot1", said(40, "inactive", goals_reached=1, goals_failed=1))
    assert texts(history, Kind.GOAL) == [(1.0, "Srobot1 reaches its goal at loader_1")]
    assert [time for time, _ in texts(history, Kind.FAULT)] == [2.0, 3.0, 4.0]
    assert history.span == (0.0, 4.0)
    history = History()
    poses = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [5.0, 0.0, 0.0]])
    history.add_poses(40, ["Srobot1", "Srobot2", "Srobot3"], poses)
    for message in (verdict(10), verdict(50, near=1), verdict(60, robots=1, near=1)):
        history.add_verdict(message)
    history.add_verdict(verdict(70, robots=1, world=2, near=1))
    assert texts(history, Kind.NEAR_MISS) == [
        (5.0, "near miss; nearest to each other: Srobot1 and Srobot2")
    ]
    assert [time for time, _ in texts(history, Kind.COLLISION)] == [6.0, 7.0]
    assert texts(history, Kind.COLLISION)[1][1] == "2 x robot touches the world"


def test_states_and_places_of_the_past_are_known():
    history = History()
    for tick in range(101):
        history.add_poses(tick, ["Srobot1"], np.array([[0.1 * tick, 0.0, 0.0]]))
    history.add_status("Srobot1", said(0, "driving"))
    history.add_status("Srobot1", said(40, "waiting", "for Srobot2"))
    history.add_status("Srobot1", said(60, "waiting", "for Srobot3"))
    moment = history.moment(5.04)
    assert moment[0] == 50
    assert moment[2][0, 0] == pytest.approx(5.0)
    state = history.state_at("Srobot1", 5.0)
    assert state.detail == "for Srobot2"
    assert history.state_since("Srobot1", 9.0) == pytest.approx(4.0)
    assert [change.state.state for change in history.changes("Srobot1", 9.0, 5)] == [
        "waiting",
        "driving",
    ]
    assert history.state_at("Srobot1", -1.0) is None
    assert history.state_at("Srobot9", 5.0) is None
    way = history.way("Srobot1", 5.0, 0.25)
    assert way[-1, 0] <= 5.0
    assert np.diff(way[:, 0]).min() >= 0.25


def test_curves_over_time():
    history = History()
    for tick in range(0, 1201, 10):
        reached = tick // 100
        history.add_status("Srobot1", said(tick, "driving", goals_reached=reached))
        history.add_status("Srobot2", said(tick, "driving" if tick < 600 else "holding"))
        history.add_verdict(verdict(min(tick, 150)))
    times, rates = history.throughput()
    assert rates[times == 100.0] == pytest.approx(6.0)  # a goal every ten seconds
    times, counts = history.states(["driving", "holding"])
    assert times.tolist()[:3] == [0.0, 5.0, 10.0]
    assert counts[:, times == 50.0].ravel().tolist() == [2.0, 0.0]
    assert counts[:, times == 100.0].ravel().tolist() == [1.0, 1.0]
    times, gaps = history.clearance()
    assert len(times) == len(gaps) == 121
    assert gaps[0] == pytest.approx(0.2)


def test_of_the_time_while_no_page_was_open_only_the_goals_count():
    history = History()
    history.interrupt()  # the first page opens late, too
    history.add_verdict(verdict(100, robots=1))
    history.add_status("Srobot1", said(100, "waiting"))
    history.interrupt()
    history.add_verdict(verdict(2000, robots=3, near=2))
    history.add_status("Srobot1", said(2000, "waiting", goals_reached=4, goals_failed=1))
    unseen = [mark.time for mark in history.marks if mark.kind is Kind.GOAL]
    assert unseen == pytest.approx([48.0, 86.0, 124.0, 162.0])
    assert len(history.marks) == 4
    history.add_verdict(verdict(2100, robots=3, near=3))
    history.add_status("Srobot1", said(2100, "driving", goals_reached=5, goals_failed=1))
    assert [(mark.kind, mark.time) for mark in history.marks[4:]] == [
        (Kind.NEAR_MISS, 210.0), (Kind.GOAL, 210.0)
    ]  # fmt: skip
    assert history.gaps == [(10.0, 200.0)]
    assert history.gap_at(150.0) == (10.0, 200.0)
    assert history.gap_at(200.0) is None
