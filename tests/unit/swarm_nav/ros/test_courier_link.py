"""A robot's end of its link to its courier."""

from types import SimpleNamespace
from typing import Any

from swarm_common.middleware.courier_io import TickRelease, packed
from swarm_common.middleware.rejections import Rejections
from swarm_common.model.records import Pose
from swarm_common.process.pipes import EventWriter
from swarm_nav.ros import courier_link
from swarm_nav.ros.courier_link import CourierLink


class Graph:
    """A node whose publishers keep what is published."""

    def __init__(self):
        self.sent: list[Any] = []

    def create_publisher(self, *_):
        return self

    def publish(self, data):
        self.sent.append(data)


def test_what_a_release_says_is_obeyed_once_also_if_it_comes_too_late(monkeypatch):
    """A mask for a corridor was lost with its tick: the robot drove straight, 2.9 m beside it."""
    monkeypatch.setattr(courier_link, "SoleTopic", lambda *_: None)
    node: Any = Graph()
    link = CourierLink(node, Rejections(EventWriter(None), lambda _: None))
    status: Any = SimpleNamespace(pose_map=Pose(0, 0, 0), battery=1.0, reach=9.0, state="idle")
    for tick in (7, 8):
        link.report(tick, status, b"", [], lambda _: None, is_charging=False)
    late = TickRelease(7, [b"goal"], keepout=b"mask")
    link.receive(packed(late))
    assert link.release is None
    assert link.obey() == late
    link.receive(packed(late))
    assert link.obey() is None
    link.receive(packed(TickRelease(8, [])))
    assert link.release == link.obey()
