"""Robots of our own making drive their mission: two of each, on wheels, with their LiDARs."""

import pytest

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import run
from swarm_bench.runs.scenario import Scenario
from tests.fakes.foreign_robots import FOREIGN
from tests.fakes.own_robots import TRAITS

ROBOTS = {**TRAITS, **FOREIGN}


@pytest.mark.parametrize("trait", ROBOTS)
def test_two_of_them_reach_all_goals_without_a_collision(trait, tmp_path):
    """To the one station of the hall, one after the other, and home."""
    path = ROBOTS[trait]().write(tmp_path)
    scenario = Scenario(
        name="own", world="hall_12", mission="one_station", robots=(2,), robot=str(path),
        with_lidar=True, time_limit={2: 240.0},
    )  # fmt: skip
    result = run(RunOptions(scenario=scenario, robots=2, engine="bullet"))
    assert (result.goals_reached, result.goals_sent) == (4, 4), result.first_miss
    assert result.robot_robot + result.robot_world == 0, result.first_collision
