"""Swarms in worlds as others make them: they touch nothing, and reach their goals."""

import numpy as np
import pytest
import trimesh
from PIL import Image

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import run
from swarm_bench.runs.scenario import Scenario, load_scenario
from swarm_common.files.map_io import load_map, map_path, save_map
from swarm_common.model.grid import Grid
from swarm_map.map_command import map_app
from swarm_run.command_line import run_app
from tests.unit.swarm_sim.test_mesh_soups import double_faced, room

SITES = """stations: {west: [-2.0, 0.0, 3.1416], east: [2.0, 0.0, 0.0]}
spawn: {x_min: -2.2, y_min: -2.2, x_max: 2.2, y_max: -1.5, pitch: 1.5}
"""
MISSION = """route:
  - stations: [west, east]
  - home: true
"""
MODEL = (
    "<model name='{0}'><static>1</static><pose>{1}</pose><link name='link'><collision name='c'>"
    "<geometry>{2}</geometry></collision></link></model>"
)


def box(name, place, size):
    return MODEL.format(name, f"{place} 0 0 0", f"<box><size>{size}</size></box>")


def mesh(name, place):
    return MODEL.format(name, f"{place} 0 0 0", f"<mesh><uri>{name}.stl</uri></mesh>")


def driven(folder, models, robots=4, engine="bullet"):
    """Let robots go to two stations and home in a world of these models."""
    world = folder / "world.sdf"
    world.write_text(f"<sdf version='1.7'><world name='w'>{models}</world></sdf>")
    (folder / "sites.yaml").write_text(SITES)
    (folder / "mission.yaml").write_text(MISSION)
    scenario = Scenario(
        name="test", world=str(world), mission=str(folder / "mission.yaml"), with_lidar=True
    )
    return run(RunOptions(scenario=scenario, robots=robots, engine=engine))


def check(result):
    assert (result.robot_robot, result.robot_world) == (0, 0), result.first_collision
    assert result.is_flawless


@pytest.mark.parametrize("engine", ["planar", "bullet"])
def test_a_room_of_sheets_with_double_faced_furniture(tmp_path, engine):
    room(3.0).export(tmp_path / "walls.stl")
    shelf = double_faced(trimesh.creation.box((0.4, 1.2, 1.0)))
    shelf.export(tmp_path / "shelf.stl")
    check(driven(tmp_path, mesh("walls", "0 0 0") + mesh("shelf", "0 0 0.5"), engine=engine))


def test_feet_that_no_lidar_sees(tmp_path):
    """A chair whose foot is 6 cm high and reaches 0.3 m beyond what stands at scan height."""
    chair = box("chair", "0 0 0.5", "0.3 0.3 1") + box("foot", "0 0 0.03", "0.9 0.9 0.06")
    room(3.0).export(tmp_path / "walls.stl")
    check(driven(tmp_path, mesh("walls", "0 0 0") + chair))


def test_a_floor_of_asphalt(tmp_path):
    room(3.0).export(tmp_path / "walls.stl")
    check(driven(tmp_path, mesh("walls", "0 0 0") + box("asphalt", "0 0 0.025", "8 8 0.05")))


def test_maps_of_cells_of_a_metre(tmp_path, monkeypatch):
    pixels = np.full((12, 16), 255, np.uint8)
    pixels[[0, -1]], pixels[:, [0, -1]] = 0, 0
    pixels[4:8, 7:9] = 0
    Image.fromarray(pixels).save(tmp_path / "hall.png")
    words = ["new", tmp_path / "hall.png", "-o", tmp_path, "--resolution", "1.0"]
    monkeypatch.setattr("sys.argv", ["swarm-map", *map(str, words)])
    assert run_app("swarm-map", lambda: map_app) == 0
    folder = tmp_path / "hall"
    sites = "stations: {west: [-5.5, 0, 0], east: [5.5, 0, 0]}\n"
    sites += "spawn: {x_min: -6, y_min: -4, x_max: 6, y_max: -3, pitch: 2}\n"
    (folder / "sites.yaml").write_text(sites)
    (tmp_path / "mission.yaml").write_text(MISSION)
    # as before: the map keeps cells of a metre
    fine = load_map(folder / "map.yaml")
    origin = (-8.0, -6.0)
    corner = fine.cell_of(*origin)
    coarse = np.repeat(np.repeat(pixels[::-1] == 0, 20, axis=0), 20, axis=1)
    part = fine.cells[corner[0] : corner[0] + 240, corner[1] : corner[1] + 320]
    assert ((part == 100) == coarse).mean() > 0.98
    cells = np.where(pixels[::-1] == 0, 100, 0).astype(np.int8)
    save_map(Grid(cells, 1.0, *origin), folder / "map.yaml")
    scenario = Scenario(
        name="coarse", world=str(folder), mission=str(tmp_path / "mission.yaml"), with_lidar=True
    )
    check(run(RunOptions(scenario=scenario, robots=4)))


@pytest.mark.parametrize("name", ["game", "maze", "random", "room", "warehouse"])
@pytest.mark.parametrize("robots", [5, 12])
def test_grid_maps(name, robots):
    assert map_path(f"mapf_{name}").is_file()
    check(run(RunOptions(scenario=load_scenario(f"mapf_{name}"), robots=robots)))
