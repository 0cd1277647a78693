"""What a rule pays: rules and numbers are changed for a run only, and compared seed by seed."""

from __future__ import annotations

import importlib
from collections import Counter
from typing import Any

import numpy as np
import pytest

from benchmarks.__main__ import load
from benchmarks.ablation import rules as ablation
from benchmarks.ablation.rules import (
    BASE,
    NUMBERS,
    PROBES,
    RULES,
    AblationJob,
    Variant,
    ablation_markdown,
    jobs_of,
    missing,
    run_job,
    variants,
)
from swarm_bench.runs.result import RunResult
from swarm_bench.suite.selection import select
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import Pose
from swarm_nav.core.config import NavConfig, config_from_parameters, parameter_values
from swarm_nav.traffic import right_of_way
from swarm_nav.traffic.single_lanes import single_lanes
from tests.fakes.navigation import robot_in, room
from tests.fakes.results import result


def test_each_rule_is_off_once_and_each_number_halved_and_doubled() -> None:
    names = [variant.name for variant in variants()]
    assert names[0] == BASE
    assert len(names) == len(set(names)) == 1 + len(RULES) + 2 * len(NUMBERS)
    halved, doubled = variants(["traffic.push_ticks"])[1:]
    assert (halved.values, doubled.values) == ({"traffic.push_ticks": 2}, {"traffic.push_ticks": 6})
    with pytest.raises(UnknownNameError, match="rule or number"):
        variants(["gat"])


def test_what_is_changed_exists_and_navigators_take_it() -> None:
    known = parameter_values(NavConfig())
    for variant in variants():
        config_from_parameters({k: v for k, v in variant.values.items() if k in known})
        for name in variant.values.keys() - known.keys():
            module, _, constant = name.rpartition(".")
            assert hasattr(importlib.import_module(module), constant), name


def test_constants_are_changed_while_a_run_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []

    def run(options: Any) -> str:
        seen.append((right_of_way.RETREAT_DISTANCE, options.parameters))
        return "done"

    monkeypatch.setattr(ablation, "run", run)
    values = {"swarm_nav.traffic.right_of_way.RETREAT_DISTANCE": 9.0, "traffic.push_ticks": 7}
    job = AblationJob(Variant("both", values), select("circle", [8], [0])[0], is_hall=False)
    before = right_of_way.RETREAT_DISTANCE
    assert run_job(job) == ("both", "done")
    assert seen == [(9.0, {"traffic.push_ticks": 7})]
    assert before == right_of_way.RETREAT_DISTANCE


def test_what_the_navigators_keep_is_made_anew_with_other_constants(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Labels of passages were kept from the run before, so that their mouth could not be varied."""
    s = robot_in(room(8.0, 8.0, (4.0, 0.0, 4.2, 3.6), (4.0, 4.4, 4.2, 8.0)), Pose(2.0, 4.0, 0.0))
    sizes = []

    def run(options: Any) -> str:
        labels = single_lanes(s.terrain, s.radius)
        assert labels is not None
        sizes.append(np.count_nonzero(labels))
        return "done"

    monkeypatch.setattr(ablation, "run", run)
    options = select("circle", [8], [0])[0]
    for variant in variants(["swarm_nav.traffic.single_lanes.MOUTH"]):
        run_job(AblationJob(variant, options, is_hall=False))
    usual, halved, doubled = sizes
    assert halved < usual < doubled
    assert run_job(AblationJob(Variant(BASE), options, is_hall=False)) == (BASE, "done")
    assert sizes[-1] == usual


def test_runs_are_compared_seed_by_seed() -> None:
    def of(seed: int, makespan: float, wait: float) -> RunResult:
        return result(
            seed=seed, makespan=makespan, wait_worst=wait, trajectory_sha256=f"{makespan}"
        )

    results = [(BASE, of(seed, 100.0 + seed, 10.0)) for seed in range(4)]
    results += [("gate off", of(seed, 1.1 * (100.0 + seed), 20.0)) for seed in range(3)]
    last = ablation_markdown(results).splitlines()[-1]
    assert last.startswith("| gate off |")
    assert last.endswith("| +10 % [+10 %..+10 %] | +100 % [+100 %..+100 %] |")


def test_rows_in_which_a_variant_changes_nothing_are_left_after_the_first_runs() -> None:
    rows = [*select("circle", [8], range(5)), *select("doorway", [], range(5))]
    jobs = jobs_of(variants(["gate", "going on"]), rows, [])
    assert len(missing(jobs_of(variants(["gate"]), [], rows), [])) == 2 * len(rows)  # as halls
    first = missing(jobs, [])
    assert Counter(job.key[:2] for job in first) == {
        (BASE, "circle"): 5, (BASE, "doorway"): 5, ("gate off", "circle"): PROBES,
        ("gate off", "doorway"): PROBES, ("going on off", "circle"): PROBES,
        ("going on off", "doorway"): PROBES,
    }  # fmt: skip
    done = []
    for name, scenario, robots, seed in (job.key for job in first):
        differs = (name, scenario, seed) == ("going on off", "doorway", 2)
        found = result(scenario=scenario, robots=robots, seed=seed, trajectory_sha256=f"{differs}")
        done.append((name, found))
    later = missing(jobs, done)
    assert [job.key[:2] for job in later] == [("going on off", "doorway")] * (5 - PROBES)
    done += [(job.key[0], result(scenario="doorway", seed=job.key[3], robots=12)) for job in later]
    assert not missing(jobs, done)
    assert "| the same run | the same run |" in ablation_markdown(done).splitlines()[-2]


@pytest.mark.parametrize(
    ("words", "message"),
    [(["--halls", "none"], "nothing to run"), (["--trouble", "mud", "--halls", "none"], "mud")],
)
def test_an_ablation_of_no_runs_and_an_unknown_trouble_are_refused(
    words: list[str], message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        load()(["ablate", "--scenario", "none", *words], standalone_mode=False)
