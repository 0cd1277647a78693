"""Whoever speaks in a tick takes part in lockstep: orders, charging, a centre."""

import shutil
import sys

import pytest
import yaml

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import load_scenario
from tests.fakes.charging import waffle_with_battery
from tests.fakes.programs import run_program

LOSS, DELAY = 0.2, 0.1
HALL = """
name: hall
walls:
  - {points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true}
stations:
  {in_1: [7, 1, 0], in_2: [7, 5, 0], out_1: [1, 1, 3.14], out_2: [1, 5, 3.14], dock: [4, 5.4, 0]}
spawn: {x_min: 3, y_min: 1, x_max: 5, y_max: 5, pitch: 1.4, yaw: 0}
"""
ORDERS = """
orders:
  - {from: [in_1, in_2], to: [out_1, out_2], shifts: [{begin: 0, end: 6, every: 3}], service: 1.0}
dispatch: DISPATCH
"""
RADIO = {"radio": {"loss": LOSS, "delay": DELAY}}
SECONDS = 40.0  # of a run that does not end by itself
PACKS = {"central": ("3",)}  # one navigator a process is what charging robots have below
TIMES = {"claim": {"duration": SECONDS}}  # others end with the last order


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a world and parameters."""
    folder = tmp_path_factory.mktemp("hall")
    (folder / "hall.yaml").write_text(HALL, encoding="utf-8")
    command = "from swarm_map.cli import main; main()"
    run_program((sys.executable, "-c", command, "new", "hall.yaml"), cwd=folder)
    assert (folder / "hall" / "world.sdf").exists()
    params = {"/world": {"ros__parameters": RADIO}}
    (folder / "params.yaml").write_text(yaml.safe_dump(params), encoding="utf-8")
    return folder


def in_the_bench(folder, method="ours", robots=3, engine="bullet", **keys):
    path = folder / "scenario.yaml"
    common = {"robots": [robots], "with_lidar": True, "noise": 0.0, "loss": LOSS, "delay": DELAY}
    path.write_text(yaml.safe_dump(common | keys), encoding="utf-8")
    scenario = load_scenario(str(path))
    options = RunOptions(scenario=scenario, robots=robots, seed=2, engine=engine, method=method)
    return Harness(options).run().trajectory_sha256


def on_the_graph(start, folder, *flags):
    params = ("--params", str(folder / "params.yaml"), "--seed", "2")
    report = start(*params, "--headless", "--speed", "max", "--no-report", *flags).good_report(240)
    assert report["late_ticks"] == 0
    return report


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    "dispatch",
    [
        "central",
        pytest.param("claim", marks=pytest.mark.long),
        pytest.param("fifo", marks=pytest.mark.long),
        pytest.param("nearest", marks=pytest.mark.long),
    ],
)
def test_orders_repeat_and_are_those_of_the_bench(start, folder, dispatch):
    mission = folder / f"{dispatch}.yaml"
    mission.write_text(ORDERS.replace("DISPATCH", dispatch), encoding="utf-8")
    times = TIMES.get(dispatch, {})
    bench = in_the_bench(
        folder, world=str(folder / "hall" / "world.sdf"), mission=str(mission), **times
    )
    end = ("--duration", str(times["duration"])) if times else ("--until-done",)
    flags = ("--world", str(folder / "hall"), "--swarm-size", "3", "--mission", str(mission))
    for pack in PACKS.get(dispatch, ("1", "3")):
        report = on_the_graph(start, folder, *flags, *end, "--pack", pack)
        assert report["trajectory_sha256"] == bench


@pytest.fixture(scope="module")
def charging(folder, tmp_path_factory):
    """A folder like the other with a charging station and robots that need it; the bench's hash."""
    own = tmp_path_factory.mktemp("charging")
    shutil.copytree(folder / "hall", own / "hall")
    shutil.copy(folder / "params.yaml", own)
    with (own / "hall" / "sites.yaml").open("a", encoding="utf-8") as file:
        file.write("\ncharging: [dock]\n")
    robot = waffle_with_battery(own, "tired", capacity=0.5, initial=[0.3, 0.5])
    (own / "orders.yaml").write_text(ORDERS.replace("DISPATCH", "central"), encoding="utf-8")
    world, mission = str(own / "hall" / "world.sdf"), str(own / "orders.yaml")
    return own, in_the_bench(own, engine="planar", world=world, mission=mission, robot=str(robot))


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    "pack",
    [
        pytest.param("1", id="once"),
        pytest.param("1", id="again", marks=pytest.mark.long),
        pytest.param("3", marks=pytest.mark.long),
    ],
)
def test_charging_between_orders_repeats_and_is_that_of_the_bench(start, charging, pack):
    folder, bench = charging
    flags = (
        "--world", str(folder / "hall"), "--swarm-size", "3", "--mission",
        str(folder / "orders.yaml"), "--until-done",
        "--robot", str(folder / "tired"), "--drive", "planar", "--pack", pack,
    )  # fmt: skip
    report = on_the_graph(start, folder, *flags)
    assert report["trajectory_sha256"] == bench
    assert all(robot["battery_charges"] >= 1 for robot in report["robots"].values())


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("coordination", "method"),
    [
        pytest.param("central-with-fallback", "central-with-fallback", marks=pytest.mark.long),
        pytest.param("central", "central-reservation", marks=pytest.mark.long),
    ],
)
def test_a_centre_repeats_and_is_that_of_the_bench(start, folder, coordination, method):
    keys = {"world": "doorway", "mission": "change_rooms", "duration": SECONDS}
    bench = in_the_bench(folder, method, 4, **keys)
    flags = (
        "--world", "doorway", "--swarm-size", "4", "--mission", "change_rooms",
        "--duration", str(SECONDS), "--coordination", coordination,
    )  # fmt: skip
    report = on_the_graph(start, folder, *flags, "--pack", "4")
    assert report["trajectory_sha256"] == bench
