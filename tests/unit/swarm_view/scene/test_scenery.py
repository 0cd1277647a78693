"""What the page shows of who comes and goes beside the robots."""

import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from visualization_msgs.msg import Marker

from swarm_common.files.layout_io import LAYOUT_FILE
from swarm_describe.worlds.reader import load_world
from swarm_sim.ros.viewing.scene_publisher import scene_markers
from swarm_view.scene.fleet import RIM_HEIGHT
from swarm_view.scene.scenery import CUT, CUT_HEIGHT, FLOOR, WHOLE, Scenery


class Handle:
    """A mesh on the page."""

    def __init__(self, shown, name):
        self.name, self._shown = name, shown
        self.position: tuple[float, ...] = ()
        self.wxyz: tuple[float, ...] = ()
        shown.append(self)

    def remove(self):
        self._shown.remove(self)


def marker(number, x, size=0.4, action=Marker.ADD):
    item = Marker(ns="object", id=number, type=Marker.CUBE, action=action)
    item.pose.position.x = x
    item.scale.x = item.scale.y = item.scale.z = size
    return item


def test_movers_come_move_change_and_go():
    shown: list[Handle] = []
    scene = SimpleNamespace(add_mesh_simple=lambda name, *_, **__: Handle(shown, name))
    scenery = Scenery(SimpleNamespace(scene=scene))
    scenery.draw_movers([marker(0, 1.0), marker(1, 2.0)])
    first, second = shown
    scenery.draw_movers([marker(0, 1.5), marker(1, 2.0)])
    assert shown == [first, second]
    assert first.position[0] == 1.5
    scenery.draw_movers([marker(0, 0.0, action=Marker.DELETE), marker(1, 2.0)])
    assert shown == [second]
    scenery.draw_movers([marker(1, 2.0, size=0.8)])  # another thing of the same number
    assert len(shown) == 1
    assert shown != [second]


def upright(height, middle):
    item = marker(0, 0.0)
    item.scale.z, item.pose.position.z, item.pose.orientation.w = height, middle, 1.0
    return item


class Sheet:
    """A scene that notes what is drawn on it."""

    def __init__(self):
        self.drawn: dict[str, Any] = {}

    def add_line_segments(self, name, points, *_, **__):
        """Add lines."""
        self.drawn[name] = points.tolist()

    add_point_cloud = add_line_segments

    def add_frame(self, name, **_):
        """Add a root."""

    def add_batched_meshes_simple(self, name, *_, **properties):
        self.drawn[name] = properties


def test_walls_are_cut_where_they_would_hide_robots():
    sheet = Sheet()
    scenery = Scenery(SimpleNamespace(scene=sheet))
    scenery.draw_markers([upright(2.0, 1.0), upright(0.3, 0.15), upright(0.4, 2.0)])
    whole = [name for name in sheet.drawn if name.startswith(WHOLE)]
    cut = [name for name in sheet.drawn if name.startswith(CUT)]
    assert sum(len(sheet.drawn[name]["batched_positions"]) for name in whole) == 3
    tops = [
        float(place[2] + 0.5 * size[2])
        for name in cut
        for place, size in zip(
            sheet.drawn[name]["batched_positions"], sheet.drawn[name]["batched_scales"], strict=True
        )
    ]
    assert sorted(tops) == pytest.approx([0.3, CUT_HEIGHT])  # what hangs above is left out
    assert all(sheet.drawn[name]["opacity"] is None for name in cut)


def test_stations_lie_below_the_marks_of_robots():
    station = upright(0.02, 0.01)
    station.ns = "station"
    sheet = Sheet()
    Scenery(SimpleNamespace(scene=sheet)).draw_markers([station])
    tops = [
        drawn["batched_positions"][0][2] + 0.5 * drawn["batched_scales"][0][2]
        for drawn in sheet.drawn.values()
    ]
    assert len(tops) == 2
    assert all(0.0 < top < RIM_HEIGHT for top in tops)


def test_the_layout_of_a_fleet_control_is_drawn(tmp_path):
    def place(name, x):
        return {"nodeId": name, "mapId": "hall", "nodePosition": {"x": x, "y": 1.0}}

    nodes = [place("a", 0.0), place("b", 2.0), place("alone", 4.0)]
    edges = [{"edgeId": name, "startNodeId": "a", "endNodeId": name} for name in ("b", "gone")]
    (tmp_path / LAYOUT_FILE).write_text(
        json.dumps({"layouts": [{"layoutId": "l", "nodes": nodes, "edges": edges}]})
    )
    scene = replace(load_world("slim_blockage"), file=tmp_path / "world.sdf", bodies=(), decor=())
    sheet = Sheet()
    Scenery(SimpleNamespace(scene=sheet)).draw_markers(scene_markers(scene))
    assert sheet.drawn["/world/layout_edges"] == [[[0.0, 1.0, FLOOR], [2.0, 1.0, FLOOR]]]
    assert [x for x, *_ in sheet.drawn["/world/layout_nodes"]] == [0.0, 2.0, 4.0]
