"""Random halls: the same for the same seed, valid for every seed, and run like any scenario."""

import itertools
import json
import math

import pytest

from swarm_bench.cli import _load
from swarm_bench.halls.hall_maker import DEAD_GAP, MISSIONS, HallRequest, make_hall
from swarm_bench.halls.halls import DRAWN, SIZES, TROUBLES, build_hall, hall_of, hall_runs, run_hall
from swarm_bench.halls.report import halls_markdown
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_nav.core.config import CostmapConfig, PlannerConfig
from swarm_nav.core.goals import PlanError
from swarm_nav.planning.planner import Planner
from swarm_nav.planning.terrain import terrain_for
from tests.fakes.results import result

WISH = HallRequest(robots=12, radius=0.24, reach=0.57)


def test_a_seed_means_one_hall_of_any_size_mission_and_trouble():
    first, _ = make_hall(WISH, 7)
    again, _ = make_hall(WISH, 7)
    other, _ = make_hall(WISH, 8)
    assert first == again
    assert first.boxes != other.boxes
    runs = hall_runs(range(200), [], DRAWN, DRAWN)
    assert {run.robots for run in runs} == set(SIZES)
    assert {run.scenario.mission for run in runs} == set(MISSIONS)
    troubles = {run.scenario.name.partition(", ")[2] or "none" for run in runs}
    assert troubles == set(TROUBLES)
    pairs = {(run.robots, run.scenario.mission) for run in runs}
    assert len(pairs) == len(SIZES) * len(MISSIONS)
    hall, _ = make_hall(WISH, 1)
    assert all(isinstance(pose, Pose) and math.isfinite(pose.yaw) for pose in hall.homes)


@pytest.mark.parametrize("seed", range(12))
def test_every_goal_can_be_reached_and_is_not_a_dead_robots_place(seed):
    trouble = "dead" if seed % 2 else "none"
    options = hall_runs([seed], [12], DRAWN, trouble)[0]
    hall, grid = hall_of(options)
    alive = hall.homes[: len(hall.homes) - hall.dead]
    fallen = hall.homes[len(alive) :]
    assert len(fallen) == (1 if trouble == "dead" else 0)
    config = CostmapConfig()
    planner = Planner(terrain_for(grid, PlannerConfig(), config, 0.24), PlannerConfig())
    for home, goals in zip(alive, hall.goals, strict=False):
        assert goals
        for goal in goals:
            assert all(goal.distance(pose) >= DEAD_GAP for pose in fallen)
            try:
                planner.plan((home.x, home.y), (goal.x, goal.y), planner.no_extra())
            except PlanError as error:
                pytest.fail(f"seed {seed}: {error}")
    gaps = [a.distance(b) for a, b in itertools.combinations(hall.homes, 2)]
    assert min(gaps) >= 0.57
    assert min(a.distance(b) for a, b in itertools.combinations(hall.stations, 2)) >= 0.599


@pytest.mark.long
def test_a_hall_that_has_no_room_is_refused():
    with pytest.raises(ConfigError, match="no valid hall for 12 robots"):
        make_hall(HallRequest(robots=12, radius=3.0, reach=6.2), 0)


def test_people_have_a_place_and_fleets_are_mixed():
    assert len(hall_of(hall_runs([3], [5], DRAWN, "people")[0])[0].walkers) == 2
    episode = build_hall(hall_runs([3], [5], DRAWN, "mixed")[0])
    episode.world.close()
    radii = {spec.circumscribed_radius for spec in episode.world.specs}
    assert len(radii) == 2
    # Of hall 907 robots stood all along the way of a person: the world refused it.
    (options,) = hall_runs([907], [], DRAWN, DRAWN)
    build_hall(options).world.close()


@pytest.mark.timeout(300)
def test_a_run_counts_goals_like_any_other():
    options = hall_runs([0], [5], "roam", "radio")[0]
    result = run_hall(options)
    assert result.scenario == "hall, radio"
    assert result.conditions["loss"] > 0.0
    assert result.is_flawless
    assert result.goals_sent == 15


def test_the_table_of_halls_tells_what_was_missed_and_whether_that_was_told_before():
    told = "room for 2 robots on the single lanes around (7.5, 12.6); 18 have goals there"
    text = halls_markdown(
        [
            result(scenario="hall, dead", robots=12, seed=11, makespan=100.0, wait_worst=30.0),
            result(scenario="hall", robots=20, seed=2, goals_reached=159, makespan=None),
            result(scenario="hall", robots=20, seed=7, goals_reached=9, no_guarantee=told,
                   makespan=None, robot_robot=1, first_collision="Srobot1 hit Srobot2"),
        ]
    )  # fmt: skip
    assert "|12 robots|1|0|160/160|1|1|1|100 [100..100]|30|" in text
    assert "|20 robots|2|1|168/320|0|1|0|-|5|" in text
    assert "|dead|1|0|" in text
    assert "|all|3|1|328/480|1|2|1|" in text
    assert "- 2 (20 robots): 159 of 160 goals; **all conditions held**" in text
    assert "- 7 (20 robots): 9 of 160 goals, **1 contact** (Srobot1 hit Srobot2); told" in text
    assert "- 11 " not in text


def test_the_command_runs_halls(tmp_path):
    """It looked for a world of the name `hall`."""
    words = ["halls", "--seeds", "0", "--robots", "5", "--json", str(tmp_path / "halls.jsonl")]
    _load()(words, standalone_mode=False)
    (line,) = (tmp_path / "halls.jsonl").read_text(encoding="utf-8").splitlines()
    assert json.loads(line)["scenario"] == "hall"
