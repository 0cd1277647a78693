"""What a rule pays: rules and numbers are changed for a run only, and compared seed by seed."""

from __future__ import annotations

from collections import Counter
from typing import Any

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
from swarm_nav.core.config import config_from_parameters
from swarm_nav.core.plugins import RULE_NAMES, check_plugins
from tests.fakes.results import result


def test_each_rule_is_off_once_and_each_number_halved_and_doubled() -> None:
    names = [variant.name for variant in variants()]
    assert names[0] == BASE
    assert len(names) == len(set(names)) == 1 + len(RULES) + 2 * len(NUMBERS)
    halved, doubled = variants(["traffic.push_ticks"])[1:]
    assert (halved.values, doubled.values) == ({"traffic.push_ticks": 2}, {"traffic.push_ticks": 6})
    with pytest.raises(UnknownNameError, match="rule or number"):
        variants(["gat"])


def test_navigators_take_every_variant() -> None:
    for variant in variants():
        config = config_from_parameters(dict(variant.values))
        check_plugins(config)
    without = dict(variants(["make_way"])[1].values)["traffic.rules"]
    assert set(RULE_NAMES) - set(without.split()) == {"make_way"}


def test_a_run_gets_the_parameters_of_its_variant(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []
    monkeypatch.setattr(ablation, "run", lambda options: seen.append(options.parameters))
    job = AblationJob(
        Variant("one", {"traffic.push_ticks": 7}), select("circle", [8], [0])[0], False
    )
    assert run_job(job) == ("one", None)
    assert seen == [{"traffic.push_ticks": 7}]


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
    jobs = jobs_of(variants(["gate", "push"]), rows, [])
    assert len(missing(jobs_of(variants(["gate"]), [], rows), [])) == 2 * len(rows)  # as halls
    first = missing(jobs, [])
    assert Counter(job.key[:2] for job in first) == {
        (BASE, "circle"): 5, (BASE, "doorway"): 5, ("gate off", "circle"): PROBES,
        ("gate off", "doorway"): PROBES, ("push off", "circle"): PROBES,
        ("push off", "doorway"): PROBES,
    }  # fmt: skip
    done = []
    for name, scenario, robots, seed in (job.key for job in first):
        differs = (name, scenario, seed) == ("push off", "doorway", 2)
        found = result(scenario=scenario, robots=robots, seed=seed, trajectory_sha256=f"{differs}")
        done.append((name, found))
    later = missing(jobs, done)
    assert [job.key[:2] for job in later] == [("push off", "doorway")] * (5 - PROBES)
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
