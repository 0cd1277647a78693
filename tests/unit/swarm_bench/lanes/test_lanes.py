"""Lanes learned from where robots lose time, and what becomes of them in a run."""

import dataclasses
import shutil
from pathlib import Path

import msgspec
import numpy as np
import pytest
import yaml

from swarm_bench import cli
from swarm_bench.lanes import command
from swarm_bench.lanes.learning import MOST_LOST, Traffic, lanes_of, lost_time
from swarm_bench.runs.episode import RunOptions, check, prepare
from swarm_bench.runs.harness import run
from swarm_bench.runs.scenario import Scenario
from swarm_common.files.map_io import load_map, map_path, save_mask
from swarm_common.files.sites_io import load_sites
from swarm_common.files.zones_io import LEARNED, load_lanes
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.zones import Zones
from swarm_describe.worlds.world_file import find_world
from swarm_mission.mission import load_mission
from swarm_run.lanes import lanes_for, made_for
from swarm_run.plan import check_plan
from swarm_run.spec import RunSpec

SHAPE = (60, 40)
GRID = Grid(np.zeros(SHAPE, np.int8), 0.05, -1.0, 2.0)
SPEED = 0.26


def traffic(slow, speed=SPEED):
    """Return a run in which robots drive freely, but at a speed in the rows that are slow."""
    metres = np.full(SHAPE, 10.0)
    seconds = metres / SPEED
    seconds[slow] = metres[slow] / speed
    return Traffic(100.0, 0, 10.0, seconds, metres)


@pytest.mark.parametrize(("speed", "lost"), [(0.13, 1.0), (0.26, 0.0), (0.01, MOST_LOST)])
def test_a_place_costs_the_time_that_is_lost_in_it(speed, lost):
    found = lost_time([traffic(slice(20, 60), speed)] * 2, SPEED, GRID.resolution)
    assert found[50] == pytest.approx(lost, abs=1e-6)
    assert found[2] == pytest.approx(0.0, abs=1e-6)


def test_where_nobody_drives_nothing_is_known():
    parked = dataclasses.replace(traffic(slice(0)), metres=np.zeros(SHAPE))
    assert not lost_time([parked], SPEED, GRID.resolution).any()


def test_lanes_are_a_mask_of_nav2_and_never_close_floor(tmp_path):
    costs = np.zeros(SHAPE)
    costs[10], costs[20] = 2.0, 1e9
    save_mask(lanes_of(costs, GRID), tmp_path / "lanes.yaml", **{LEARNED: {"robots": "3"}})
    mask = load_map(tmp_path / "lanes.yaml")
    assert (mask.cells[10] == 50).all()  # of 99 for four times the way
    assert (mask.cells[20] == 99).all()
    assert (mask.origin_x, mask.origin_y, mask.resolution) == (-1.0, 2.0, 0.05)
    assert load_lanes(tmp_path / "lanes.yaml").learned == {"robots": "3"}
    mask.cells[5] = 100
    save_mask(mask, tmp_path / "closed.yaml")
    with pytest.raises(ConfigError, match="100 closes a cell; lanes only cost"):
        load_lanes(tmp_path / "closed.yaml")


@pytest.fixture(scope="module")
def lanes(tmp_path_factory):
    """Lanes of hall_12 for a mission, with costs in its western half."""
    path = tmp_path_factory.mktemp("lanes") / "lanes.yaml"
    setup, mission = prepare(RunOptions(scenario=scenario(), robots=2))
    costs = np.zeros(setup.grid.cells.shape)
    costs[:, : costs.shape[1] // 2] = 3.0
    learned = made_for(setup.scene.file, [mission], 2)
    save_mask(lanes_of(costs, setup.grid), path, **{LEARNED: learned})
    return path


def scenario(**changes):
    return Scenario(name="test", world="hall_12", mission="one_station", robots=(2,), **changes)


def test_a_run_with_lanes_takes_other_ways_and_none_is_without(lanes):
    def hash_of(name):
        options = RunOptions(scenario=scenario(duration=30.0, lanes=name), robots=2)
        return run(options).trajectory_sha256

    assert hash_of("") == hash_of("none") != hash_of(str(lanes))


def test_swarm_up_has_them_for_every_navigator(lanes, tmp_path):
    spec = RunSpec(world="hall_12", swarm_size=2, mission="one_station", lanes=str(lanes))
    plan = check_plan(spec)
    assert plan.remarks == ()
    assert plan.sites.zones.lanes.values.cells.max() == 74
    sites = yaml.safe_load(Path(plan.with_copies(tmp_path / "copies").sites_file).read_text())
    assert sites["zones"]["lanes"].endswith("lanes.yaml")
    without = dataclasses.replace(plan.sites.zones, lanes=None)
    assert not without
    none = check_plan(RunSpec(world="hall_12", swarm_size=2, lanes="none"))
    assert none.sites.zones.lanes is None


def test_a_mission_or_a_world_that_changed_is_noticed(lanes, tmp_path):
    options = RunOptions(scenario=scenario(lanes=str(lanes)), robots=2)
    assert check(options) == []
    work = tmp_path / "work.yaml"
    work.write_text("route: [{stations: [north]}]\n")
    other = dataclasses.replace(options.scenario, mission=str(work))
    (remark,) = check(dataclasses.replace(options, scenario=other))
    assert "lanes were learned for mission one_station" in remark
    data = yaml.safe_load(lanes.read_text())
    data[LEARNED]["world"] = made_for(lanes, [load_mission("one_station")], 2)["world"]
    changed = lanes.with_name("changed.yaml")
    changed.write_text(yaml.safe_dump(data))
    options = dataclasses.replace(options, scenario=scenario(lanes=str(changed)))
    (remark,) = check(options)
    assert "the world has changed since its lanes were learned" in remark


def test_a_worlds_own_lanes_are_for_their_missions_only(lanes, tmp_path):
    hall = find_world("hall_12").parent
    world = Path(shutil.copytree(hall, tmp_path / "hall"))
    shutil.copy(lanes, world)
    shutil.copy(lanes.with_suffix(".pgm"), world)
    sites = world / "sites.yaml"
    sites.write_text(f"{sites.read_text()}zones: {{lanes: lanes.yaml}}\n")
    (file,) = world.glob("*.sdf")
    data = yaml.safe_load(lanes.read_text())
    work = tmp_path / "work.yaml"
    work.write_text("route: [{stations: [north]}]\n")
    plain = RunSpec(world=str(file), swarm_size=2)
    for mission, has_lanes in (("one_station", True), (str(work), False), (None, False)):
        plan = check_plan(msgspec.structs.replace(plain, mission=mission))
        assert (plan.sites.zones.lanes is not None) is has_lanes
        assert (plan.spec.lanes == "none") is not has_lanes
        assert bool(plan.remarks) is has_lanes  # the copy is without the map
        copies = plan.with_copies(tmp_path / f"copies of {mission is None} {has_lanes}")
        copied = load_sites(Path(copies.sites_file))
        assert (copied.zones.lanes is not None) is has_lanes, "what processes read"
        if mission is not None:
            options = RunOptions(scenario=scenario(), robots=2)
            own = dataclasses.replace(options.scenario, world=str(file), mission=mission)
            setup, _ = prepare(dataclasses.replace(options, scenario=own))
            assert (setup.scene.sites.zones.lanes is not None) is has_lanes
    data[LEARNED]["missions"] = "work 0123, one_station 4567"
    (world / "lanes.yaml").write_text(yaml.safe_dump(data))
    (remark,) = check_plan(msgspec.structs.replace(plain, mission=str(work))).remarks
    assert remark.startswith("mission work: the world's lanes were learned before it changed;")
    assert "robots drive without" in remark


def test_a_run_elsewhere_reads_no_file_to_know_whether_lanes_are_for_it(lanes, monkeypatch):
    def refuse(world):
        raise FileNotFoundError(world)

    monkeypatch.setattr("swarm_run.lanes._digest_of", refuse)
    setup, _ = prepare(RunOptions(scenario=scenario(lanes=str(lanes)), robots=2))
    assert setup.scene.sites.zones.lanes is not None


@pytest.mark.parametrize("name", ["one_station", "station"])
def test_lanes_are_for_a_mission_by_its_whole_name(lanes, name):
    mission = load_mission("one_station")
    found = load_lanes(lanes)
    mark = made_for(lanes, [mission], 2)["missions"]
    found.learned["missions"] = f"{name.removesuffix('station')}{mark}, x{mark}"
    zones = Zones(lanes=found)
    is_for_it = lanes_for(zones, mission, is_given=False).lanes is not None
    assert is_for_it is (name == "station")


def test_the_command_compares_on_seeds_that_it_did_not_learn_from(tmp_path, capfd, monkeypatch):
    def swarm_bench(*flags):
        monkeypatch.setattr("sys.argv", ["swarm-bench", *flags])
        with pytest.raises(SystemExit) as caught:
            cli.main()
        return caught.value.code

    arguments = (
        "lanes --world hall_12 --mission one_station --mission work.yaml --robots 4 --seeds 0"
        " --rounds 1 --duration 60 --warm-up 10"
    ).split()
    monkeypatch.chdir(tmp_path)
    Path("work.yaml").write_text("route: [{stations: [north]}]\n")
    path = tmp_path / "lanes.yaml"
    code = swarm_bench(*arguments, "--held-out", "7,8", "-o", str(path))
    out = capfd.readouterr().out
    assert "without lanes: " in out
    assert "round 1: " in out
    assert code == (0 if path.is_file() else command.NO_GAIN)
    if "held-out seeds" in out:
        assert " 7 " in out
    assert swarm_bench(*arguments, "--held-out", "0,1") == 2
    assert "seed 0 is one of --seeds" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (("--mission", ""), "--mission names none"),
        (("--seeds", ""), "--seeds"),
        (("--duration", "0", "--warm-up", "0"), "--duration"),
        (("--duration", "1e308"), "duration is 1e+308"),
        (("-o", "lanes.pgm"), "expected a map file of Nav2"),
        (("--world", "hal_12"), "did you mean 'hall_12'"),
    ],
)
def test_what_could_not_be_learned_is_refused_before_the_first_run(
    flags, words, monkeypatch, capfd, tmp_path
):
    monkeypatch.chdir(tmp_path)
    usual = "swarm-bench lanes --world hall_12 --mission one_station --robots 2".split()
    monkeypatch.setattr("sys.argv", [*usual, *flags])
    with pytest.raises(SystemExit) as caught:
        cli.main()
    assert caught.value.code == 2
    assert words in capfd.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_wall_painted_into_the_map_changes_what_lanes_say_of_the_world(tmp_path):
    """The file of the map was compared, and not the image that it names."""
    world = tmp_path / "world.sdf"
    shutil.copy(find_world("slim_blockage"), world)
    shutil.copy(map_path("slim_blockage"), tmp_path / "map.yaml")
    image = shutil.copy(map_path("slim_blockage").with_suffix(".pgm"), tmp_path)
    before = made_for(world, [], 2)
    pixels = bytearray(Path(image).read_bytes())
    pixels[len(pixels) // 2] ^= 0xFF
    Path(image).write_bytes(bytes(pixels))
    assert made_for(world, [], 2)["world"] != before["world"]


def test_lanes_that_come_along_are_for_their_world():
    world = find_world("slim_blockage")
    lanes = load_sites(world.with_name("sites.yaml")).zones.lanes
    assert lanes is not None
    assert lanes.learned["world"] == made_for(world, [], 2)["world"]
