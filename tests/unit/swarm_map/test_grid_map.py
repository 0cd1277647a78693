"""Grid maps and scenarios in the Moving AI Lab's formats become worlds that their maps show."""

import numpy as np
import pytest

from swarm_common.files.map_io import load_map, map_path
from swarm_common.files.resources import share_directory
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import OCCUPIED, UNKNOWN
from swarm_common.model.sites import SpawnAreas
from swarm_describe.worlds.reader import load_world
from swarm_map.grid_map import load_grid_map
from swarm_map.world_writer import sdf_text, sites_text, write_world
from swarm_mission.mission import load_mission

MAP = """type octile
height 4
width 5
map
..@.T
.GG.S
.OOWW
.....
"""
SCEN = """version 1.0
0\tx.map\t5\t4\t0\t0\t4\t1\t5.4
0\tx.map\t5\t4\t0\t0\t4\t3\t7
3\tx.map\t5\t4\t4\t3\t0\t2\t5.0
"""
OURS = ("mapf_game", "mapf_maze", "mapf_random", "mapf_room", "mapf_warehouse")
CELLS = {"mapf_maze": 1.8}


def written(folder, text, scen=""):
    (folder / "x.map").write_text(text)
    if not scen:
        return folder / "x.map", None
    (folder / "x.scen").write_text(scen)
    return folder / "x.map", folder / "x.scen"


def test_a_map_becomes_walls_where_nobody_can_be(tmp_path):
    path, scen = written(tmp_path, MAP, SCEN)
    scene = write_world(load_grid_map(path, 2.0, scen), tmp_path / "x")
    grid = load_map(tmp_path / "x" / "map.yaml")
    assert grid.resolution == 0.05
    for row, line in enumerate(MAP.splitlines()[4:]):
        for column, letter in enumerate(line):
            x, y = (column + 0.5 - 2.5) * 2.0, (2.0 - row - 0.5) * 2.0
            value = grid.cells[grid.cell_of(x, y)]
            assert (value in (OCCUPIED, UNKNOWN)) == (letter in "@OTW"), (row, column)
    assert isinstance(scene.sites.spawn, SpawnAreas)
    starts = [(area.x_min, area.y_min) for area in scene.sites.spawn.areas]
    assert starts == [(-4.0, 3.0), (4.0, -3.0)]  # the second line starts where the first does
    mission = load_mission("own_place")
    mission.check_stations(scene.sites, "x")
    ends = []
    for robot in (1, 2):
        (stop,) = mission.stops(
            scene.sites, scene.sites.places[0], seed=0, robot_id=robot, homes_map=()
        )
        ends.append((stop.pose_map.x, stop.pose_map.y))
    assert ends == [(4.0, 1.0), (-4.0, -1.0)]
    with pytest.raises(ConfigError, match="Srobot3 has none of its own"):
        mission.stops(scene.sites, scene.sites.places[0], seed=0, robot_id=3, homes_map=())


@pytest.mark.parametrize(
    ("text", "scen", "message"),
    [
        (MAP.replace("octile", "tile"), "", "expected 'type octile'"),
        (MAP.replace("height 4", "height 5"), "", "4 rows; the header says 5"),
        (MAP.replace("..@.T", "..@.X"), "", "line 5: unknown ['X']"),
        (MAP.replace(".", "@").replace("G", "@").replace("S", "@"), "", "no cell is free"),
        (MAP, "0 x.map", "expected 'version 1'"),
        (MAP, SCEN.replace("\t5.4", ""), "line 2: 8 fields; expected 9"),
        (MAP, SCEN.replace("\t5\t4\t", "\t6\t4\t"), "a map of 6 x 4 cells"),
        (MAP, SCEN.replace("0\t0\t4\t1", "2\t0\t4\t1"), "nobody can be at x 2, y 0"),
        (MAP, "version 1\n", "names no start and goal"),
    ],
)
def test_malformed_files_are_refused(tmp_path, text, scen, message):
    path, scenario = written(tmp_path, text, scen)
    with pytest.raises(ConfigError) as caught:
        load_grid_map(path, 1.0, scenario)
    assert message in str(caught.value)


@pytest.mark.parametrize("name", OURS)
def test_the_worlds_that_ship_are_made_of_their_maps(name):
    folder = share_directory("worlds") / "worlds" / name
    plan = load_grid_map(folder / "plan.map", CELLS.get(name, 1.5), folder / "plan.scen")
    assert (folder / "world.sdf").read_text().split(">", 3)[3] == sdf_text(plan).split(">", 3)[3]
    written = (folder / "sites.yaml").read_text()  # after a line that describes the world
    assert written.partition("\n")[2] == sites_text(plan.sites)
    scene = load_world(name)
    assert len(scene.sites.places) == (100 if name in ("mapf_random", "mapf_warehouse") else 20)
    grid = load_map(map_path(name))
    for pose in scene.sites.places:
        assert grid.cells[grid.cell_of(pose.x, pose.y)] == 0
    assert np.count_nonzero(grid.cells == OCCUPIED) > 1000
