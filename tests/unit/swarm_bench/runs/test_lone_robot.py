"""A lone robot loses little: on its way, in its turns, at its goals."""

import itertools

import pytest

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import load_scenario
from tests.fakes.navigation import waffle
from tests.oracles.ways import WayTable

CLEARANCE = 0.29  # [m] of a waffle's centre from walls, 5 cm more than it needs
TARGET = 1.15


@pytest.mark.parametrize(("scenario", "seed"), [("slim_blockage", 1), ("u_shape", 0)])
def test_its_makespan_is_near_that_of_the_shortest_way(scenario, seed):
    harness = Harness(RunOptions(scenario=load_scenario(scenario), robots=1, seed=seed))
    result = harness.run()
    assert result.is_flawless
    ways = WayTable(harness.episode.setup.grid, CLEARANCE)
    stops = [outcome.stop.pose_map for outcome in harness.episode.itineraries[0].outcomes]
    length = turns = 0.0
    for start, goal in itertools.pairwise((harness.episode.setup.starts[0], *stops)):
        way, turned = ways.length_and_turns(start, goal)
        length, turns = length + way, turns + turned
    spec = waffle()
    shortest = length / spec.max_vel_x + turns / spec.max_vel_theta
    assert result.makespan <= TARGET * shortest, (result.makespan, length, turns)
