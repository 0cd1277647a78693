"""The command lines of `swarm-up --sweep`, and what is read from the runs' folders."""

import json

import pytest

from swarm_bench.capacity.on_graph import _run_of, _steady
from swarm_common.files.journal import Journal
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_run.plan import check_plan

STATED = {"mission": "loading_route", "duration": 60.0}


def test_options_and_parameters_are_axes(tmp_path):
    given = tmp_path / "own.yaml"
    given.write_text("/world: {ros__parameters: {radio.loss: 0.1}}\n")
    chosen = {"robots": "3", "seed": "7", "controller.max_vel_x": "0.2", "laps": "2"}
    run = _run_of(chosen, {**STATED, "params": str(given)}, tmp_path / "run_1")
    assert (run.spec.size, run.spec.seed, run.spec.laps) == (3, 7, 2)
    assert run.label == "controller.max_vel_x=0.2, laps=2"
    assert (run.spec.params, run.spec.parameters) == (str(given), {"max_vel_x": 0.2})
    (values,) = check_plan(run.spec).parameter_file(1, Pose(0.0, 0.0, 0.0)).values()
    assert values["ros__parameters"]["max_vel_x"] == 0.2


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("world", "nowhere", "unknown world"),
        ("max_vel_x", "-1", "must be more than 0"),
        ("robotz", "2", "unknown axis 'robotz' in --sweep; did you mean 'robots'"),
    ],
)
def test_a_wrong_value_is_refused_before_any_run(tmp_path, name, text, said):
    with pytest.raises(ConfigError, match=said):
        _run_of({name: text}, STATED, tmp_path / "run_1")


def test_goals_and_orders_after_the_warm_up_are_counted(tmp_path):
    (tmp_path / "trace").mkdir()
    journal = Journal(tmp_path / "trace" / "robots.jsonl")
    for at, outcome in ((5.0, "reached"), (50.0, "sent"), (60.0, "reached"), (110.0, "reached")):
        journal.write(t=at, robot="a", goal="x", outcome=outcome, duration=4.0)
    steady = _steady({"sim_time": 120.0}, tmp_path, 20.0)
    assert (sum(steady.finished), steady.per_hour, steady.lead_time) == (2, 72.0, 4.0)
    orders = [{"done": 100.0, "lead_time": 30.0}, {"done": None, "lead_time": None}]
    report = json.loads(json.dumps({"sim_time": 120.0, "orders": {"orders": orders}}))
    assert _steady(report, tmp_path, 20.0).unit == "orders"
