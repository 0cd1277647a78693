"""The harness: equal seeds give equal runs, faults do what they say, goals are counted."""

import dataclasses

import pytest

from swarm_bench.runs.episode import RunOptions, build
from swarm_bench.runs.harness import Harness, run
from swarm_bench.runs.scenario import load_scenario
from swarm_common.model.records import Pose
from swarm_run.loop import InjectedFaults

SCENARIO = """
world: doorway
mission: change_rooms
robots: 4
time_limit: {4: LIMIT}
"""


def options(folder, seed=0, limit=300.0, **changes):
    path = folder / "short.yaml"
    path.write_text(SCENARIO.replace("LIMIT", str(limit)), encoding="utf-8")
    scenario = dataclasses.replace(load_scenario(str(path)), **changes)
    return RunOptions(scenario=scenario, robots=4, seed=seed)


def without_times(result):
    times = ("wall_time", "tick_us_median", "tick_us_p99", "cpu_ms_per_robot_second")
    return {key: value for key, value in result.as_json().items() if key not in times}


def test_robots_that_do_not_see_a_dead_one_are_told_before_the_run(tmp_path):
    """All conditions held, and a burger drove into a waffle that had never said anything."""
    fleet = ("turtlebot3_burger", "turtlebot3_burger", "turtlebot3_burger", "turtlebot3_waffle")
    dead = ((1.0, 1.0, 0.0),)
    for models, with_lidar, told in (
        (fleet, True, ["does not meet a turtlebot3_waffle: it may hit one that is dead"]),
        (fleet, False, ["without LiDARs no robot sees the dead ones: it may hit them"]),
        ((), True, []),
    ):
        episode = build(options(tmp_path, fleet=models, dead=dead, with_lidar=with_lidar))
        episode.world.close()
        found = [text for text in episode.conditions.findings if "dead" in text]
        assert len(found) == len(told)
        assert all(text.endswith(end) for text, end in zip(found, told, strict=True))


def test_equal_seeds_give_equal_runs_and_losses_change_them(tmp_path):
    first, second = (run(options(tmp_path, seed=3)) for _ in range(2))
    assert without_times(first) == without_times(second)
    assert first.is_flawless
    assert (first.goals_sent, first.goals_reached) == (4, 4)
    assert first.makespan == max(r.finish_time or 0.0 for r in first.per_robot.values())
    assert first.min_held_gap is not None
    other = run(options(tmp_path, seed=4))
    assert other.trajectory_sha256 != first.trajectory_sha256
    clean = run(options(tmp_path))
    lossy = run(options(tmp_path, loss=0.3))
    assert clean.trajectory_sha256 != lossy.trajectory_sha256
    assert lossy.conditions["loss"] == 0.3


def test_brains_that_take_turns_decide_as_brains_one_by_one(tmp_path):
    chosen = options(tmp_path, with_lidar=True)
    in_turns, one_by_one = (Harness(chosen, times_all=timed).run() for timed in (False, True))
    assert without_times(in_turns) == without_times(one_by_one)
    assert in_turns.tick_us_median is not None


def test_a_brain_that_is_replaced_decides_in_every_tick(tmp_path):
    harness = Harness(options(tmp_path))
    fresh = build(options(tmp_path)).drivers[0]
    harness.advance()
    harness.episode.drivers[0] = fresh
    ticks = []
    for _ in range(20):
        harness.advance()
        ticks.append(fresh._s.tick)
    assert ticks == list(range(1, 21))


def test_what_is_not_reached_in_time_is_missed_and_named(tmp_path):
    result = run(options(tmp_path, limit=12.0))
    assert not result.is_flawless
    assert result.makespan is None
    assert result.goals_failed == 4 - result.goals_reached > 0
    assert "did not get to home of Srobot" in result.first_miss
    assert result.sim_time == pytest.approx(12.0)


def test_a_run_in_which_nobody_gets_anywhere_ends(tmp_path):
    stalled = InjectedFaults(deaf=range(4))
    result = Harness(options(tmp_path, stall_limit=20.0), faults=stalled).run()
    assert result.sim_time == pytest.approx(20.0)
    assert result.goals_reached == 0
    assert result.robot_robot == result.robot_world == 0


def test_a_dead_robot_stands_and_its_goals_are_not_asked_for(tmp_path):
    places: list[tuple[float, float]] = []
    silent: list[bool] = []

    def watch(world, _, outputs):
        pose, _twist = world.ground_truth()[0]
        places.append((pose.x, pose.y))
        silent.append(outputs[0] is None)

    harness = Harness(options(tmp_path), faults=InjectedFaults(dead={0: 60}), on_tick=watch)
    result = harness.run()
    assert result.goals_sent == 3
    assert "Srobot1" not in result.per_robot
    assert not any(silent[:60])
    assert all(silent[60:])
    assert places[70] == pytest.approx(places[-1], abs=1e-6)


def test_a_mute_robot_is_not_heard(tmp_path):
    heard: set[int] = set()
    harness = Harness(options(tmp_path, limit=20.0), faults=InjectedFaults(mute={1}))

    def listen(world, _, __):
        for seen in world.observe():
            heard.update(int(number) for number in seen.neighbors["id"])

    harness._on_tick = listen
    harness.run()
    assert heard == {1, 3, 4}


def test_robots_of_the_scenario_that_are_dead_stand_where_it_says(tmp_path):
    scenario = load_scenario("dead_robot")
    harness = Harness(RunOptions(scenario=scenario, robots=3, engine="planar"))
    assert list(harness.episode.setup.silent) == [2]
    assert harness.episode.setup.starts[2] == Pose(*scenario.dead[0])
    assert harness.episode.itineraries[2].total == 0
    for _ in range(30):
        harness.advance()
    pose, _twist = harness.episode.world.ground_truth()[2]
    assert pose.distance(Pose(*scenario.dead[0])) < 1e-9
    harness.episode.world.close()
