"""Which runs a sweep means, and what it writes; the runs themselves are real but short."""

import csv
import json
import math

import pytest
from rich.console import Console

from swarm_bench.capacity.axes import SweepVariant, variants
from swarm_bench.capacity.command import parse_precision
from swarm_bench.capacity.study import Study
from swarm_bench.cli import _load
from swarm_bench.runs.episode import RunOptions, check
from swarm_bench.runs.scenario import Scenario
from swarm_bench.suite.selection import parse_time
from swarm_bench.suite.sweep import RunSweep
from swarm_common.model.errors import ConfigError
from tests.unit.swarm_bench.capacity.test_statistics import run_of

SCENARIO = Scenario(name="own", duration=3610.0, warm_up=10.0)


def answer(options):
    spread = (options.seed * 7) % 5 - 2
    return run_of(options.robots, options.seed, 12 * min(options.robots, 23) + spread, 0.9)


def test_an_adaptive_study_closes_in_on_the_knee_and_adds_seeds_where_it_must():
    variant = SweepVariant("", RunOptions(scenario=SCENARIO, robots=1))
    study = Study([variant], [4, 12, 20, 28, 36, 44], [0, 1, 2, 3], precision=0.01)
    study.run(lambda runs: RunSweep(runs, runner=answer), Console(quiet=True))
    (curve,) = study.curves
    assert curve.knee.robots == 23
    assert {22, 23, 24} & set(curve.sizes)
    counts = {point.robots: len(point.runs) for point in curve.points}
    assert counts[4] > counts[44] >= 3
    assert max(point.throughput.relative for point in curve.points) <= 0.01
    assert study.done == study.planned
    assert study.cut == ""


def test_a_study_ends_when_its_time_is_up_and_its_precision_is_a_budget():
    study = Study([SweepVariant("", RunOptions(scenario=SCENARIO, robots=1))], [4, 8], [0],
                  precision=0.01, budget=1e-9)  # fmt: skip
    study.run(lambda runs: pytest.fail("a round began"), Console(quiet=True))
    assert study.cut == "The sweep was cut: 0 of 2 planned runs have ended."
    assert math.isinf(Study([], [4], [0])._deadline)
    assert (parse_precision("3%"), parse_precision("0.05"), parse_precision(None)) == (
        0.03,
        0.05,
        None,
    )
    assert (parse_time("30min"), parse_time("90s"), parse_time("2h")) == (1800.0, 90.0, 7200.0)


def test_axes_multiply():
    base = RunOptions(scenario=SCENARIO, robots=1)
    found = variants(base, ["controller.max_vel_x=0.2,0.26", "loss=0,0.2", "method=orca"])
    assert [one.label for one in found][:2] == [
        "controller.max_vel_x=0.2, loss=0", "controller.max_vel_x=0.2, loss=0.2"
    ]  # fmt: skip
    assert len(found) == 4
    assert found[3].base.scenario.loss == 0.2
    assert found[3].base.parameters == {"max_vel_x": 0.26}
    assert {one.base.method for one in found} == {"orca"}
    (mixed,) = variants(base, ["fleet=turtlebot3_burger+turtlebot3_waffle", "mission=roam"])
    assert mixed.base.scenario.fleet == ("turtlebot3_burger", "turtlebot3_waffle")
    assert mixed.base.scenario.name == "slim_blockage, roam"
    (central,) = variants(base, ["dispatch=central"])
    with pytest.raises(ConfigError, match=r"unknown axis 'dispach'.* 'dispatch'\?"):
        variants(base, ["dispach=fifo"])
    with pytest.raises(ConfigError, match="dispatch is 'central', but mission loading_route has"):
        check(central.base)


def test_a_sweep_writes_page_points_and_summary(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["sweep", "--world", "hall_12", "--mission", "cross_over", "--robots", "2..4:2",
             "--seeds", "0", "--seconds", "60", "--warm-up", "10", "--json", "runs.jsonl",
             "-o", "a.html", "-o", "a.csv", "-o", "a.json"]  # fmt: skip
    _load()(words, standalone_mode=False)
    said = capsys.readouterr().out
    assert "No knee is certain between 2 and 4 robots." in said
    rows = list(csv.DictReader((tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()))
    assert [(row["robots"], row["seeds"]) for row in rows] == [("2", "1"), ("4", "1")]
    assert float(rows[1]["throughput"]) > float(rows[0]["throughput"]) > 0.0
    assert float(rows[0]["throughput_low"]) < float(rows[0]["throughput"])
    summary = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert summary["variants"][0]["knee"] is None
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert page.count("<figure") >= 3
    lines = (tmp_path / "runs.jsonl").read_text(encoding="utf-8").splitlines()
    assert all(json.loads(line)["steady"]["per_hour"] > 0.0 for line in lines)
    _load()(words[: words.index("-o")], standalone_mode=False)
    assert "2 of 2 runs are in runs.jsonl already" in capsys.readouterr().out
