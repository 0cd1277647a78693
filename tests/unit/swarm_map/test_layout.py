"""Layouts of fleet controls: written of worlds, and worlds made of them."""

import json
import math

import pytest

from swarm_common.files.layout_io import LAYOUT_FILE, read_layout
from swarm_common.files.sites_io import load_sites
from swarm_map.map_command import map_app
from swarm_run.command_line import run_app
from swarm_run.plan import check_plan
from swarm_run.spec import RunSpec


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


def level(name, *places, map_id="ground"):
    nodes = [
        {"nodeId": f"{name}{i}", "mapId": map_id, "nodePosition": {"x": x, "y": y}}
        for i, (x, y) in enumerate(places)
    ]
    ends = {"startNodeId": f"{name}0", "endNodeId": f"{name}1"}
    return {"layoutId": name, "nodes": nodes, "edges": [{"edgeId": "e", **ends}]}


SQUARE = ((0.0, 0.0), (6.0, 0.0), (6.0, 6.0), (0.0, 6.0))
TWO = [level("low", *SQUARE), level("high", *SQUARE, map_id="roof")]


@pytest.mark.parametrize("key", ["layouts", "origins"])
def test_one_of_several_layouts_is_chosen_and_kept_with_its_map(key, tmp_path, monkeypatch, capsys):
    """They were refused without a way out, and the mapId was lost without a word."""
    content = {"layouts": TWO} if key == "layouts" else {"origins": [{"layouts": TWO}]}
    path = tmp_path / "site.lif"
    path.write_text(json.dumps(content), encoding="utf-8")
    assert run(monkeypatch, "new", path, "-o", tmp_path) == 2
    assert "choose one with --layout: low, high" in capsys.readouterr().err
    assert run(monkeypatch, "new", path, "-o", tmp_path, "--layout", "roof") == 2
    assert "there are low, high" in capsys.readouterr().err
    assert run(monkeypatch, "new", path, "-o", tmp_path, "--layout", "high") == 0
    assert "mapId 'roof'" in capsys.readouterr().out
    world = tmp_path / "site" / "world.sdf"
    plan = check_plan(RunSpec(world=str(world), vda5050="mqtt://localhost"))
    assert plan.vda5050_config(tmp_path / "map.yaml")["map_id"] == "roof"
    layout, _ = read_layout(tmp_path / "site" / LAYOUT_FILE)
    assert [edge.edge_id for edge in layout.edges] == ["e"]


def test_headings_of_an_export_are_within_pi(tmp_path, monkeypatch):
    """Rounded, π was written as 3.141593, which strict fleet controls refuse."""
    path = tmp_path / "hall.lif"
    assert run(monkeypatch, "export", "hall_12", "--vda5050-layout", path) == 0
    (layout,) = json.loads(path.read_text(encoding="utf-8"))["layouts"]
    thetas = [n["vehicleTypeNodeProperties"][0]["theta"] for n in layout["nodes"]]
    thetas += [station["stationPosition"]["theta"] for station in layout["stations"]]
    assert max(map(abs, thetas)) <= math.pi
    assert max(map(abs, thetas)) > 3.14
