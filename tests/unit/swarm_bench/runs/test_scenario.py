"""Scenarios: those that come with the project fit their worlds; faulty files are refused."""

import pytest

from swarm_bench.runs.episode import RunOptions, check
from swarm_bench.runs.scenario import Scenario, load_scenario, scenario_names
from swarm_common.model.errors import ConfigError

SUITE = {
    "loading_in_order": (50,),
    "two_loaders": (60,),
    "circle": (8, 20, 40),
    "corridor": (20,),
    "crossing": (24,),
    "dead_robot": (20,),
    "doorway": (12,),
    "mapf_game": (5, 12),
    "mapf_maze": (5, 12),
    "mapf_random": (5, 12),
    "mapf_room": (5, 12),
    "mapf_warehouse": (5, 12),
    "mixed_fleet": (30,),
    "pillars": (50,),
    "radio": (20,),
    "slim_blockage": (20, 50, 100),
    "station": (20,),
    "u_shape": (20, 50),
    "walkers": (20,),
}


def test_the_suite_is_complete_with_limits_by_size_and_fleets_in_turn():
    assert {name: load_scenario(name).robots for name in scenario_names()} == SUITE
    slim = load_scenario("slim_blockage")
    assert [slim.limit_of(size) for size in (5, 20, 21, 100, 150)] == [
        1500.0, 1500.0, 2500.0, 5000.0, 5000.0,
    ]  # fmt: skip
    assert slim.targets[50].release == 1300.0
    assert (slim.seeds_of(100), slim.seeds_of(7)) == (5, 20)
    assert Scenario(name="x").limit_of(3) == 3600.0
    models = load_scenario("mixed_fleet").models(5)
    assert models == ["turtlebot3_burger", "turtlebot3_waffle"] * 2 + ["turtlebot3_burger"]


LARGE_MAPS = ("mapf_game", "mapf_random", "mapf_warehouse")


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.long) if n in LARGE_MAPS else n for n in sorted(SUITE)],
)
def test_every_scenario_fits_its_world_in_every_size(name):
    scenario = load_scenario(name)
    for size in (*scenario.robots, len(scenario.dead) + 1):
        check(RunOptions(scenario=scenario, robots=size))
        assert scenario.limit_of(size) > 0.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("wrld: corridor", "unknown key 'wrld'.*'world'"),
        ("robots: 0", "robots.0. is 0.*from 1 to"),
        ("loss: 1.0", "loss is 1.0"),
        ("dead: [[1, 2]]", r"dead\[0\].*3 numbers"),
        ("dead: [[1, 2, 0], [2, 2, 0]]\nrobots: 2", "2 dead robots leave none of 2"),
        ("time_limit: {x: 10}", "time_limit has the key 'x'; expected a swarm size"),
    ],
)
def test_a_faulty_file_is_refused_with_its_name(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match="(?s)" + message) as caught:
        load_scenario(str(path))
    assert "mine.yaml" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("world: corridor", "unknown station 'loader_1'"),
        ("world: corridor\nmission: cross_over", "unknown spawn 'circle'"),
        ("world: corridor\nmission: roam", "'roam' leg needs 'places'"),
        ("fleet: [turtlebot]", "unknown robot"),
        ("actors: nobody.yaml", "nobody.yaml"),
    ],
)
def test_a_scenario_that_does_not_fit_is_refused_before_the_run(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=message):
        check(RunOptions(scenario=load_scenario(str(path)), robots=4))
