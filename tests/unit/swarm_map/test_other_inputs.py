"""`swarm-map new` with maps of Nav2's, and with worlds of other programs."""

import shlex

import numpy as np
import pytest
from PIL import Image

from swarm_common.files.map_io import load_map
from swarm_common.model.errors import ConfigError
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.world_file import find_world
from swarm_map.map_command import map_app
from swarm_run.command_line import run_app
from tests.fakes.scenes import section_at

NAV2 = """image: {image}
resolution: 0.1
origin: [{origin}]
negate: {negate}
occupied_thresh: 0.65
free_thresh: 0.196
"""
RMF = "name: office\nlevels:\n  L1:\n    vertices: []\n    walls: []\n"
FLATLAND = "properties: {}\nlayers:\n  - name: ['2d']\n    map: hall.yaml\n"
IR_SIM = "world: {height: 10, width: 10, obstacle_map: hall.pgm}\nrobot: [{number: 1}]\n"


def run(monkeypatch, *words):
    monkeypatch.setattr("sys.argv", ["swarm-map", *map(str, words)])
    return run_app("swarm-map", lambda: map_app)


def write_map(folder, origin="20, -30, 0", negate=0):
    """Write a hall of 12 x 8 m with a post at 3 to 3.5, 2 to 2.5 m from its corner."""
    grey = np.full((80, 120), 254, np.uint8)
    grey[:2], grey[-2:], grey[:, :2], grey[:, -2:] = 0, 0, 0, 0
    grey[55:60, 30:35] = 0
    grey[30:40, 90:] = 205  # unknown
    grey[20, 20] = 0  # noise
    Image.fromarray(255 - grey if negate else grey).save(folder / "hall.pgm")
    path = folder / "hall.yaml"
    path.write_text(NAV2.format(image="hall.pgm", origin=origin, negate=negate))
    return path


@pytest.mark.parametrize("negate", [0, 1])
def test_a_map_becomes_a_world_at_the_same_places(tmp_path, monkeypatch, capsys, negate):
    path = write_map(tmp_path, negate=negate)
    assert run(monkeypatch, "new", path, "-o", tmp_path, "--drop", 0.2) == 0
    text = capsys.readouterr().out
    assert "12.0 x 8.0 m, 7 bodies, a spawn area" in text
    assert "unknown cells of" in text
    assert "left out as no longer and no wider than 0.2 m: 1 dark spots" in text
    scene = load_world(tmp_path / "hall")
    assert section_at(scene, 0.2).bounds() == pytest.approx((20.0, -30.0, 32.0, -22.0))
    theirs, ours = load_map(path), load_map(tmp_path / "hall" / "map.yaml")
    for x, y in ((23.25, -27.75), (20.1, -25.0), (26.0, -22.05)):
        assert theirs.cells[theirs.cell_of(x, y)] == ours.cells[ours.cell_of(x, y)] == 100
    for x, y in ((23.8, -27.75), (26.0, -26.0), (22.05, -24.05)):
        assert ours.cells[ours.cell_of(x, y)] == 0
    spawn = scene.sites.spawn
    inside = theirs.cells[
        slice(*(theirs.cell_of(20.0, y)[0] for y in (spawn.y_min, spawn.y_max))),
        slice(*(theirs.cell_of(x, -30.0)[1] for x in (spawn.x_min, spawn.x_max))),
    ]
    assert inside.size > 1000
    assert not inside.any()


def test_a_turned_map_is_set_upright(tmp_path, monkeypatch, capsys):
    path = write_map(tmp_path, "0, 0, 0.5")
    assert run(monkeypatch, "new", path, "-o", tmp_path, "--wall-height", 1) == 0
    assert "turned by 0.5 rad" in capsys.readouterr().out
    bounds = section_at(load_world(tmp_path / "hall"), 0.2).bounds()
    assert bounds == pytest.approx((-3.8, 0.0, 10.5, 12.8), abs=0.2)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("office.building.yaml", RMF, "is a building of Open-RMF's; with Open-RMF installed"),
        ("world.yaml", FLATLAND, "is a world of flatland's; build a world of the map of its layer"),
        ("robots.yaml", IR_SIM, "is a world of ir-sim's; build a world of its obstacle_map"),
        ("bare.yaml", "world: {height: 10}\nrobot: []\n", "draw its walls as a floor plan"),
    ],
)
def test_worlds_of_other_programs_are_told_the_way(
    tmp_path, monkeypatch, capsys, name, text, message
):
    write_map(tmp_path)
    path = tmp_path / name
    path.write_text(text)
    assert run(monkeypatch, "new", path, "-o", tmp_path / "out") == 2
    said = capsys.readouterr().err
    assert message in said
    with pytest.raises(ConfigError) as caught:
        find_world(path)
    assert message in str(caught.value)
    _, has_command, command = said.partition("swarm-map ")
    if has_command:
        assert run(monkeypatch, *shlex.split(command), "-o", tmp_path / "out") == 0


def test_a_map_given_as_a_world_is_told_the_way(tmp_path, monkeypatch):
    folder = tmp_path / "my maps"
    folder.mkdir()
    path = write_map(folder)
    with pytest.raises(ConfigError, match="is a map of Nav2's; build a world of it") as caught:
        find_world(path)
    command = shlex.split(str(caught.value).partition("swarm-map ")[2])
    assert run(monkeypatch, *command, "-o", tmp_path) == 0


@pytest.mark.parametrize(
    ("file", "option", "message"),
    [
        ("hall.yaml", ("--resolution", 0.1), "hall.yaml is a map of Nav2's"),
        ("hall.yaml", ("--origin", 0, 0), "--origin is for a picture"),
        ("hall.pgm", ("--cell", 2), "--cell is for a .map grid"),
        ("plan.yaml", ("--wall-height", 2), "plan.yaml is a floor plan in YAML"),
    ],
)
def test_options_for_other_plans_are_refused(tmp_path, monkeypatch, capsys, file, option, message):
    write_map(tmp_path)
    (tmp_path / "plan.yaml").write_text("walls: [{points: [[0, 0], [5, 0]]}]\n")
    assert run(monkeypatch, "new", tmp_path / file, "-o", tmp_path, *option) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("origin: [20, -30, 0]", ""), "lacks origin"),
        (("hall.pgm", "gone.pgm"), "image 'gone.pgm' is missing"),
        (("occupied_thresh: 0.65", "occupied_thresh: 1.0"), "no cell is occupied"),
    ],
)
def test_maps_that_cannot_be_used(tmp_path, monkeypatch, capsys, change, message):
    path = write_map(tmp_path)
    path.write_text(path.read_text().replace(*change))
    assert run(monkeypatch, "new", path, "-o", tmp_path) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "size", "count"), [("plan", 120, 5), ("my plan", 120, 5), ("hall_12", 120, 5),
                                ("small", 16, 1), ("tiny", 6, 0)],
)  # fmt: skip
def test_the_command_that_is_printed_fits_the_world(
    tmp_path, monkeypatch, capsys, name, size, count
):
    """Robots started around the origin, which a picture elsewhere does not hold."""
    monkeypatch.chdir(tmp_path)
    pixels = np.full((size, size), 255, np.uint8)
    pixels[[0, -1]], pixels[:, [0, -1]] = 0, 0
    Image.fromarray(pixels).save(f"{name}.png")
    words = ("new", f"{name}.png", "--resolution", 0.1, "--origin", 30, -40)
    assert run(monkeypatch, *words) == 0
    said = capsys.readouterr().out
    assert (f"room for {count} robots: " in said) == (count < 5)
    command = shlex.split(said.partition("start robots with")[2])
    assert command[1:] == (["--world", command[2], "--swarm-size", str(count)] if count else [])
    if count:
        found = find_world(command[2])
        assert found.samefile(tmp_path / name / "world.sdf")
