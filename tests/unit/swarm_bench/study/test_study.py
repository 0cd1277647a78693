"""The study's files, tables and pages."""

import dataclasses
import shutil
from pathlib import Path

import msgspec
import numpy as np
import pytest
from typer.testing import CliRunner

import swarm_bench.study.command
from swarm_bench.baselines import orca
from swarm_bench.execution.executor import executor
from swarm_bench.runs.episode import build
from swarm_bench.study import runner, tables
from swarm_bench.study.experiments import (
    Cell,
    StudyRun,
    beside,
    load_experiments,
    runs_of,
    settings_text,
    study_folder,
)
from swarm_bench.study.lines import StudyLine, store_of
from swarm_bench.study.page import markdown, page
from swarm_bench.study.runner import run_one
from swarm_bench.study.tuning import (
    candidates,
    choose,
    load_chosen,
    load_tuning,
    tuning_runs,
    write_chosen,
)
from swarm_bench.suite.command import bench_app
from swarm_common.model.beacon import BEACON_DTYPE, reception_of
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_run.loop import InjectedFaults, Loop, of_own_part
from tests.fakes.lines import add_lines

EXPERIMENT = """
question: Which is faster?
expected: [The centre.]
methods: [ours, central-mapf]
cells:
  - {scenario: doorway, robots: 4, seconds: 300, seeds: 2, quick: true}
"""


def line(method, seed, makespan, **changes):
    values = {
        "experiment": "speed", "cell": "doorway 4", "method": method, "seed": seed,
        "goals_sent": 4, "goals_reached": 4 if makespan else 3, "robot_robot": 0,
        "robot_world": 0, "makespan": makespan, "stopped": 300.0, "bound": 50.0,
        "cpu_ms_per_robot_second": 1.0, "tick_us_p99": 1.0, "longest_decision_ms": None,
        "bytes_per_robot_second": None, "trajectory_sha256": "", **changes,
    }  # fmt: skip
    return msgspec.convert(values, StudyLine)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "speed.yaml").write_text(EXPERIMENT, encoding="utf-8")
    return tmp_path


def in_this_process(jobs, cluster, *, apart):
    return executor(jobs, cluster)


def test_differences_are_paired_and_zero_contacts_have_a_bound():
    lines = [line("ours", s, 100.0 + 50 * s) for s in (0, 1, 2)]
    lines += [line("central-mapf", s, 90.0 + 50 * s) for s in (2, 0)]
    found = tables.differences(tables.groups(lines)).rows[0]
    assert found[2:4] == ["2", "+7 [+7, +7]"]  # 10 s of 100 and 200 s
    found = tables.details(tables.groups([line("ours", s, 100.0) for s in range(10)]))
    assert found.rows[0][4] == "0 (< 25.9% at 95 %)"
    assert found.rows[0][8] == "100%"
    lines = [line("ours", 0, 100.0), line("ours", 1, None), line("ours", 2, None)]
    assert tables.results(tables.groups(lines)).rows[0] == ["doorway 4", "never (1/3), +100%"]


def test_what_comes_with_the_project_can_be_read():
    experiments = load_experiments(study_folder())
    assert set(experiments) == {"scalability", "adaptability", "fault_tolerance", "makespan"}
    runs = list(runs_of(experiments, quick=False))
    assert len({run.key for run in runs}) == len(runs)


def test_dead_robots_and_study_seeds_are_the_same_for_all(folder, tmp_path):
    (folder / "speed.yaml").write_text(EXPERIMENT.replace("seeds: 2", "seeds: 1, dead: 0.5"))
    ours, central = runs_of(load_experiments(folder), quick=False)
    assert ours.faults() == central.faults()
    assert len(ours.faults().dead) == 2
    shutil.copytree(study_folder(), tmp_path / "study")
    path = tmp_path / "study/tuning/methods.yaml"
    path.write_text(path.read_text().replace("[100,", "[7,"))
    with pytest.raises(ConfigError, match="expected an integer, 100 or more"):
        load_tuning(tmp_path / "study")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("robots: 4", "robots: four", "is 'four'; expected an integer"),
        ("quick: true", "speed: 3", "unknown key 'speed'"),
        ("ours", "our", "unknown"),
        ("seeds: 2", "seeds: 2, outage: true, until: 3", "expected more than at"),
        ("seeds: 2", "seeds: 2, blocked: [0, 0, 1, 1]", "needs lidar"),
        ("doorway", "door", "unknown"),
    ],
)
def test_what_is_wrong_in_an_experiment_is_said(folder, old, new, told):
    (folder / "speed.yaml").write_text(EXPERIMENT.replace(old, new), encoding="utf-8")
    with pytest.raises(SwarmError, match=r"speed\.yaml") as caught:
        load_experiments(folder)
    assert told in str(caught.value)


def test_runs_that_are_missing_are_counted_and_named(folder):
    experiments, lines = load_experiments(folder), [line("ours", 0, 9.0)]
    text = markdown(experiments, lines, quick=True, command="swarm-bench study")
    assert "Not run: 3 of 4 runs; 1 cells have none" in text
    assert "speed, doorway 4, central-mapf" in page(experiments, lines, quick=True)


def test_what_was_run_is_not_repeated_and_check_finds_a_changed_document(folder, monkeypatch):
    ran = []

    def instead(item):
        run, _ = item
        ran.append(run.key)
        if run.seed and run.method == "ours":
            raise ConfigError("no room")
        return line(run.method, run.seed, 100.0)

    monkeypatch.setattr(swarm_bench.study.command, "run_one", instead)
    monkeypatch.setattr(swarm_bench.study.command, "executor", in_this_process)
    add_lines(folder / "study/full.jsonl", [line("ours", 0, 120.0)])
    document = folder / "study.md"
    common = ["study", "--experiments", str(folder), "--folder", str(folder / "study"),
              "-o", str(document)]  # fmt: skip
    assert CliRunner().invoke(bench_app, [*common, "--check"]).exit_code == 1
    assert CliRunner().invoke(bench_app, [*common, "--budget", "0.2s"]).exit_code == 0
    assert len(ran) == 1  # what fits; the rest another time
    names = {path.name for path in (folder / "study").iterdir()}
    assert names == {"full.jsonl.gz", "study.html"}
    outcome = CliRunner().invoke(bench_app, common)
    assert outcome.exit_code == 1
    assert "ours, seed 1: failed: no room" in outcome.output
    assert len(ran) == 3
    assert len(store_of(folder / "study", "full").read()) == 3
    assert CliRunner().invoke(bench_app, [*common, "--check"]).exit_code == 0
    document.write_text("better figures")
    assert CliRunner().invoke(bench_app, [*common, "--check"]).exit_code == 1


def test_shards_share_the_runs_and_a_last_call_joins_them(folder, monkeypatch):
    monkeypatch.setattr(
        swarm_bench.study.command, "run_one", lambda item: line(item[0].method, item[0].seed, 9.0)
    )
    monkeypatch.setattr(swarm_bench.study.command, "executor", in_this_process)
    common = ["study", "--experiments", str(folder), "--folder", str(folder / "study"),
              "-o", str(folder / "study.md")]  # fmt: skip
    for shard in ("1/2", "2/2"):
        assert CliRunner().invoke(bench_app, [*common, "--shard", shard]).exit_code == 0
    assert not (folder / "study.md").exists()
    outcome = CliRunner().invoke(bench_app, common)
    assert "4 of 4 runs are in" in outcome.output
    assert (folder / "study/full.jsonl.gz").is_file()
    assert not list((folder / "study").glob("*.jsonl"))


def test_compressed_lines_do_not_depend_on_the_order_of_runs(tmp_path):
    lines = [line("ours", seed, 9.0, done=[0, 1], created=[1, 0]) for seed in (0, 1)]
    packed = set()
    for name, ordered in (("full", lines), ("quick", lines[::-1])):
        store = store_of(tmp_path, name)
        add_lines(tmp_path / f"{name}.jsonl", ordered)
        store.pack(lambda each: each.key)
        assert [each for _, each in store.read()] == lines
        packed.add((tmp_path / f"{name}.jsonl.gz").read_bytes())
    assert len(packed) == 1


def test_pairs_come_together_and_a_run_is_no_faster_than_its_bound(folder):
    more = "  - {scenario: crossing, robots: 24, seconds: 3000, seeds: 2}\n"
    (folder / "speed.yaml").write_text(EXPERIMENT + more, encoding="utf-8")
    runs = runs_of(load_experiments(folder), quick=False)
    assert [(run.cell.robots, run.seed) for run in runs[::2]] == [(4, 0), (4, 1), (24, 0), (24, 1)]
    assert all(a.key[3] == b.key[3] for a, b in zip(runs[::2], runs[1::2], strict=True))
    run = next(run for run in runs_of(load_experiments(folder), quick=True) if run.seed == 0)
    run = dataclasses.replace(run, method="central-mapf")
    found = run_one((run, run.options()))
    assert found.makespan is not None
    assert found.bound is not None
    assert 20.0 < found.bound < found.makespan


STREAM = """
world: crossing
mission: stream
duration: 90
warm_up: 10
"""
ORDERS = """
spawn: all_rooms
orders:
  - {from: [east, north], to: [west, south], rate: 900}
"""


@pytest.fixture
def stream(folder):
    for name, text in (("scenarios", STREAM), ("missions", ORDERS)):
        (folder / name).mkdir()
        (folder / name / "stream.yaml").write_text(text, encoding="utf-8")
    return folder


def cell(folder, **changes):
    return beside(Cell(scenario="stream", robots=4, **changes), folder)


def test_orders_without_end_are_counted_and_robots_may_join(stream):
    found = {}
    for name, changes in (("all", {}), ("half", {"joins": 0.5, "at": 80.0})):
        run = StudyRun("x", cell(stream, **changes), "ours", 100)
        found[name] = run_one((run, run.options()))
    usual = found["all"]
    assert usual.per_hour
    assert usual.done
    assert usual.created
    assert sum(usual.created) >= sum(usual.done) > 0
    assert usual.created == found["half"].created
    assert found["half"].goals_reached < usual.goals_reached
    assert usual.is_success


def test_a_box_blocks_the_way_for_a_time(stream, monkeypatch):
    seen = []
    looked = Loop.sense

    def sense(self):
        seen.append(len(self.world.loose))
        return looked(self)

    monkeypatch.setattr(Loop, "sense", sense)
    blocked = {"blocked": [0.0, -4.0, 0.4, 0.4], "at": 2.0, "until": 4.0, "lidar": True}
    short = STREAM.replace("90", "6").replace("10", "1")
    (stream / "scenarios/stream.yaml").write_text(short, encoding="utf-8")
    run = StudyRun("x", cell(stream, **blocked), "ours", 100)
    run_one((run, run.options()))
    assert seen[19:42] == [0] + [1] * 20 + [0] * 2


def test_constants_of_a_baseline_count_for_one_run_only(stream):
    seen = []

    def build(options, **_):
        seen.append(orca.HORIZON)
        raise ConfigError("enough")

    run = StudyRun("x", cell(stream), "orca", 100, (("orca.HORIZON", 9.0),))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runner, "build", build)
        with pytest.raises(ConfigError, match="enough"):
            run_one((run, run.options()))
    assert seen == [9.0]
    assert orca.HORIZON == 3.0


def test_the_best_of_equally_many_tries_is_chosen(tmp_path):
    shutil.copytree(study_folder(), tmp_path / "study")
    tuning = load_tuning(tmp_path / "study")
    assert {len(candidates(tuning, method)) for method in tuning.methods} == {tuning.tries}
    lines = [
        line(
            run.method, run.seed, None, cell=run.cell.name, settings=settings_text(run.settings),
            per_hour=100.0 + 50.0 * (run.settings == candidates(tuning, "orca")[2]),
            robot_robot=int(run.settings == candidates(tuning, "dwa")[1]),
        )
        for run in tuning_runs(tuning)
    ]  # fmt: skip
    chosen = choose(tuning, lines)
    assert chosen["orca"] == candidates(tuning, "orca")[2]
    assert chosen["dwa"] == ()
    write_chosen(tmp_path / "study", chosen)
    assert load_chosen(tmp_path / "study") == chosen
    assert "orca" not in choose(tuning, [each for each in lines if each.seed != 104])


def test_sides_are_named_level_by_level(stream):
    cells = [cell(stream), cell(stream, loss=0.2), cell(stream, loss=0.5)]
    lines = [
        line(method, seed, None, cell=each.name, per_hour=100.0 + seed + gain, batches=[1])
        for each, better in zip(cells, (-20.0, 0.0, 30.0), strict=True)
        for seed in range(8)
        for method, gain in (("ours", 0.0), ("central-mapf", better + 0.1 * (seed % 2 - 0.5)))
    ]
    found = tables.sides(cells, tables.groups(lines))
    assert found.rows == [
        ["stream", "loss", "central-mapf", "0.5", "0", "the centre from 0.5 [0.2, 0.5]"]
    ]


def test_a_dip_is_measured_against_the_twin(stream):
    cells = [cell(stream), cell(stream, leaves=0.5, at=20.0)]
    done = {cells[0].name: [1] * 12, cells[1].name: [1, 1, 0, 0, 0, 1, 2, 2, 2, 1, 1, 1]}
    lines = [
        line("ours", 0, None, cell=each.name, per_hour=9.0, created=[1] * 12, done=done[each.name])
        for each in cells
    ]
    found = tables.dips(cells, tables.groups(lines))
    assert found.rows[0] == ["50% removed", "ours", "1", "17%", "3.0", "2", "50 s", "0"]


def test_the_orders_of_every_cell_can_come():
    """Two missions were refused as more than any swarm can serve, so their cells never ran."""
    cells = [cell for each in load_experiments(study_folder()).values() for cell in each.cells]
    first = {(cell.scenario, cell.mission): cell for cell in reversed(cells)}
    for cell in first.values():
        build(StudyRun("x", cell, "ours", 0).options()).world.close()


def test_the_documents_of_this_repository_are_what_its_lines_say():
    root = Path(__file__).parents[4]
    document = root / "docs/study.md"
    is_quick = "study --quick`" in document.read_text(encoding="utf-8")
    arguments = ["study", *["--quick"] * is_quick, "--check", "--folder", str(root / "study"),
                 "-o", str(document)]  # fmt: skip
    assert CliRunner().invoke(bench_app, arguments).exit_code == 0


def test_a_split_radio_parts_odd_from_even():
    beacons = np.zeros(4, BEACON_DTYPE)
    beacons["id"] = [1, 2, 3, 4]
    reception = reception_of(beacons)
    for index, heard in ((0, [1, 3]), (3, [2, 4])):
        assert of_own_part(reception, index).beacons["id"].tolist() == heard
    faults = InjectedFaults(split=(5, 8))
    assert [faults.splits(tick) for tick in (4, 5, 7, 8)] == [False, True, True, False]
