"""The method of one's own that docs/bench.md shows works, and so does its script for intervals."""

import runpy
import sys
from pathlib import Path

from swarm_bench.runs.harness import Harness
from swarm_bench.suite.selection import select
from swarm_bench.suite.table import run_line
from tests.document_blocks import blocks_of
from tests.fakes.lines import add_lines
from tests.fakes.results import result

ROOT = Path(__file__).parents[4]


def save(name, folder, page="bench.md"):
    (block,) = [
        block
        for block in blocks_of((ROOT / "docs" / page).read_text("utf-8"))
        if block.name == name
    ]
    path = folder / name
    path.write_text(block.text, encoding="utf-8")
    return path


def test_method_and_parts_of_the_document_drive_robots(tmp_path, monkeypatch):
    save("polite.py", tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    (options,) = select("corridor", [2], [0], method="polite:PoliteDriver")
    result = Harness(options).run()
    assert result.is_flawless
    assert "polite:PoliteDriver" in run_line(result)
    save("parts.py", tmp_path, "plugins.md")
    monkeypatch.syspath_prepend(tmp_path)
    params = save("parts.yaml", tmp_path, "plugins.md")
    (options,) = select("circle", [3], [0], params=params)
    result = Harness(options).run()
    assert result.is_flawless
    assert "; controller.plugin parts:Pursuit; " in run_line(result)


def test_the_interval_of_the_document_is_around_the_mean(tmp_path, monkeypatch, capsys):
    runs = [result(seed=seed, makespan=100.0 + seed) for seed in range(20)]
    runs.append(result(seed=20, makespan=None))
    add_lines(tmp_path / "runs.jsonl", runs)
    monkeypatch.setattr(sys, "argv", ["interval.py", str(tmp_path / "runs.jsonl")])
    runpy.run_path(str(save("interval.py", tmp_path)))
    assert capsys.readouterr().out == "109.5 [106.7, 112.3] s, 20 of 21 runs complete\n"
