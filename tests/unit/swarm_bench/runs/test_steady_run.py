"""Runs of fixed duration and of several laps."""

from dataclasses import replace

from swarm_bench.baselines.base import Baseline
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import run
from swarm_bench.runs.scenario import Scenario
from swarm_bench.suite.table import run_line
from swarm_common.model.records import Twist

HALL = Scenario(name="own", world="hall_12", mission="cross_over", robots=(2,))


def test_laps_are_driven_and_a_duration_ends_the_run_between_goals():
    two = run(RunOptions(scenario=replace(HALL, laps=2), robots=2))
    assert (two.goals_sent, two.goals_reached, two.steady) == (4, 4, None)
    assert two.conditions["laps"] == 2
    timed = run(RunOptions(scenario=replace(HALL, duration=150.0, warm_up=30.0), robots=2))
    assert timed.sim_time == 150.0
    assert timed.is_flawless
    assert timed.goals_sent > 4  # lap after lap
    assert timed.steady.per_hour == 30.0 * sum(timed.steady.finished)
    assert two.trajectory_sha256 != timed.trajectory_sha256


class Still(Baseline):
    """Stands, and says nothing of waiting."""

    def prepare(self):
        pass

    def begin(self, target):
        pass

    def drive(self, target):
        return Twist()

    def rest(self):
        return Twist()


def test_a_method_that_stands_is_seen_whatever_it_says():
    method = f"{Still.__module__}:Still"
    options = RunOptions(scenario=replace(HALL, time_limit={2: 100.0}), robots=2, method=method)
    stuck = run(options)
    assert stuck.wait_time == stuck.hold_time == stuck.deadlocks_resolved == 0
    assert stuck.ground_truth.stood_time > 190.0
    assert stuck.ground_truth.deadlocks == 1
    assert f"deadlocks 1, {stuck.ground_truth.stood_time:.0f} s of standing" in run_line(stuck)
