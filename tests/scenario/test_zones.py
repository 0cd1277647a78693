"""The factory hall with a keepout zone across one gap and a speed zone in the other."""

import shutil

import pytest
import yaml

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import run
from swarm_bench.runs.ros_run import run_on_graph
from swarm_bench.runs.scenario import load_scenario
from swarm_common.files.map_io import map_path
from swarm_describe.worlds.world_file import find_world

LIMIT = 3000.0  # [s] of simulated time
ZONES = {
    "keepout": [
        {
            "name": "south_gap",
            "points": [[-5.26, -4.9], [-3.76, -4.9], [-3.76, -2.9], [-5.26, -2.9]],
        }
    ],
    "speed": [
        {
            "name": "north_gap",
            "points": [[-5.3, 7.4], [-3.7, 7.4], [-3.7, 9.5], [-5.3, 9.5]],
            "limit": 0.1,
        }
    ],
}


def options(folder, robots, seed):
    """Return a run in a hall whose holding circuit, which the zone would cut, is left out."""
    world = folder / "world"
    world.mkdir()
    source = find_world("slim_blockage")
    shutil.copy(source, world)
    shutil.copy(map_path("slim_blockage").with_suffix(".pgm"), world)
    shutil.copy(map_path("slim_blockage"), world / "map.yaml")
    sites = yaml.safe_load(source.with_name("sites.yaml").read_text(encoding="utf-8"))
    del sites["circuits"]
    text = yaml.safe_dump(sites | {"zones": ZONES})
    (world / "sites.yaml").write_text(text, encoding="utf-8")
    scenario = {
        "world": str(world / "world.sdf"),
        "mission": "loading_route",
        "time_limit": {robots: LIMIT},
    }
    (folder / "zones.yaml").write_text(yaml.safe_dump(scenario), encoding="utf-8")
    return RunOptions(scenario=load_scenario(str(folder / "zones.yaml")), robots=robots, seed=seed)


def check(result):
    assert result.is_flawless, (result.first_miss, result.first_collision)
    counts = {name: value for name, value in result.zones.items() if name != "first"}
    assert not any(counts.values()), result.zones


@pytest.mark.parametrize(
    ("robots", "seed"),
    [(8, 0), *(pytest.param(20, seed, marks=pytest.mark.long) for seed in range(5))],
)
@pytest.mark.timeout(600)
def test_everybody_arrives_round_the_zone_and_slowly_through_the_other(tmp_path, robots, seed):
    check(run(options(tmp_path, robots, seed)))


@pytest.mark.long
@pytest.mark.timeout(2400)
def test_so_it_is_on_the_graph(tmp_path):
    check(run_on_graph(options(tmp_path, 20, 0)))
