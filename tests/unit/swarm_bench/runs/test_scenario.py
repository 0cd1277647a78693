"""Scenarios: those that come with the project fit their worlds; faulty files are refused."""

import pytest

from swarm_bench.runs.episode import RunOptions, check
from swarm_bench.runs.scenario import Scenario, load_scenario, scenario_names
from swarm_common.model.errors import ConfigError, UnknownNameError

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


def test_the_suite_is_complete():
    assert {name: load_scenario(name).robots for name in scenario_names()} == SUITE


@pytest.mark.parametrize("name", sorted(SUITE))
def test_every_scenario_fits_its_world_in_every_size(name):
    scenario = load_scenario(name)
    for size in (*scenario.robots, len(scenario.dead) + 1):
        check(RunOptions(scenario=scenario, robots=size))
        assert scenario.limit_of(size) > 0.0


def test_limits_targets_and_seeds_go_by_size():
    slim = load_scenario("slim_blockage")
    assert [slim.limit_of(size) for size in (5, 20, 21, 100, 150)] == [
        1500.0, 1500.0, 2500.0, 5000.0, 5000.0,
    ]  # fmt: skip
    assert slim.targets[50].release == 1300.0
    assert (slim.seeds_of(100), slim.seeds_of(7)) == (5, 20)
    assert Scenario(name="x").limit_of(3) == 3600.0


def test_a_fleet_is_dealt_in_turn():
    models = load_scenario("mixed_fleet").models(5)
    assert models == ["turtlebot3_burger", "turtlebot3_waffle"] * 2 + ["turtlebot3_burger"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("wrld: corridor", "unknown key 'wrld'.*'world'"),
        ("robots: 0", "robots.0. is 0.*from 1 to"),
        ("robots: [-3]", "robots.0. is -3"),
        ("robots: 1001", "robots.0. is 1001"),
        ("robots: many", "is 'many'; expected a swarm size"),
        ("robots: []", "robots is .*1 or more"),
        ("loss: 1.0", "loss is 1.0"),
        ("loss: much", "loss is 'much'; expected a number"),
        ("delay: -1", "delay is -1"),
        ("noise: -1", "noise is -1"),
        ("with_lidar: 1", "with_lidar is 1; expected true or false"),
        ("fleet: turtlebot3_waffle", "fleet is .*expected a list"),
        ("dead: [[1, 2]]", r"dead\[0\].*3 numbers"),
        ("dead: [[1, 2, 0], [2, 2, 0]]\nrobots: 2", "2 dead robots leave none of 2"),
        ("time_limit: 5", "time_limit is 5"),
        ("time_limit: {20: 0}", "time_limit.20 is 0; expected"),
        ("time_limit: {x: 10}", "time_limit has the key 'x'; expected a swarm size"),
        ("seeds: {20: 0}", "seeds.20 is 0; expected"),
        ("stall_limit: 0", "stall_limit is 0"),
        ("targets: {20: 5}", "targets.20 is 5"),
        ("targets: {20: {relase: 5}}", "unknown key 'relase'.*'release'"),
        ("world: [3]", r"world is \[3\]; expected text"),
        ("world: [", "malformed"),
    ],
)
def test_a_faulty_file_is_refused_with_its_name(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match="(?s)" + message) as caught:
        load_scenario(str(path))
    assert "mine.yaml" in str(caught.value)


def test_an_unknown_scenario_is_named_with_the_closest():
    with pytest.raises(UnknownNameError, match="did you mean 'doorway'"):
        load_scenario("dorway")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("world: corridoor", "unknown world"),
        ("mission: loading_rout", "unknown mission"),
        ("world: corridor", "unknown station 'loader_1'"),
        ("world: corridor\nmission: cross_over", "unknown spawn 'circle'"),
        ("world: corridor\nmission: roam", "'roam' leg needs 'places'"),
        ("robot: turtlebot", "unknown robot"),
        ("fleet: [turtlebot]", "unknown robot"),
        ("actors: nobody.yaml", "nobody.yaml"),
    ],
)
def test_a_scenario_that_does_not_fit_is_refused_before_the_run(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=message):
        check(RunOptions(scenario=load_scenario(str(path)), robots=4))
