"""The study's files, tables and pages."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import msgspec
import pytest
from typer.testing import CliRunner

import swarm_bench.study.command
from swarm_bench.runs.json_lines import append_json_line, open_to_append
from swarm_bench.study import tables
from swarm_bench.study.experiments import load_experiments, runs_of, study_folder
from swarm_bench.study.lines import StudyLine, read_lines
from swarm_bench.study.page import markdown
from swarm_bench.study.runner import run_one
from swarm_bench.suite.command import bench_app
from swarm_common.model.errors import ConfigError, SwarmError

EXPERIMENT = """
question: Which is faster?
hypothesis: The centre.
methods: [ours, central-mapf]
cells:
  - {scenario: doorway, robots: 4, seconds: 300, seeds: 2, quick: true}
"""


def line(method: str, seed: int, makespan: float | None, **changes: object) -> StudyLine:
    values = {
        "experiment": "speed", "cell": "doorway 4", "method": method, "seed": seed,
        "goals_sent": 4, "goals_reached": 4 if makespan else 3, "robot_robot": 0,
        "robot_world": 0, "makespan": makespan, "stopped": 300.0, "bound": 50.0,
        "cpu_ms_per_robot_second": 1.0, "tick_us_p99": 1.0, "longest_decision_ms": None,
        "bytes_per_robot_second": None, "trajectory_sha256": "", **changes,
    }  # fmt: skip
    return msgspec.convert(values, StudyLine)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "speed.yaml").write_text(EXPERIMENT, encoding="utf-8")
    return tmp_path


def write(path: Path, lines: list[StudyLine]) -> None:
    path.parent.mkdir(exist_ok=True)
    with open_to_append(path) as file:
        for item in lines:
            append_json_line(file, item.as_json())


def test_a_run_that_did_not_end_stays_in() -> None:
    lines = [line("ours", 0, 100.0), line("ours", 1, None), line("ours", 2, None)]
    assert tables.medians(tables.groups(lines))[1] == ["doorway 4", "never (1/3)"]


def test_differences_are_paired_by_seed() -> None:
    lines = [line("ours", s, 100.0 + 50 * s) for s in (0, 1, 2)]
    lines += [line("central-mapf", s, 90.0 + 50 * s) for s in (2, 0)]
    assert tables.differences(tables.groups(lines))[1][2:4] == ["2", "-10 [-10, -10]"]


def test_zero_contacts_have_a_bound() -> None:
    found = tables.details(tables.groups([line("ours", s, 100.0) for s in range(10)]))
    assert found[1][4] == "0 (< 25.9% of runs at 95 %)"
    assert found[1][8] == "100%"


def test_what_comes_with_the_project_can_be_read() -> None:
    experiments = load_experiments(study_folder())
    assert {"scalability", "fault_tolerance"} <= set(experiments)
    runs = list(runs_of(experiments, quick=False))
    assert len({run.key for run in runs}) == len(runs)


def test_dead_robots_are_the_same_for_all_methods(folder: Path) -> None:
    (folder / "speed.yaml").write_text(EXPERIMENT.replace("seeds: 2", "seeds: 1, dead: 0.5"))
    ours, central = runs_of(load_experiments(folder), quick=False)
    assert ours.faults() == central.faults()
    assert len(ours.faults().dead) == 2


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("robots: 4", "robots: four", "Expected `int`"),
        ("quick: true", "speed: 3", "unknown field `speed`"),
        ("ours", "our", "unknown"),
        ("seeds: 2", "seeds: 2, outage: [30, 20]", "expected [from, to]"),
    ],
)
def test_what_is_wrong_in_an_experiment_is_said(
    folder: Path, old: str, new: str, told: str
) -> None:
    (folder / "speed.yaml").write_text(EXPERIMENT.replace(old, new), encoding="utf-8")
    with pytest.raises(SwarmError, match=r"speed\.yaml") as caught:
        load_experiments(folder)
    assert told in str(caught.value)


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="has no experiments"):
        load_experiments(tmp_path)


def test_cells_without_a_run_are_named(folder: Path) -> None:
    text = markdown(
        load_experiments(folder), [line("ours", 0, 9.0)], quick=True, command="swarm-bench study"
    )
    assert "Not run: 3 of 4 runs; no run at all of doorway 4 (central-mapf)." in text


def test_what_was_run_is_not_repeated_and_check_finds_a_changed_document(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ran = []

    def instead(run):
        ran.append(run.key)
        return line(run.method, run.seed, 100.0)

    monkeypatch.setattr(swarm_bench.study.command, "run_one", instead)
    write(folder / "study/full.jsonl", [line("ours", 0, 120.0)])
    document = folder / "study.md"
    common = ["study", "--experiments", str(folder), "--folder", str(folder / "study"),
              "-o", str(document)]  # fmt: skip
    assert CliRunner().invoke(bench_app, [*common, "--check"]).exit_code == 1
    assert CliRunner().invoke(bench_app, [*common, "--most", "2"]).exit_code == 0
    assert len(ran) == 2
    assert len(read_lines(folder / "study/full.jsonl")) == 3
    assert CliRunner().invoke(bench_app, [*common, "--check"]).exit_code == 0
    document.write_text("better figures")
    assert CliRunner().invoke(bench_app, [*common, "--check"]).exit_code == 1


def test_a_run_is_no_faster_than_its_bound(folder: Path) -> None:
    run = next(runs_of(load_experiments(folder), quick=True))
    run = dataclasses.replace(run, method="central-mapf")
    found = run_one(run)
    assert found.makespan is not None
    assert found.bound is not None
    assert 20.0 < found.bound < found.makespan


def test_the_documents_of_this_repository_are_what_its_lines_say() -> None:
    root = Path(__file__).parents[4]
    arguments = ["study", "--quick", "--check", "--folder", str(root / "study"),
                 "-o", str(root / "docs/study.md")]  # fmt: skip
    assert CliRunner().invoke(bench_app, arguments).exit_code == 0
