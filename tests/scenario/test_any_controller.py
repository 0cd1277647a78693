"""Whatever drives a robot, the stop filter keeps it in its own space: nobody is touched."""

import math
import random

import pytest

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.invariant import least_slack
from swarm_bench.runs.scenario import load_scenario
from swarm_common.model.records import Twist


def at_random(config, rng):
    return Twist(
        rng.uniform(-1.0, 1.0) * config.max_vel_x,
        rng.uniform(-1.0, 1.0) * config.max_vel_y,
        rng.uniform(-1.0, 1.0) * config.max_vel_theta,
    )


def at_full_speed(config, rng):
    return Twist(config.max_vel_x)


def in_circles(config, rng):
    return Twist(config.max_vel_x, config.max_vel_y, config.max_vel_theta)


def not_finite(config, rng):
    return Twist(rng.choice((math.nan, math.inf, 1e308)), 0.0, -1e308)


class Monkey:
    """A pilot that steers in place of a controller; holds a wish for up to two seconds."""

    def __init__(self, make, config, seed):
        self._make, self._config, self._rng = make, config, random.Random(seed)
        self._ticks, self._wish = 0, Twist()

    def propose(self, robot):
        """Leave paths to the rules."""

    def steer(self, robot, stands):
        if self._ticks == 0:
            self._ticks = self._rng.randint(1, 20)
            self._wish = self._make(self._config, self._rng)
        self._ticks -= 1
        return self._wish


@pytest.mark.parametrize("make", [at_random, at_full_speed, in_circles, not_finite])
@pytest.mark.parametrize(("scenario", "robots"), [("crossing", 24), ("mixed_fleet", 8)])
def test_no_controller_touches_anything(scenario, robots, make):
    harness = Harness(RunOptions(scenario=load_scenario(scenario), robots=robots, seed=5))
    for seed, driver in enumerate(harness.episode.drivers):
        driver._pilot = Monkey(make, driver.reservation_config.controller, seed)
    try:
        for _ in range(300):
            harness.advance()
        assert list(harness.episode.world.collisions) == []
        allowed = least_slack(harness.episode.drivers)
        assert allowed is not None
        assert harness.invariant.slack >= allowed
    finally:
        harness.episode.world.close()
