"""The method of one's own that docs/bench.md shows works, and so does its script for intervals."""

import runpy
import sys
from pathlib import Path

import pytest

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.json_lines import append_json_line, open_to_append
from swarm_bench.runs.scenario import load_scenario
from tests.document_blocks import blocks_of
from tests.fakes.results import result

ROOT = Path(__file__).parents[4]


def save(name: str, folder: Path) -> Path:
    (block,) = [
        block
        for block in blocks_of((ROOT / "docs" / "bench.md").read_text("utf-8"))
        if block.name == name
    ]
    path = folder / name
    path.write_text(block.text, encoding="utf-8")
    return path


def test_the_method_of_the_document_drives_two_robots(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save("polite.py", tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    options = RunOptions(scenario=load_scenario("corridor"), robots=2, method="polite:PoliteDriver")
    assert Harness(options).run().is_flawless


def test_the_interval_of_the_document_is_around_the_median(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = [result(seed=seed, makespan=100.0 + seed) for seed in range(20)]
    runs.append(result(method="dwa", makespan=None))
    with open_to_append(tmp_path / "runs.jsonl") as file:
        for run in runs:
            append_json_line(file, run.as_json())
    monkeypatch.setattr(sys, "argv", ["interval.py", str(tmp_path / "runs.jsonl")])
    runpy.run_path(str(save("interval.py", tmp_path)))
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "dwa: 0 of 1 runs complete"
    assert lines[1].startswith("ours: median 109.5 s, 95 % [10")
    assert lines[1].endswith("20 of 20 runs complete")
