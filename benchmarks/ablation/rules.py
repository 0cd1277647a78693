"""Benefit of each liveness rule and number: the same runs with one of them changed.

A rule is left out of `traffic.rules`, or switched off by its parameter; a number is halved and
doubled. Where the first runs of a row of the suite are the same tick for tick, the others are left
out.
"""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from swarm_bench.halls.halls import run_hall
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import run
from swarm_bench.runs.result import RunResult
from swarm_bench.suite.summary import mean_interval
from swarm_common.model.errors import UnknownNameError
from swarm_nav.core.config import NavConfig, parameter_values
from swarm_nav.core.plugins import RULE_NAMES

BASE = "as it is"
PROBES = 3  # runs of a row after which the others are left out if a variant changes nothing

RULES: Mapping[str, Mapping[str, Any]] = {
    **{
        name: {"traffic.rules": " ".join(other for other in RULE_NAMES if other != name)}
        for name in ("stop_before_obstacle", "plan_anew", "make_way", "leave", "wait")
    },
    "push": {"traffic.push_ticks": 10_000},
    "lease": {"holding.approach_slots": 1000},
    "gate": {"holding.gate_density": 0.0},
    "lanes": {"planner.lane_weight": 0.0},
    "station patience": {"holding.station_patience": 10_000.0},
}
"""How each rule is switched off: the parameters of a swarm without it."""

NUMBERS = (
    "traffic.push_ticks", "traffic.retry_time", "traffic.wait_time", "traffic.stuck_time",
    "holding.request_distance", "holding.hold_distance", "holding.approach_slots",
    "holding.search_distance", "holding.gate_density", "holding.region_density",
    "planner.lane_weight", "planner.lane_width", "planner.replan_period",
    "traffic.patience", "holding.station_patience",
)  # fmt: skip


Key = tuple[str, str, int, int]  # variant, scenario, robots, seed: which run it is


@dataclass(frozen=True, slots=True)
class Variant:
    """One rule or number changed; `values` by parameter."""

    name: str
    values: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class AblationJob:
    """One run of a variant."""

    variant: Variant
    options: RunOptions
    is_hall: bool

    @property
    def key(self) -> Key:
        """As `key_of` its result."""
        options = self.options
        return self.variant.name, options.scenario.name, options.robots, options.seed


def variants(only: Sequence[str] = ()) -> list[Variant]:
    """Return the navigators as they are, then each rule off, then each number halved and doubled.

    `only` names rules and numbers; empty for all. Raises UnknownNameError for any other name.
    """
    known = (*RULES, *NUMBERS)
    for name in only:
        if name not in known:
            raise UnknownNameError("rule or number", name, known)
    chosen = only or known
    found = [Variant(BASE)]
    found += [Variant(f"{name} off", RULES[name]) for name in RULES if name in chosen]
    for name in NUMBERS:
        if name in chosen:
            usual = _usual(name)
            found.append(Variant(f"{name} / 2", {name: _like(usual, usual / 2)}))
            found.append(Variant(f"{name} * 2", {name: _like(usual, usual * 2)}))
    return found


def _usual(name: str) -> float:
    value = parameter_values(NavConfig())[name]
    assert isinstance(value, int | float)
    return value


def _like(usual: float, value: float) -> float:
    return max(1, round(value)) if isinstance(usual, int) else value


def run_job(job: AblationJob) -> tuple[str, RunResult]:
    """Run a job; return the variant's name and the result."""
    parameters = {**job.options.parameters, **job.variant.values}
    options = replace(job.options, parameters=parameters)
    runner: Callable[[RunOptions], RunResult] = run_hall if job.is_hall else run
    return job.variant.name, runner(options)


def key_of(variant: str, result: RunResult) -> Key:
    """Return which run a result is of."""
    return variant, result.scenario, result.robots, result.seed


def missing(
    jobs: Sequence[AblationJob], results: Sequence[tuple[str, RunResult]]
) -> list[AblationJob]:
    """Return the runs that are still needed; call it again with their results until none is.

    Of a variant in a row of the suite, all seeds are needed only if it changes one of the first
    `PROBES`; each seed of a hall is another map.
    """
    known = {key_of(*found) for found in results}
    usual = _as_it_is(results)
    changed = {
        key_of(name, result)[:3]
        for name, result in results
        if not _is_same(usual.get(_run_of(result)), result)
    }
    found: list[AblationJob] = []
    counts: Counter[tuple[str, str, int]] = Counter()
    for job in jobs:
        row = job.key[:3]
        counts[row] += 1
        is_first = job.variant.name == BASE or job.is_hall or counts[row] <= PROBES
        if job.key not in known and (is_first or row in changed):
            found.append(job)
    return found


def ablation_markdown(results: Sequence[tuple[str, RunResult]]) -> str:
    """Return the table: a row per variant and kind of run, compared with `BASE` seed by seed."""
    usual = _as_it_is(results)
    lines = [
        "| changed | row | runs | goals | contacts | makespan | worst wait |",
        "| --- | --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    groups: dict[tuple[str, str], list[RunResult]] = {}
    for name, result in results:
        groups.setdefault((name, f"{result.scenario} {result.robots}"), []).append(result)
    for (name, row), runs in groups.items():
        pairs = [(usual[_run_of(run)], run) for run in runs if _run_of(run) in usual]
        contacts = sum(run.robot_robot + run.robot_world for run in runs)
        reached, sent = sum(r.goals_reached for r in runs), sum(r.goals_sent for r in runs)
        spans = [b.makespan / a.makespan for a, b in pairs if a.makespan and b.makespan]
        waits = [b.wait_worst / a.wait_worst for a, b in pairs if a.wait_worst]
        changes = [_change(spans), _change(waits)]
        if name != BASE and pairs and all(_is_same(*pair) for pair in pairs):
            changes = ["the same run"] * 2
        cells = (name, row, len(runs), f"{reached}/{sent}", contacts, *changes)
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def _as_it_is(
    results: Sequence[tuple[str, RunResult]],
) -> dict[tuple[str, int, int], RunResult]:
    return {_run_of(result): result for name, result in results if name == BASE}


def _is_same(before: RunResult | None, after: RunResult) -> bool:
    return before is not None and before.trajectory_sha256 == after.trajectory_sha256


def _run_of(result: RunResult) -> tuple[str, int, int]:
    return result.scenario, result.robots, result.seed


def _change(ratios: Sequence[float]) -> str:
    """Return the mean of ratios as a change, with the 95 % interval of a bootstrap over seeds."""
    if not ratios:
        return "-"
    logs = [math.log(ratio) for ratio in ratios]
    text = _percent(statistics.fmean(logs))
    if len(ratios) < 2:
        return text
    low, high = mean_interval(logs)
    return f"{text} [{_percent(low)}..{_percent(high)}]"


def _percent(log: float) -> str:
    return f"{100.0 * math.expm1(log):+.0f} %"


def jobs_of(
    chosen: Sequence[Variant], rows: Sequence[RunOptions], halls: Sequence[RunOptions]
) -> list[AblationJob]:
    """Return the runs, variant by variant."""
    jobs = []
    for variant in chosen:
        jobs += [AblationJob(variant, options, False) for options in rows]
        jobs += [AblationJob(variant, options, True) for options in halls]
    return jobs
