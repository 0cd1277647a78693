"""Layouts of fleet controls: written of worlds, and worlds made of them."""

import json
import math

import pytest

from swarm_common.files.sites_io import load_sites
from swarm_map.map_command import map_app
from swarm_run.command_line import run_app


def run(monkeypatch, *words):
    monkeypatch.setattr("sys.argv", ["swarm-map", *map(str, words)])
    return run_app("swarm-map", lambda: map_app)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    path = tmp_path_factory.mktemp("lif") / "hall.lif"
    with pytest.MonkeyPatch.context() as patch:
        assert run(patch, "export", "slim_blockage", "--vda5050-layout", path) == 0
    return path


def test_a_world_is_written_as_one_connected_layout(exported):
    (layout,) = json.loads(exported.read_text(encoding="utf-8"))["layouts"]
    nodes = {node["nodeId"]: node["nodePosition"] for node in layout["nodes"]}
    assert {"loader_1", "shipping", "island_1", "island_4"} <= set(nodes)
    edges = [(edge["startNodeId"], edge["endNodeId"]) for edge in layout["edges"]]
    assert len(edges) == len(set(edges))
    assert ("island_1", "island_2") in edges
    assert ("island_2", "island_1") not in edges
    reached, todo = {"shipping"}, ["shipping"]
    while todo:
        at = todo.pop()
        fresh = {end for start, end in edges if start == at} - reached
        reached |= fresh
        todo += fresh
    assert reached == set(nodes)
    assert {s["stationId"] for s in layout["stations"]} <= set(nodes)


def test_a_layout_becomes_a_world(exported, tmp_path, monkeypatch):
    assert run(monkeypatch, "new", exported, "-o", tmp_path) == 0
    sites = load_sites(tmp_path / "hall" / "sites.yaml")
    assert math.isclose(sites.stations["shipping"].yaw, math.pi / 2, abs_tol=1e-5)
    assert len(sites.stations) == 8
    assert len(sites.places) == 4


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("{", "no layout"),
        ('{"layouts": [{"nodes": [{"nodeId": "a", "nodePosition": {"x": 1}}]}]}', "`y`"),
        ('{"layouts": [{"nodes": [{"nodeId": "a", "nodePosition": {"x": 1e9, "y": 0}}]}]}', "1000"),
        (
            '{"layouts": [{"nodes": [{"nodeId": "a", "nodePosition": {"x": 1, "y": 0}}],'
            ' "stations": [{"stationId": "s", "interactionNodeIds": ["b"]}]}]}',
            "no node 'b'",
        ),
    ],
)
def test_what_is_no_layout_is_refused(text, word, tmp_path, monkeypatch, capsys):
    path = tmp_path / "bad.lif"
    path.write_text(text, encoding="utf-8")
    assert run(monkeypatch, "new", path, "-o", tmp_path) == 2
    assert word in capsys.readouterr().err
