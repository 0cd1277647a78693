"""The command swarm-map: maps of worlds, their check, and worlds made from floor plans."""

import math
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from swarm_common.files.map_io import load_map, map_path, save_map
from swarm_common.files.resources import share_directory
from swarm_describe.worlds.reader import load_world
from swarm_map.floor_plan import load_plan
from swarm_map.map_command import map_app
from swarm_map.world_writer import sdf_text, sites_text
from swarm_run.command_line import run_app

PLAN = """
name: small
walls:
  - {points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}
boxes:
  - {name: crate, at: [3, 2, 0.5], size: [0.5, 0.4, 0.3], mass: 3, repeat: [[2, 1.0, 0]]}
posts:
  - {at: [1, 3], radius: 0.1}
stations:
  dock: {at: [1, 1, 0], repeat: [[3, 1.5, 0]]}
spawn: {x_min: 1, y_min: 1, x_max: 5, y_max: 3, pitch: 1}
"""


def run(monkeypatch, *words):
    monkeypatch.setattr("sys.argv", ["swarm-map", *map(str, words)])
    return run_app("swarm-map", lambda: map_app)


def test_draw_and_check(tmp_path, monkeypatch, capsys):
    out, picture = tmp_path / "maps", tmp_path / "difference.png"
    assert run(monkeypatch, "draw", "hall_12", "-o", out, "--resolution", 0.1) == 0
    assert load_map(out / "hall_12.yaml").resolution == 0.1
    assert run(monkeypatch, "check", "hall_12", out / "hall_12.yaml", "-o", picture) == 0
    grid = load_map(map_path("hall_12"))
    save_map(replace(grid, origin_x=grid.origin_x + 0.5), tmp_path / "moved.yaml")
    capsys.readouterr()
    assert run(monkeypatch, "check", "hall_12", tmp_path / "moved.yaml", "-o", picture) == 1
    text = capsys.readouterr().out
    assert "does not show world hall_12" in text
    assert "moved by (-0.50, +0.00) m" in text
    colors = {tuple(c) for c in np.asarray(Image.open(picture)).reshape(-1, 3)}
    assert {(213, 94, 0), (0, 114, 178)} <= colors
    more = ("--max-share", 1.0, "-o", picture)
    assert run(monkeypatch, "check", "hall_12", tmp_path / "moved.yaml", *more) == 0


def test_without_pybullet_a_world_is_compared_without_physics(tmp_path, monkeypatch, capsys):
    """It ended with a traceback on Python 3.12."""
    monkeypatch.setattr("swarm_map.map_command.usual_engine", lambda: "planar")
    monkeypatch.setattr("swarm_sim.maps.world_check._felt", pytest.fail)
    assert run(monkeypatch, "check", "hall_12", "-o", tmp_path / "picture.png") == 0
    assert "map and LiDAR are those of the triangles of world hall_12" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("draw", "hall_12", "--resolution", 0), "--resolution is 0"),
        (("check", "hall_12", "none.yaml", "--max-share", 2), "--max-share is 2"),
        (("new", "none.yaml"), "no floor plan none.yaml"),
    ],
)
def test_bad_input_is_one_message_and_code_2(tmp_path, monkeypatch, capsys, words, message):
    monkeypatch.chdir(tmp_path)
    assert run(monkeypatch, *words) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_world_from_a_plan(tmp_path, monkeypatch):
    (tmp_path / "plan.yaml").write_text(PLAN)
    assert run(monkeypatch, "new", tmp_path / "plan.yaml", "-o", tmp_path) == 0
    scene = load_world(tmp_path / "small")
    assert list(scene.sites.stations) == ["dock_1", "dock_2", "dock_3"]
    assert scene.sites.stations["dock_3"].x == 4.0
    assert [body.name for body in scene.loose] == ["crate_1::link", "crate_2::link"]
    assert (scene.loose[0].mass, scene.loose[0].friction) == (3.0, 0.5)
    grid = load_map(tmp_path / "small" / "map.yaml")
    assert grid.cells[grid.cell_of(1.0, 3.0)] == 100
    assert grid.cells[grid.cell_of(3.0, 2.0)] == 0  # what can move is not on the map
    assert grid.cells[grid.cell_of(6.0, 2.0)] == 100
    assert run(monkeypatch, "new", tmp_path / "plan.yaml", "-o", tmp_path) == 2  # is there already


def test_a_world_from_a_picture(tmp_path, monkeypatch):
    pixels = np.full((80, 120, 3), 255, np.uint8)
    pixels[:3], pixels[-3:], pixels[:, :3], pixels[:, -3:] = 0, 0, 0, 0
    pixels[38:42, 60:] = 0
    pixels[6:10, 57:63] = (0, 200, 0)
    pixels[72:76, 18:22] = (0, 200, 0)
    pixels[20:60, 10:40] = (0, 0, 255)
    Image.fromarray(pixels).save(tmp_path / "hall.png")
    words = ("new", tmp_path / "hall.png", "-o", tmp_path, "--resolution", 0.1)
    assert run(monkeypatch, *words, "--origin", 0, 0, "--wall-height", 2) == 0
    scene = load_world(tmp_path / "hall")
    first, second = scene.sites.stations.values()
    assert (first.x, first.y) == pytest.approx((6.0, 7.2))
    assert (second.x, second.y) == pytest.approx((2.0, 0.6))
    # Keep right: eastwards along the southern wall, westwards along the northern one.
    assert abs(first.yaw) == pytest.approx(math.pi)
    assert second.yaw == pytest.approx(0.0)
    grid = load_map(tmp_path / "hall" / "map.yaml")
    assert grid.cells[grid.cell_of(9.0, 4.0)] == 100
    assert grid.cells[grid.cell_of(4.0, 4.0)] == 0


def test_text_and_noise_of_a_scan_are_left_out(tmp_path, monkeypatch, capsys):
    pixels = np.full((80, 120, 3), 255, np.uint8)
    pixels[:3], pixels[-3:], pixels[:, :3], pixels[:, -3:] = 0, 0, 0, 0
    pixels[38:42, 60:] = 0
    pixels[6:10, 57:63] = (0, 200, 0)
    pixels[7, 62] = 0  # a speck on the edge of the station
    pixels[60:67, 90:94] = 0  # a letter
    pixels[20:60, 10:40] = (0, 0, 255)
    pixels[70:72, 100] = (0, 0, 255)  # a dot that is no place to start
    Image.fromarray(pixels).save(tmp_path / "hall.png")
    words = ("new", tmp_path / "hall.png", "-o", tmp_path, "--resolution", 0.1, "--origin", 0, 0)
    assert run(monkeypatch, *words) == 2
    error = capsys.readouterr().err
    assert "from an obstacle" in error  # why is in the same line
    assert "specks smaller than" in error
    assert run(monkeypatch, *words, "--drop", 9) == 2
    assert "--drop is 9.0; expected 0 to 5 m" in capsys.readouterr().err
    assert run(monkeypatch, *words, "--drop", 0.7) == 0
    assert "2 dark spots" in " ".join(capsys.readouterr().out.split())
    spawn = load_world(tmp_path / "hall").sites.spawn
    assert (spawn.x_min, spawn.x_max) == pytest.approx((1.05, 3.95))
    grid = load_map(tmp_path / "hall" / "map.yaml")
    assert grid.cells[grid.cell_of(9.2, 1.6)] == 0
    assert grid.cells[grid.cell_of(9.0, 4.0)] == 100


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("walls: [{points: [[0, 0]]}]\n", "2 or more points"),
        ("walls: [{points: [[0, 0], [0, 0]]}]\n", "repeats the one before"),
        ("boxes: [{at: [0, 0], size: [1, 1, 0]}]\n", "size[2] is 0"),
        (
            "boxes: [{at: [0, 0], size: [1, 1, 1], repeat: [[1e9, 1, 1]]}]\n",
            "is 1000000000.0; expected",
        ),
        ("stations: {dock: [1, 1, 90]}\n", "line 1: stations.dock is [1, 1, 90]"),
        ("posts: [{name: a, at: [0, 0], radius: 1}, {name: a, at: [5, 0], radius: 1}]\n", "twice"),
        ("name: ../../etc\n", "expected letters"),
    ],
)
def test_bad_plans_are_refused(tmp_path, monkeypatch, capsys, text, message):
    (tmp_path / "plan.yaml").write_text(text)
    assert run(monkeypatch, "new", tmp_path / "plan.yaml", "-o", tmp_path / "out") == 2
    assert message in capsys.readouterr().err


def test_a_file_of_another_kind_is_told_what_is_taken(tmp_path, monkeypatch, capsys):
    """It was a picture that cannot be read."""
    (tmp_path / "hall.geojson").write_text("{}")
    assert run(monkeypatch, "new", tmp_path / "hall.geojson", "-o", tmp_path / "out") == 2
    assert "expected a picture, YAML, LIF (.json) or .map (MAPF)" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["playground", "warehouse"])
def test_shipped_worlds_are_those_of_their_plans(name):
    folder = share_directory() / "worlds" / name
    plan = load_plan(folder / "plan.yaml")
    assert sdf_text(plan) == (folder / "world.sdf").read_text()
    written = (folder / "sites.yaml").read_text()  # after a line that describes the world
    assert sites_text(plan.sites) == written.partition("\n")[2]


def test_a_black_and_white_picture_is_a_world_without_places(tmp_path, monkeypatch):
    pixels = np.full((60, 80), 255, np.uint8)
    pixels[[0, -1]], pixels[:, [0, -1]] = 0, 0
    Image.fromarray(pixels).save(tmp_path / "plain.png")
    words = ("new", tmp_path / "plain.png", "-o", tmp_path, "--resolution", 0.1)
    assert run(monkeypatch, *words) == 0
    assert not load_world(tmp_path / "plain").sites.stations


def test_a_coarse_picture_has_a_map_to_navigate_on(tmp_path, monkeypatch, capsys):
    pixels = np.full((8, 10), 255, np.uint8)
    pixels[[0, -1]], pixels[:, [0, -1]] = 0, 0
    Image.fromarray(pixels).save(tmp_path / "coarse.png")
    words = ("new", tmp_path / "coarse.png", "-o", tmp_path, "--resolution", 1.0)
    assert run(monkeypatch, *words) == 0
    assert load_map(tmp_path / "coarse" / "map.yaml").resolution == 0.05
    words = ("draw", "slim_blockage", "-o", tmp_path, "--resolution", 1.0)
    assert run(monkeypatch, *words) == 0  # on whose cells of 1 m walls of 0.15 m fit, but ...
    picture = tmp_path / "difference.png"
    capsys.readouterr()
    coarse = load_map(tmp_path / "slim_blockage.yaml")
    moved = replace(coarse, origin_x=coarse.origin_x + 1.5)  # ... not when they are elsewhere
    save_map(moved, tmp_path / "moved.yaml")
    words = ("check", "slim_blockage", tmp_path / "slim_blockage.yaml", "-o", picture)
    assert run(monkeypatch, *words) == 0
    assert run(monkeypatch, "check", "slim_blockage", tmp_path / "moved.yaml", "-o", picture) == 1


GREEN, BLUE = (0, 200, 0), (0, 0, 255)


def draw_hall(file, *rectangles):
    """Draw a hall of 12 x 8 m with 10 pixels per metre; rows from the top."""
    pixels = np.full((80, 120, 3), 255, np.uint8)
    pixels[:3], pixels[-3:], pixels[:, :3], pixels[:, -3:] = 0, 0, 0, 0
    for top, left, height, width, color in rectangles:
        pixels[top : top + height, left : left + width] = color
    Image.fromarray(pixels).save(file)
    return file


def test_size_stations_and_specks_of_a_picture_are_told(tmp_path, monkeypatch, capsys):
    picture = draw_hall(
        tmp_path / "hall.png",
        (10, 20, 4, 4, GREEN),
        (10, 23 + 60, 4, 4, GREEN),
        (40, 40, 1, 2, (0, 0, 0)),
        (50, 60, 2, 2, (0, 0, 0)),
        (60, 60, 4, 4, (0, 0, 0)),  # 0.4 x 0.4 m: a post
    )
    words = ("new", picture, "-o", tmp_path, "--resolution", 0.1, "--origin", 0, 0)
    assert run(monkeypatch, *words) == 0
    text = capsys.readouterr().out
    assert "12.0 x 8.0 m" in text
    assert "station_1 at (2.2, 6.8), station_2 at (8.5, 6.8)" in text
    assert "specks smaller than 0.3 x 0.3 m that are obstacles now (text? noise?): 2" in text
    assert "the largest at (6.1, 2.9)" in text


def test_stations_that_two_robots_cannot_use_are_told(tmp_path, monkeypatch, capsys):
    picture = draw_hall(tmp_path / "hall.png", (10, 20, 2, 2, GREEN), (10, 23, 2, 2, GREEN))
    assert run(monkeypatch, "new", picture, "-o", tmp_path, "--resolution", 0.1) == 0
    assert "station_1 and station_2 are only 0.30 m apart" in capsys.readouterr().out


@pytest.mark.parametrize(
    "spot", [(30, 59, 6, 6, GREEN), (30, 57, 6, 6, GREEN), (60, 40, 4, 4, GREEN)]
)
def test_a_station_on_a_wall_leaves_nothing_behind(tmp_path, monkeypatch, capsys, spot):
    """A hole in a wall was a station, and a folder without a map was left behind."""
    walls = [(10, 61, 60, 2, (0, 0, 0)), (55, 35, 14, 14, (0, 0, 0))]
    picture = draw_hall(tmp_path / "hall.png", *walls, spot)
    words = ("new", picture, "-o", tmp_path, "--resolution", 0.1, "--origin", 0, 0)
    assert run(monkeypatch, *words) == 2
    place = f"({(spot[1] + spot[3] / 2) / 10:.2f}, {8 - (spot[0] + spot[2] / 2) / 10:.2f})"
    assert f"the green spot at {place} lies on a wall" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [picture]


def test_a_command_that_failed_works_once_it_is_right(tmp_path, monkeypatch, capsys):
    picture = draw_hall(tmp_path / "hall.png", (3, 20, 2, 2, GREEN))
    words = ("new", picture, "-o", tmp_path / "out", "--resolution")
    assert run(monkeypatch, *words, 0.1) == 2
    assert "world 'hall' at" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [picture]
    assert run(monkeypatch, *words, 0.3) == 0
    assert sorted(path.name for path in (tmp_path / "out" / "hall").iterdir()) == [
        "map.pgm",
        "map.yaml",
        "preview.png",
        "sites.yaml",
        "world.sdf",
    ]


def test_force_keeps_the_names_that_stations_were_given(tmp_path, monkeypatch, capsys):
    spots = [(20, 20, 4, 4, GREEN), (60, 20, 4, 4, GREEN)]
    picture = draw_hall(tmp_path / "hall.png", *spots)
    words = ("new", picture, "-o", tmp_path, "--resolution", 0.1, "--origin", 0, 0)
    assert run(monkeypatch, *words) == 0
    sites = tmp_path / "hall" / "sites.yaml"
    sites.write_text(
        "stations: {dock: [2.2, 5.8, 0.5], pick: [2.2, 1.8, 1.5]}\nplaces: [[4, 4, 0]]\n"
    )
    draw_hall(picture, (6, 60, 4, 4, GREEN), (22, 22, 4, 4, GREEN), (60, 60, 4, 4, GREEN))
    capsys.readouterr()
    assert run(monkeypatch, *words, "--force") == 0
    assert f"kept of {sites}: dock, places" in capsys.readouterr().out
    scene = load_world(tmp_path / "hall")
    assert list(scene.sites.stations) == ["station_1", "dock", "station_2"]
    assert scene.sites.stations["dock"].yaw == 0.5
    assert scene.sites.stations["dock"].x == pytest.approx(2.4)
    assert len(scene.sites.places) == 1


def test_a_station_in_millimetres_is_named(tmp_path, monkeypatch, capsys):
    picture = draw_hall(tmp_path / "hall.png", (20, 20, 4, 4, GREEN))
    assert run(monkeypatch, "new", picture, "-o", tmp_path) == 0
    (tmp_path / "hall" / "sites.yaml").write_text("stations: {a: [1, 1, 0], b: [5500, 14500, 0]}\n")
    assert run(monkeypatch, "draw", tmp_path / "hall" / "world.sdf", "-o", tmp_path) == 2
    assert "station 'b' at (5500, 14500) lies 14498 m outside" in capsys.readouterr().err
