"""A controller that changes what it wants, backs, is late or fails touches nobody either."""

import itertools
import random

import pytest

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.invariant import least_slack
from swarm_bench.runs.scenario import load_scenario
from tests.fakes.changing_controllers import Erratic, Habit, near, random_habit

PLUGIN = {"controller.plugin": f"{Erratic.__module__}:{Erratic.__name__}"}
CELLS = (
    ("pillars", 50), ("crossing", 24), ("slim_blockage", 20), ("mixed_fleet", 30),
    ("station", 20), ("doorway", 12), ("circle", 40),
)  # fmt: skip


def least_of(habit, cell, seed, ticks):
    """Return the slack [m] of a run in which nobody touches anything."""
    Erratic.habit, Erratic.numbers = habit, itertools.count(1000 * seed)
    scenario, robots = cell
    options = RunOptions(
        scenario=load_scenario(scenario), robots=robots, seed=seed, parameters=PLUGIN
    )
    harness = Harness(options)
    try:
        for _ in range(ticks):
            if not harness.advance():
                break
        allowed = least_slack(harness.episode.drivers)
        assert allowed == pytest.approx(-0.094)
        assert list(harness.episode.world.collisions) == [], (habit, cell, seed)
        assert harness.invariant.slack >= allowed, (habit, cell, seed, harness.invariant.breach)
        return harness.invariant.slack
    finally:
        harness.episode.world.close()


def test_a_controller_that_backs_up_keeps_the_margin():
    """Two robots came 0.109 m nearer than their radii, and touched."""
    least_of(Habit(), ("pillars", 50), 4711, 900)


@pytest.mark.parametrize("seed", range(3))
def test_changing_controllers_keep_the_margin(seed):
    rng = random.Random(seed)
    least_of(random_habit(rng), rng.choice(CELLS[1:]), seed, 300)


@pytest.mark.long
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("seed", range(100, 104))
def test_no_search_finds_a_controller_that_breaks_the_margin(seed):
    rng = random.Random(seed)
    found: list[tuple[float, Habit, tuple[str, int], int]] = []
    for _ in range(20):
        habit, cell, number = random_habit(rng), rng.choice(CELLS), rng.randrange(10_000)
        if found and rng.random() < 0.5:
            _, best, cell, number = rng.choice(found[:5])
            habit = near(best, rng)
        found.append((least_of(habit, cell, number, 1200), habit, cell, number))
        found.sort(key=lambda each: each[0])
