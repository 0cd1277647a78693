"""Many robots share three charging stations: every goal, no contact, nobody runs empty."""

import pytest

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import Scenario
from tests.fakes.charging import hall_with_chargers, waffle_with_battery

LIMIT = 2500.0  # [s] of simulated time


def bench(folder, robots, seed, engine="planar", **scenario):
    world, robot = hall_with_chargers(folder), waffle_with_battery(folder)
    chosen = Scenario(
        name="charging", world=str(world), robot=str(robot), robots=(robots,),
        time_limit={robots: LIMIT}, **scenario,
    )  # fmt: skip
    return Harness(RunOptions(scenario=chosen, robots=robots, seed=seed, engine=engine)).run()


def graph(start, folder, robots, seed):
    swarm = start(
        "--swarm-size", str(robots), "--seed", str(seed), "--mission", "loading_route",
        "--world", str(folder / "hall" / "world.sdf"), "--drive", "planar",
        "--robot", str(folder / "electric_waffle"), "--until-done", "--headless",
        "--speed", "max", "--duration", str(LIMIT),
    )  # fmt: skip
    return swarm.good_report(1500.0)


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("robots", "seed"),
    [(8, 0), *(pytest.param(20, seed, marks=pytest.mark.long) for seed in range(5))],
)
def test_many_robots_and_three_charging_stations(tmp_path, robots, seed):
    result = bench(tmp_path, robots, seed)
    assert result.goals_reached == result.goals_sent == 8 * robots
    assert result.robot_robot == result.robot_world == 0
    batteries = {name: robot.battery or {} for name, robot in result.per_robot.items()}
    assert [name for name, battery in batteries.items() if battery["empty_at"] is not None] == []
    assert min(battery["charges"] for battery in batteries.values()) >= 1
    assert min(battery["least"] for battery in batteries.values()) > 0.0


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_robots_that_run_empty_are_dead_to_the_others(tmp_path):
    world = hall_with_chargers(tmp_path, {})
    lasting = waffle_with_battery(tmp_path, "lasting", capacity=100.0)
    tiny = waffle_with_battery(tmp_path, "tiny", capacity=0.15)
    scenario = Scenario(
        name="empty", world=str(world), fleet=(str(lasting), str(lasting), str(tiny)), robots=(6,),
        time_limit={6: LIMIT}, with_lidar=True,
    )  # fmt: skip
    result = Harness(RunOptions(scenario=scenario, robots=6, seed=0)).run()
    assert result.robot_robot == result.robot_world == 0
    for number in (3, 6):
        robot = result.per_robot[f"Srobot{number}"]
        assert robot.battery["empty_at"] < 100.0
        assert robot.goals_failed > 0
    for number in (1, 2, 4, 5):
        assert result.per_robot[f"Srobot{number}"].goals_failed == 0
    assert "its battery is empty" in result.first_miss


@pytest.mark.long
@pytest.mark.timeout(1600)
def test_the_graph_does_what_the_bench_does(start, tmp_path):
    result = bench(tmp_path, 4, 1, noise=0.0, with_lidar=True)
    report = graph(start, tmp_path, 4, 1)
    assert result.is_flawless
    assert report["trajectory_sha256"] == result.trajectory_sha256
    for name, robot in result.per_robot.items():
        battery = robot.battery or {}
        assert battery["charges"] >= 1
        assert report["robots"][name]["battery_charges"] == battery["charges"]
        assert report["robots"][name]["battery_least"] == pytest.approx(battery["least"], abs=1e-3)


@pytest.mark.long
@pytest.mark.timeout(1600)
def test_twenty_robots_on_the_graph(start, tmp_path):
    hall_with_chargers(tmp_path)
    waffle_with_battery(tmp_path)
    report = graph(start, tmp_path, 20, 0)
    assert report["goals"]["reached"] == 160
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    robots = report["robots"].values()
    assert [robot["battery_empty_at"] for robot in robots] == [None] * 20
    assert min(robot["battery_charges"] for robot in robots) >= 1
