from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.model.palette import LOOKS
from swarm_view.page.panel_text import robot_html, stations_html, verdict_html, wait_chain
from swarm_view.scene.robot_mesh import robot_mesh
from swarm_view.state import topics
from swarm_view.state.swarm import Swarm
from swarm_view.state.topics import Layer
from tests.fakes.moving_feed import MovingFeed


def watch(feed, now, known, ticks=10):
    for _ in range(ticks):
        now[0] += 0.1
        known.apply(feed.take(), now[0])
    return known


@pytest.fixture(scope="module")
def swarm():
    now = [0.0]
    feed = MovingFeed(12, clock=lambda: now[0])
    feed.want(set(feed.topics()))
    known = Swarm()
    known.meet(topics.robots_in(feed.topics()))
    return watch(feed, now, known)


def test_robots_are_known_by_number_and_come_and_go(swarm):
    assert swarm.names == [f"Srobot{i}" for i in range(1, 13)]
    assert len(swarm.track.latest) == 12
    assert swarm.tick > 0
    now = [0.0]
    feed = MovingFeed(4, clock=lambda: now[0])
    feed.want(set(feed.topics()))
    known = watch(feed, now, Swarm(), 50)
    revision, trails = known.revision, len(known.trails.segments())
    assert trails > 0
    feed.let_be(["Srobot1", "Srobot3", "Srobot4", "Srobot9"])
    feed.want(set(feed.topics()))
    watch(feed, now, known)
    assert known.names == ["Srobot1", "Srobot3", "Srobot4", "Srobot9"]
    assert known.revision > revision
    assert set(known.states) == set(known.descriptions) == set(known.names)
    assert len(known.trails.segments()) > trails * 3 // 4
    feed.let_be([])
    watch(feed, now, known)
    assert known.names == []
    assert len(known.track.latest) == len(known.states) == len(known.trails.segments()) == 0


def test_messages_become_what_is_drawn(swarm):
    assert swarm.map is not None
    assert {marker.ns for marker in swarm.markers} >= {"body", "station", "circuit"}
    assert set(swarm.states) == set(swarm.names)
    version, scan = swarm.layer("Srobot2", Layer.SCAN)
    assert version > 0
    assert len(scan.ranges) == 360
    assert swarm.layer("Srobot2", Layer.SCAN)[1] is scan
    assert swarm.layer("Srobot2", Layer.PLAN) == (0, None)
    assert swarm.pose_at("Srobot2", scan.tick) is not None
    assert swarm.pose_at("Srobot99", 0) is None


def test_the_panel_says_what_is_known(swarm):
    text = verdict_html(swarm, True, "7 %")
    assert "(paused)" in text
    assert "66 reached, 0 tries failed" in text
    assert "0.110 m" in text
    assert "driving 2" in text
    assert "number 3 in the queue" in robot_html("Srobot4", swarm.states, "/x")
    moved = swarm.states["Srobot4"].pose_map
    text = robot_html("Srobot4", swarm.states, "/x", np.array([moved.x, moved.y + 0.5, 0]))
    assert "0.50 m off" in text
    assert "has said nothing" in robot_html("<b>", {}, "/x")
    assert "&lt;b&gt;" in robot_html("<b>", {}, "/x")
    assert "Srobot1 &larr; Srobot2" in stations_html(swarm.states)


def test_a_robot_says_for_whom_it_waits_and_that_one_for_whom(swarm):
    def waits(robot, other):
        return replace(swarm.states[robot], state="waiting", detail=f"for {other}, which turns")

    states = {
        **swarm.states,
        "Srobot1": waits("Srobot1", "Srobot2"),
        "Srobot2": waits("Srobot2", "Srobot7"),
    }
    assert wait_chain("Srobot1", states) == ["Srobot2", "Srobot7"]
    states["Srobot7"] = waits("Srobot7", "Srobot1")
    assert wait_chain("Srobot1", states) == ["Srobot2", "Srobot7", "Srobot1", "Srobot2"]
    text = robot_html("Srobot1", states, "/x", None, 10.0, 52.0)
    assert "waiting for 42 s" in text
    assert "data-swarm-text='Srobot7'" in text
    assert "for Srobot2, which turns" in text
    assert LOOKS["waiting"].meaning not in text  # one reason, the robot's own


def test_without_ground_truth_the_statuses_say_where_robots_are():
    now = [0.0]
    feed = MovingFeed(3, clock=lambda: now[0])
    feed.want({f"/{name}/status" for name in feed.names})
    known = Swarm()
    known.meet(feed.names)
    watch(feed, now, known)
    assert known.track.latest.shape == (3, 3)


def test_a_robot_is_drawn_from_its_description_or_without(swarm):
    mesh = robot_mesh(swarm.descriptions["Srobot1"])
    assert mesh.glb[:4] == b"glTF"
    assert 0.15 < radius_of(mesh) < 0.35
    assert 0.1 < mesh.shape[0][:, 2].max() < 0.3
    assert mesh.links["base_scan"][2, 3] == pytest.approx(0.132)
    mesh = robot_mesh("<robot name='r'><link name='base'/></robot>")
    assert radius_of(mesh) > 0.1
    assert np.allclose(mesh.links["base"], np.eye(4))


@settings(deadline=None)
@given(data=st.binary(max_size=400))
def test_what_cannot_be_read_is_not_drawn_and_ends_nothing(data):
    known = Swarm()
    names = ("status", "robot_description", "scan", "beacon", "plan", "particle_cloud")
    topics = ["/map", "/sim/tf", "/sim/scene", "/sim/movers", "/sim/verdict"]
    topics += [f"/Srobot1/{name}" for name in names]
    for head in (b"", b"\x00\x01\x00\x00", b"\x00\x00\x00\x00"):
        known.apply([(topic, head + data) for topic in topics], 0.0)
        for layer in Layer:
            known.layer("Srobot1", layer)
    assert known.unreadable > 0


def radius_of(mesh):
    """Return how far a robot reaches from its root link [m], seen from above."""
    return float(np.hypot(*mesh.shape[0][:, :2].T).max())
