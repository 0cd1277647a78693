"""The command lines of `swarm-up --sweep`, and what is read from the runs' folders."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from swarm_bench.capacity.on_graph import _run_of, _steady, _without
from swarm_common.files.journal import Journal
from swarm_common.model.errors import ConfigError

WORDS = ("--mission", "loading_route", "--duration", "60")


def test_the_options_of_the_sweep_itself_are_left_out() -> None:
    words = ["--sweep", "robots=2", "--world", "a", "--run-dir=b", "--headless"]
    assert _without(("--sweep", "--run-dir"), words) == ["--world", "a", "--headless"]


def test_options_and_parameters_are_axes(tmp_path: Path) -> None:
    given = tmp_path / "own.yaml"
    given.write_text("/world: {ros__parameters: {radio.loss: 0.1}}\n")
    chosen = {"robots": "3", "seed": "7", "controller.max_vel_x": "0.2", "laps": "2"}
    run = _run_of(chosen, [*WORDS, "--params", str(given)], tmp_path, 1)
    assert (run.options.swarm_size, run.options.seed, run.options.laps) == (3, 7, 2)
    assert run.label == "controller.max_vel_x=0.2, laps=2"
    assert run.options.params is not None
    tree = yaml.safe_load(run.options.params.read_text())
    assert tree["/world"] == {"ros__parameters": {"radio.loss": 0.1}}
    assert tree["/*/navigator"] == {"ros__parameters": {"max_vel_x": 0.2}}


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [("world", "nowhere", "unknown world"), ("max_vel_x", "-1", "must be positive")],
)
def test_a_wrong_value_is_refused_before_any_run(
    tmp_path: Path, name: str, text: str, said: str
) -> None:
    with pytest.raises(ConfigError, match=said):
        _run_of({name: text}, WORDS, tmp_path, 1)


def test_goals_and_orders_after_the_warm_up_are_counted(tmp_path: Path) -> None:
    (tmp_path / "trace").mkdir()
    journal = Journal(tmp_path / "trace" / "robots.jsonl")
    for at, outcome in ((5.0, "reached"), (50.0, "sent"), (60.0, "reached"), (110.0, "reached")):
        journal.write(t=at, robot="a", goal="x", outcome=outcome, duration=4.0)
    steady = _steady({"sim_time": 120.0}, tmp_path, 20.0)
    assert (sum(steady.finished), steady.per_hour, steady.lead_time) == (2, 72.0, 4.0)
    orders = [{"done": 100.0, "lead_time": 30.0}, {"done": None, "lead_time": None}]
    report = json.loads(json.dumps({"sim_time": 120.0, "orders": {"orders": orders}}))
    assert _steady(report, tmp_path, 20.0).unit == "orders"
