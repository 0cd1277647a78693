"""A centre in the bench: goals are reached, messages are counted, robots without orders stop."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from swarm_bench.runs.episode import RunOptions, build
from swarm_bench.runs.harness import Harness, InjectedFaults, run
from swarm_bench.runs.scenario import load_scenario
from swarm_central.team import RobotReport

SCENARIO = """
world: doorway
mission: change_rooms
robots: 4
time_limit: {4: 200}
"""


def options(folder: Path, **changes: object) -> RunOptions:
    path = folder / "short.yaml"
    path.write_text(SCENARIO, encoding="utf-8")
    scenario = dataclasses.replace(load_scenario(str(path)), **changes)  # type: ignore[arg-type]
    return RunOptions(scenario=scenario, robots=4, seed=0, method="central-mapf")


@pytest.mark.parametrize("radio", [{}, {"loss": 0.3, "delay": 0.3}])
def test_all_goals_without_a_contact(tmp_path: Path, radio: dict[str, float]) -> None:
    result = run(options(tmp_path, **radio))
    assert result.is_flawless
    assert result.centre is not None
    assert result.centre["bytes_up_per_robot_second"] == pytest.approx(390.0)
    assert 0.0 < result.centre["bytes_down_per_robot_second"] < 1000.0
    assert result.centre["longest_decision_ms"] > 0.0
    assert result.as_json()["centre"]["plans"] > 10


def test_robots_stand_within_what_they_were_given_while_the_centre_is_dead(tmp_path: Path) -> None:
    stage = build(options(tmp_path))
    assert stage.centre is not None
    stage.centre.outage = (50, 150)
    harness = Harness(options(tmp_path), stage=stage)
    places = []
    while harness.advance():
        if stage.world.tick in (56, 75, 150):
            places.append(np.array(stage.world.poses)[:, :2].copy())
    assert np.allclose(places[1], places[2], atol=1e-3)
    moved = np.hypot(*(places[0] - places[1]).T)
    assert moved.max() < 0.3  # no farther than a lookahead, with its pieces
    assert harness.is_over  # it goes on once the centre is back
    assert stage.world.verdict.robot_robot == 0
    stage.world.close()


def test_others_get_past_a_robot_that_died(tmp_path: Path) -> None:
    faults = InjectedFaults(dead={3: 60})
    result = Harness(options(tmp_path), faults=faults).run()
    assert result.goals_reached == result.goals_sent == 3
    assert result.robot_robot == 0


def test_lacam_plans_as_well(tmp_path: Path) -> None:
    chosen = dataclasses.replace(options(tmp_path), central={"planner": "lacam"})
    result = run(chosen)
    assert result.is_flawless
    assert result.centre is not None
    assert result.centre["failed_plans"] < result.centre["plans"]
    assert result.conditions["central.planner"] == "lacam"


def test_a_robot_that_was_not_heard_at_first_joins_later(tmp_path: Path) -> None:
    stage = build(options(tmp_path))
    assert stage.centre is not None
    hears = stage.centre.team.observe

    def deaf_to_the_first(tick: int, states: Sequence[RobotReport]) -> None:
        hears(tick, [report for report in states if report.robot_id != 1 or tick > 80])

    stage.centre.team.observe = deaf_to_the_first  # type: ignore[method-assign]
    result = Harness(options(tmp_path), stage=stage).run()
    assert result.goals_reached == result.goals_sent
