"""What the canvas of *Plan* is told, and where a chain of waiting leads."""

import json
import math

import numpy as np
import pytest
import trimesh
from visualization_msgs.msg import Marker

from swarm_common.model.records import Pose
from swarm_view.page import plan
from swarm_view.page.plan import PlanView, head_of_chain, longest_chain
from swarm_view.scene.robot_mesh import RobotMesh
from swarm_view.state.decode import Raster, ReportedState
from swarm_view.state.swarm import Swarm


def said(state, detail="", station="", place=0):
    pose = Pose(0.0, 0.0, 0.0)
    return ReportedState(0, state, detail, pose, None, station, place, math.nan, 0.0, 0.0, 0, 0)


STATES = {
    "a": said("waiting", "for b, which is in the way"),
    "b": said("holding", "parked, waits for c: the first", "dock", 2),
    "c": said("driving", "", "dock"),
    "d": said("waiting", "for e, which is in the way", "dock", 1),
    "e": said("waiting", "for d, which is in the way"),
}


def test_the_longest_chain_ends_with_its_head():
    assert longest_chain(STATES) == ["a", "b", "c"]
    assert longest_chain({}) == []


@pytest.mark.parametrize(
    ("robot", "head", "sentence"),
    [
        ("a", "c", "c is driving to dock; 2 robots behind it."),
        ("c", "c", "c is driving to dock; 0 robot behind it."),
        ("d", "e", "e is waiting: for d, which is in the way; 1 robot behind it, in a circle."),
    ],
)
def test_a_chain_leads_to_its_head_and_says_what_that_one_does(robot, head, sentence):
    assert head_of_chain(robot, STATES) == (head, sentence)


def test_only_what_is_new_is_sent(monkeypatch):
    calls: list[str] = []
    monkeypatch.setattr(plan, "run_script", lambda _, source: calls.append(source))
    swarm = Swarm()
    swarm.names, swarm.states = list(STATES), dict(STATES)
    swarm.map = Raster(np.zeros((20, 40), np.int8), 0.1, (-1.0, -2.0))
    swarm.stations = {"dock": np.array([1.0, 0.5, 0.0])}
    box = trimesh.creation.box((0.6, 0.4, 0.2))
    mesh = RobotMesh(b"", {}, b"", (), (np.asarray(box.vertices), np.asarray(box.faces)))
    swarm.layout = np.array([[0.0, 1.0]]), np.array([[0.0, 1.0], [2.0, 1.0]])
    canvas = PlanView(None)

    def tell(robot=""):
        calls.clear()
        canvas.tell(swarm, {"a": mesh, "b": mesh}, robot, [], is_dark=False, names=False,
                    tubes=False)  # fmt: skip
        parts = (call.removeprefix("window.swarm.plan.").split("(", 1) for call in calls)
        return {name: json.loads(value[:-1]) for name, value in parts}

    first = tell()
    assert first["setCrew"]["kinds"] == [0, 0, -1, -1, -1]
    assert first["setCrew"]["shapes"][0]["radius"] == pytest.approx(math.hypot(0.3, 0.2), abs=1e-3)
    assert first["setCrew"]["shapes"][0]["inner"] == 0.2
    assert first["setStill"]["stations"] == [["dock", 1.0, 0.5]]
    assert first["setStill"]["layout"] == [[0, 1000], [0, 1000, 2000, 1000]]
    assert first["tell"]["waits"] == [[0, 1], [1, 2], [3, 4], [4, 3]]
    assert first["tell"]["chain"] == [0, 1, 2]
    assert first["tell"]["queues"] == [["dock", "d, b"]]
    assert tell() == {}
    assert list(tell("c")) == ["tell"]
    canvas.move(np.array([[1.0, 2.0, 0.5]]))
    canvas.move(np.array([[1.0, 2.0, 0.5]]))
    assert calls[-1] == "window.swarm.plan.move([1000,2000,500])"
    assert len(calls) == 2


def test_an_object_has_its_turned_outline():
    marker = Marker(type=Marker.CUBE, action=Marker.ADD, ns="object")
    marker.scale.x, marker.scale.y = 2.0, 1.0
    marker.pose.position.x = 5.0
    marker.pose.orientation.z = marker.pose.orientation.w = math.sqrt(0.5)
    drawn = plan._mover(marker)
    corners = np.array(drawn["points"]).reshape(-1, 2)
    np.testing.assert_allclose(np.ptp(corners, axis=0), [1000, 2000], atol=2)
    np.testing.assert_allclose(corners.mean(axis=0), [5000, 0], atol=2)
