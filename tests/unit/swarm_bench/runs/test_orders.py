"""Orders in the bench: the real navigator between two stations."""

import pytest

from swarm_bench.runs.episode import RunOptions, check
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.result import line_from_json
from swarm_bench.runs.scenario import Scenario
from swarm_common.model.errors import ConfigError
from swarm_run.loop import InjectedFaults

MISSION = """
orders:
  - from: shipping
    to: unload
    shifts: [{begin: 1, end: 40, every: 20}]
    service: {from: 3, to: 2}
"""


def options(folder, robots, mission=MISSION, loss=0.0):
    path = folder / f"orders_{len(mission)}.yaml"  # each file is read once in a process
    path.write_text(mission)
    scenario = Scenario(
        name="orders", mission=str(path), robots=(robots,), loss=loss, time_limit={robots: 600.0}
    )
    return RunOptions(scenario=scenario, robots=robots)


def run(folder, robots, loss=0.0, **more):
    return Harness(options(folder, robots, loss=loss), **more).run()


def test_one_robot_does_two_orders_and_every_second_is_accounted_for(tmp_path):
    result = run(tmp_path, 1)
    assert (result.orders["created"], result.orders["done"]) == (2, 2)
    first, second = result.orders["orders"]
    assert (first["created"], first["waiting"], first["handover"]) == (1.0, 0.5, 0.4)
    assert first["service"] == second["service"] == 5.0
    # the robot is free when the first is done, bids at once, and is granted the second 0.4 s later
    assert second["created"] + second["waiting"] == pytest.approx(first["done"] + 0.4)
    for order in (first, second):
        parts = [order[name] for name in ("waiting", "driving", "handover", "service")]
        assert order["lead_time"] == pytest.approx(sum(parts))
    # each goal is a tick of a beginning and the ways of the robot
    assert result.goals_failed == 0
    assert result.is_flawless
    assert result.sim_time == pytest.approx(second["done"] + 0.5, abs=0.3)
    data = result.as_json()
    data.pop("schema")
    assert line_from_json(data).orders == data["orders"]
    assert run(tmp_path, 1).trajectory_sha256 == result.trajectory_sha256


def test_orders_of_a_robot_that_dies_are_done_by_another(tmp_path):
    result = run(tmp_path, 3, loss=0.2, faults=InjectedFaults(dead={0: 150}))
    assert result.orders["done"] == 2
    assert {order["robot"] for order in result.orders["orders"]} <= {"Srobot2", "Srobot3"}


def test_orders_that_cannot_be_served_are_refused_before_the_run(tmp_path):
    text = "orders:\n  - {from: shipping, to: nowhere, rate: 5}\n"
    with pytest.raises(ConfigError, match="unknown station 'nowhere'"):
        check(options(tmp_path, 1, text))
    text = "orders:\n  - {from: shipping, to: unload, rate: 900, service: 9}\n"
    with pytest.raises(ConfigError, match="no swarm can serve that"):
        check(options(tmp_path, 1, text))
