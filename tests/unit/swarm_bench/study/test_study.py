"""The study's command, its files and its runs."""

import gzip
import shutil
import time
from pathlib import Path

import msgspec
import numpy as np
import pytest
from typer.testing import CliRunner

import swarm_bench.study.command
from swarm_bench.baselines import orca
from swarm_bench.execution.executor import executor
from swarm_bench.runs.episode import build
from swarm_bench.study import verdicts
from swarm_bench.study.experiments import FIRST_SEED, load_experiments, quick_runs, study_folder
from swarm_bench.study.trials import trial
from swarm_bench.study.trials.cell import Cell, StudyRun
from swarm_bench.study.trials.line import store_of, study_edition
from swarm_bench.study.trials.trial import run_one
from swarm_bench.study.tuning import (
    candidates,
    choose,
    load_chosen,
    load_tuning,
    tuning_runs,
    write_chosen,
)
from swarm_bench.suite.command import bench_app
from swarm_central.movingai import SolverError
from swarm_common.model.beacon import BEACON_DTYPE, reception_of
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_run.loop import InjectedFaults, Loop, of_own_part
from tests.fakes.lines import add_lines
from tests.fakes.study import STREAM, made_up, write_experiments

TINY = """
question: Which is faster?
methods: [ours, central-mapf]
cells:
  - {scenario: doorway, robots: 2, seconds: 60, quick: true}
hypotheses:
  - {says: The centre is., against: [central-mapf], expected: behind, cells: [doorway 2]}
"""


def in_this_process(jobs, cluster, *, apart):
    return executor(jobs, cluster)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with one experiment, whose comparisons are looked at with 2 and 3 pairs."""
    write_experiments(tmp_path, TINY)
    monkeypatch.setattr(verdicts, "LOOKS", (2, 3))
    monkeypatch.setattr(swarm_bench.study.command, "executor", in_this_process)
    return tmp_path


def call(folder, *words):
    arguments = ["study", "--experiments", str(folder), "--folder", str(folder / "study"),
                 "-o", str(folder / "study.md"), *words]  # fmt: skip
    return CliRunner().invoke(bench_app, arguments)


def instead(monkeypatch, runner):
    monkeypatch.setattr(swarm_bench.study.command, "run_one", lambda item: runner(item[0]))


def ours(run, value=100.0, **changes):
    return made_up(run, value, edition=study_edition(), **changes)


def test_a_tiny_study_is_run_written_checked_and_reproduced(folder):
    assert call(folder, "--most", "3").exit_code == 0
    assert call(folder).exit_code == 0
    store = store_of(folder / "study", "full")
    lines = [line for _, line in store.read()]
    assert {line.seed for line in lines} <= {FIRST_SEED, FIRST_SEED + 1, FIRST_SEED + 2}
    assert len({line.key for line in lines}) == len(lines) >= 4
    assert {line.edition for line in lines} == {study_edition()}
    assert all(line.bound < line.makespan for line in lines if line.makespan)
    assert "0 to do now" in call(folder).output
    assert {path.name for path in (folder / "study").iterdir()} == {"full.jsonl.gz", "study.html"}
    assert call(folder, "--check").exit_code == 0
    outcome = call(folder, "--reproduce", "2")
    assert "2 of 2 lines are the same" in outcome.output
    assert outcome.exit_code == 0
    wrong = [msgspec.structs.replace(line, goals_reached=99) for line in lines]
    add_lines(folder / "study/full.jsonl", wrong)
    outcome = call(folder, "--reproduce", "1")
    assert "goals_reached is" in outcome.output
    assert outcome.exit_code == 1


def test_check_finds_every_page_and_figure_that_differs(folder, monkeypatch):
    instead(monkeypatch, lambda run: ours(run, 30.0 + run.seed % 7))
    assert call(folder).exit_code == 0
    shutil.copy(study_folder().parents[1] / "study/protocol.md", folder / "study")
    readme = folder / "README.md"
    readme.write_text("Ours.\n<!-- study -->\n2\n<!-- /study -->\n", encoding="utf-8")
    assert "README.md differs" in call(folder, "--check").output
    assert "protocol.md differs" in call(folder, "--check").output  # it has the project's cells
    assert call(folder).exit_code == 0
    said = readme.read_text(encoding="utf-8").splitlines()[2]
    assert f"{said} " in (folder / "study.md").read_text(encoding="utf-8")
    with monkeypatch.context() as patch:
        patch.setattr(swarm_bench.study.command, "study_edition", lambda: "another")
        outcome = call(folder, "--check")
    assert outcome.exit_code == 0
    assert f"edition {study_edition()}, and this code is another" in outcome.output
    names = ["study.md", "study/study.html", "study/protocol.md", "README.md"]
    names += [f"study_{name}.svg" for name in ("throughput", "makespan", "cost", "loss")]
    for name in names:
        path = folder / name
        text = path.read_text(encoding="utf-8")
        place = max(text.rfind("2"), text.rfind("0"))  # in some number
        path.write_text(f"{text[:place]}3{text[place + 1 :]}", encoding="utf-8")
    outcome = call(folder, "--check")
    assert [name for name in names if f"{folder / name} differs" not in outcome.output] == []
    assert call(folder).exit_code == 0
    packed = folder / "study/full.jsonl.gz"
    content = gzip.decompress(packed.read_bytes())
    packed.write_bytes(gzip.compress(content.replace(b'"makespan": 3', b'"makespan": 4', 1)))
    assert call(folder, "--check").exit_code == 1


def test_figures_of_another_matplotlib_are_not_compared(folder, monkeypatch):
    instead(monkeypatch, ours)
    assert call(folder).exit_code == 0
    path = folder / "study_loss.svg"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("Matplotlib v", "Matplotlib v1."), encoding="utf-8")
    outcome = call(folder, "--check")
    assert outcome.exit_code == 0
    assert "not compared" in outcome.output


def test_lines_of_another_edition_are_refused(folder, monkeypatch):
    ran = []
    instead(monkeypatch, lambda run: ran.append(run) or ours(run))
    [cell] = load_experiments(folder)["speed"].cells
    line = made_up(StudyRun("speed", cell, "ours", FIRST_SEED), edition="0.1 (old)")
    add_lines(folder / "study/full.jsonl", [line])
    outcome = call(folder)
    assert isinstance(outcome.exception, ConfigError)
    assert "1 lines of edition 0.1 (old)" in str(outcome.exception)
    assert not ran
    assert call(folder, "--most", "0").exit_code == 0
    assert "from 1 lines" in (folder / "study.md").read_text(encoding="utf-8")


def test_a_failed_run_is_told_and_not_tried_again_in_the_same_call(folder, monkeypatch):
    tried = []

    def runner(run):
        tried.append(run.key)
        if run.seed == FIRST_SEED and run.method == "ours":
            raise ConfigError("no room")
        return ours(run)

    instead(monkeypatch, runner)
    outcome = call(folder)
    assert outcome.exit_code == 1
    assert f"ours, seed {FIRST_SEED}: failed: no room" in outcome.output
    assert len(tried) == len(set(tried)) == 4


def test_a_time_ends_a_study_and_another_call_goes_on(folder, monkeypatch):
    instead(monkeypatch, lambda run: time.sleep(0.1) or ours(run))
    assert call(folder, "--budget", "0.05s").exit_code == 0
    assert len(store_of(folder / "study", "full").read()) == 1
    assert call(folder).exit_code == 0
    assert len(store_of(folder / "study", "full").read()) == 4


def test_shards_share_the_runs_and_a_last_call_joins_them(folder, monkeypatch):
    instead(monkeypatch, ours)
    for shard in ("1/2", "2/2"):
        assert call(folder, "--shard", shard).exit_code == 0
    assert not (folder / "study.md").exists()
    assert call(folder).exit_code == 0
    assert (folder / "study/full.jsonl.gz").is_file()
    assert not list((folder / "study").glob("*.jsonl"))


def test_the_short_edition_has_lines_and_seeds_of_its_own(folder, monkeypatch):
    instead(monkeypatch, ours)
    assert call(folder, "--quick").exit_code == 0
    lines = [line for _, line in store_of(folder / "study", "quick").read()]
    assert {line.seed for line in lines} == {4900, 4901}
    assert not (folder / "study/full.jsonl.gz").exists()
    assert len(quick_runs(load_experiments(study_folder()), {})) < 60


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--check", "--reproduce", "1"], "one of them at a time"),
        (["--tune", "--quick"], "no short edition"),
        (["--reproduce", "1"], "no lines"),
    ],
)
def test_options_that_do_not_go_together_are_refused(folder, words, told):
    assert told in str(call(folder, *words).exception)


def test_an_estimate_needs_no_run(folder, monkeypatch):
    instead(monkeypatch, ours)
    shutil.copytree(study_folder() / "tuning", folder / "tuning")
    for name in ("scenarios", "missions"):
        shutil.copytree(study_folder() / name, folder / name, dirs_exist_ok=True)
    outcome = call(folder, "--estimate")
    assert "speed: 4 runs due" in outcome.output
    assert not (folder / "study").exists()


def test_a_centre_that_gives_up_has_failed(folder, monkeypatch):
    def give_up(options, **_):
        raise SolverError("it found no plan")

    monkeypatch.setattr(trial, "build", give_up)
    for cell, figure in (
        (load_experiments(folder)["speed"].cells[0], "makespan"), (stream_cell(folder), "per_hour"),
    ):  # fmt: skip
        run = StudyRun("speed", cell, "central-mapf", FIRST_SEED)
        line = run_one((run, run.options()))
        assert line.failure == "it found no plan"
        assert not line.is_success
        assert getattr(line, figure) == {"makespan": None, "per_hour": 0.0}[figure]
        assert line.time == line.stopped


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("robots: 2", "robots: two", "is 'two'; expected an integer"),
        ("quick: true", "speed: 3", "unknown key 'speed'"),
        ("ours", "our", "unknown"),
        ("seconds: 60", "outage: true, until: 3", "expected more than at"),
        ("seconds: 60", "blocked: [0, 0, 1, 1]", "needs lidar"),
        ("scenario: doorway", "scenario: door", "unknown"),
        ("cells: [doorway 2]", "cells: [doorway 3]", "unknown cell of hypothesis 1: 'doorway 3'"),
        ("against: [central-mapf]", "against: [orca]", "doorway 2 is not run with orca"),
        ("against: [central-mapf]", "measure: cost", "one of 'against' and 'than'"),
        ("against: [central-mapf]", "than: doorway 3", "unknown cell of hypothesis 1: 'doorway 3'"),
        ("quick: true}", "quick: true}\n  - {scenario: doorway, robots: 2}", "two cells are the"),
    ],
)
def test_what_is_wrong_in_an_experiment_is_said(tmp_path, old, new, told):
    with pytest.raises(SwarmError) as caught:
        write_experiments(tmp_path, TINY.replace(old, new))
    assert told in str(caught.value)


def test_compressed_lines_do_not_depend_on_the_order_of_runs(folder):
    [cell] = load_experiments(folder)["speed"].cells
    lines = [made_up(StudyRun("speed", cell, "ours", seed)) for seed in (0, 1)]
    packed = set()
    for name, ordered in (("full", lines), ("quick", lines[::-1])):
        store = store_of(folder, name)
        add_lines(folder / f"{name}.jsonl", ordered)
        store.pack(lambda each: each.key)
        assert [each for _, each in store.read()] == lines
        packed.add((folder / f"{name}.jsonl.gz").read_bytes())
    assert len(packed) == 1


def stream_cell(folder, **changes):
    return Cell(scenario="stream", robots=4, **changes).placed(folder)


def test_orders_without_end_are_counted_and_robots_may_leave(folder):
    found = {}
    for name, changes in (("all", {}), ("half", {"leaves": 0.5, "at": 0.1})):
        run = StudyRun("x", stream_cell(folder, **changes), "ours", 100)
        found[name] = run_one((run, run.options()))
    usual = found["all"]
    assert usual.per_hour
    assert usual.done
    assert sum(usual.done) > 0
    assert found["half"].goals_reached < usual.goals_reached
    assert usual.is_success
    assert 0.0 < usual.worst_by_median <= 1.0
    assert 0.0 <= usual.stood_share < 1.0


def test_a_box_blocks_the_way_for_a_time(folder, monkeypatch):
    seen = []
    looked = Loop.sense

    def sense(self):
        seen.append(len(self.world.loose))
        return looked(self)

    monkeypatch.setattr(Loop, "sense", sense)
    blocked = {"blocked": [0.0, -4.0, 0.4, 0.4], "at": 2.0, "until": 4.0, "lidar": True}
    short = STREAM.replace("90", "6").replace("10", "1")
    (folder / "scenarios/stream.yaml").write_text(short, encoding="utf-8")
    run = StudyRun("x", stream_cell(folder, **blocked), "ours", 100)
    run_one((run, run.options()))
    assert seen[19:42] == [0] + [1] * 20 + [0] * 2


@pytest.mark.parametrize(
    ("box", "gets_past"), [((0.45, -4.0, 0.4, 0.4), True), ((0.0, -4.0, 0.6, 0.6), False)]
)
def test_a_centre_hears_of_what_its_robots_see(box, gets_past):
    """It sent them through a thing that no map has, and they drove into it."""
    cell = Cell(
        scenario="crossing", robots=4, seconds=200.0, lidar=True, blocked=list(box), at=0.1,
        until=190.0,
    ).placed(Path())  # fmt: skip
    run = StudyRun("x", cell, "central-mapf", 3)
    line = run_one((run, run.options()))
    assert line.contacts == 0
    assert line.has_ended == gets_past


def test_a_centres_robots_are_no_obstacles_to_each_other():
    """Where nothing is unknown LiDARs saw the other robots, and it closed the ways to them."""
    lines = []
    for lidar in (False, True):
        cell = Cell(scenario="crossing", robots=12, seconds=300.0, lidar=lidar).placed(Path())
        run = StudyRun("x", cell, "central-mapf", 3)
        lines.append(run_one((run, run.options())))
    blind, seeing = lines
    assert seeing.contacts == blind.contacts == 0
    assert seeing.makespan == pytest.approx(blind.makespan, rel=0.1)


@pytest.mark.parametrize("seed", [4990, 4991])
def test_robots_that_see_nothing_do_not_touch_while_their_radio_is_split(seed):
    """23 and 32 contacts: each half drove where the other had been heard last, and got stuck."""
    cell = Cell(scenario="crossing", robots=16, seconds=400.0, split=True, at=20.0, until=80.0)
    run = StudyRun("x", cell.placed(Path()), "ours", seed)
    line = run_one((run, run.options()))
    assert (line.contacts, line.goals_reached) == (0, line.goals_sent)


def test_robots_that_saw_each_other_only_do_not_touch_once_their_radio_is_whole():
    """2 contacts: two had taken the space between them, each up to where it saw the other."""
    cell = Cell(
        scenario="crossing", robots=16, seconds=85.0, lidar=True, split=True, at=20.0, until=80.0
    )
    run = StudyRun("x", cell.placed(Path()), "ours", 5009)
    assert run_one((run, run.options())).contacts == 0


def test_constants_of_a_baseline_count_for_one_run_only(folder):
    seen = []

    def build(options, **_):
        seen.append(orca.HORIZON)
        raise ConfigError("enough")

    run = StudyRun("x", stream_cell(folder), "orca", 100, (("orca.HORIZON", 9.0),))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trial, "build", build)
        with pytest.raises(ConfigError, match="enough"):
            run_one((run, run.options()))
    assert seen == [9.0]
    assert orca.HORIZON == 3.0


def test_the_best_of_equally_many_tries_is_chosen(tmp_path):
    shutil.copytree(study_folder(), tmp_path / "study")
    tuning = load_tuning(tmp_path / "study")
    assert {len(candidates(tuning, method)) for method in tuning.methods} == {tuning.tries}
    gains = {"orca": 50.0, "ours": 2.0, "dwa": 50.0, "central-reservation": 50.0}
    lines = [
        made_up(
            run, 100.0 + gains.get(run.method, 0.0) * (run.settings == second),
            robot_robot=int(run.method == "dwa" and run.settings == second),
        )
        for run in tuning_runs(tuning)
        for second in [candidates(tuning, run.method)[2]]
    ]  # fmt: skip
    chosen = choose(tuning, lines)
    assert chosen["orca"] == candidates(tuning, "orca")[2]
    assert chosen["dwa"] == ()  # more contacts
    assert chosen["ours"] == ()  # less than what matters
    write_chosen(tmp_path / "study", chosen)
    loaded = load_chosen(tmp_path / "study")
    assert loaded.pop("central-with-fallback") == chosen["central-reservation"] != ()
    assert loaded == chosen
    assert "orca" not in choose(tuning, [each for each in lines if each.seed != 4002])


def test_halls_and_seeds_of_tuning_are_not_the_studys(tmp_path):
    tuning = load_tuning(study_folder())
    tuned = {cell.loaded_scenario().world for cell in tuning.cells}
    cells = [cell for each in load_experiments(study_folder()).values() for cell in each.cells]
    assert not tuned & {cell.loaded_scenario().world for cell in cells}
    shutil.copytree(study_folder(), tmp_path / "study")
    path = tmp_path / "study/tuning/methods.yaml"
    path.write_text(path.read_text().replace("[4000,", "[5000,"))
    with pytest.raises(ConfigError, match="expected an integer, less than 4900"):
        load_tuning(tmp_path / "study")


def test_the_orders_of_every_cell_can_come():
    """Two missions were refused as more than any swarm can serve, so their cells never ran."""
    cells = [cell for each in load_experiments(study_folder()).values() for cell in each.cells]
    cells += load_tuning(study_folder()).cells
    for cell in {cell.scenario: cell for cell in reversed(cells)}.values():
        build(StudyRun("x", cell, "ours", 0).options()).world.close()


def test_the_documents_of_this_repository_are_what_its_lines_say():
    root = Path(__file__).parents[4]
    arguments = ["study", "--check", "--folder", str(root / "study"),
                 "-o", str(root / "docs/study.md")]  # fmt: skip
    assert CliRunner().invoke(bench_app, arguments).exit_code == 0
    sizes = [path.stat().st_size for path in (root / "study").glob("*.jsonl.gz")]
    assert sum(sizes) <= 4_000_000


def test_a_split_radio_parts_odd_from_even():
    beacons = np.zeros(4, BEACON_DTYPE)
    beacons["id"] = [1, 2, 3, 4]
    reception = reception_of(beacons)
    for index, heard in ((0, [1, 3]), (3, [2, 4])):
        assert of_own_part(reception, index).beacons["id"].tolist() == heard
    faults = InjectedFaults(split=(5, 8))
    assert [faults.splits(tick) for tick in (4, 5, 7, 8)] == [False, True, True, False]
