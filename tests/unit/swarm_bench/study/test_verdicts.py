"""Verdicts of comparisons, and the sequential rule."""

import dataclasses
import itertools
import random

import msgspec
import pytest

from swarm_bench.statistics import jackknifed_ratio
from swarm_bench.study.experiments import FIRST_SEED, LOOKS, load_experiments, study_folder
from swarm_bench.study.recovery import recovery_of
from swarm_bench.study.tables import SizeVerdicts
from swarm_bench.study.trials.cell import StudyRun
from swarm_bench.study.verdicts import (
    MEASURES,
    all_findings,
    by_sample,
    due_runs,
    effect_of,
    fitting_lines,
    judged,
)
from tests.fakes.study import made_up, sampled, write_experiments

SEEDS = range(FIRST_SEED, FIRST_SEED + LOOKS[0])


@pytest.fixture
def experiments(tmp_path):
    return write_experiments(tmp_path)


def found_in(experiments, lines):
    return all_findings(experiments, by_sample(lines))["speed"]


def values(cell, method, chance):
    """Ours is 20 % faster in jobs, 20 % slower in streams, and gains from robots."""
    base = 100.0 * (cell.robots / 4) * (0.8 if method == "ours" else 1.0)
    return base * chance.gauss(1.0, 0.01)


def test_verdicts_follow_from_interval_and_adjusted_p_value(experiments):
    found = found_in(experiments, sampled(experiments, SEEDS, values))
    assert [each.verdict for each in found] == [
        "ahead",
        "behind",
        "behind",
        "equal",
        "ahead",
        "open",
    ]
    job, stream = found[:2]
    assert job.effect.estimate == pytest.approx(0.2, abs=0.01)
    assert stream.effect.estimate == pytest.approx(-0.2, abs=0.01)
    assert job.effect.low < 0.2 < job.effect.high
    assert [judged(found[:1]), judged(found[1:3]), judged(found[3:4]), judged(found[5:])] == [
        "wrong", "wrong", "right", "open",
    ]  # fmt: skip


def test_without_20_pairs_nothing_is_decided(experiments):
    lines = sampled(experiments, list(SEEDS)[:-1], values)
    found = found_in(experiments, lines)
    assert {each.verdict for each in found} == {"open"}
    assert {each.reason for each in found} == {"not run"}
    due = due_runs(experiments, lines, {})
    assert {run.seed for run in due} == {SEEDS[-1]}
    assert len(due) == 8
    assert len(due_runs(experiments, [], {})) == 8 * LOOKS[0]


def test_undecided_comparisons_get_ten_seeds_more_up_to_60(experiments):
    def noisy(cell, method, chance):
        return 100.0 * (1.04 if method == "ours" else 1.0) * chance.gauss(1.0, 0.2)

    lines, looks = [], []
    while due := due_runs(experiments, lines, {}):
        looks.append(max(run.seed for run in due) + 1 - FIRST_SEED)
        for run in due:
            value = noisy(run.cell, run.method, random.Random(str(run.key)))
            lines.append(made_up(run, value))
        assert len({line.key for line in lines}) == len(lines)
    assert looks == list(LOOKS)
    assert {each.reason for each in found_in(experiments, lines) if each.verdict == "open"} == {
        "60 seeds do not decide"
    }


def test_decided_comparisons_get_no_more_seeds_and_none_gets_them_beyond_the_budget(experiments):
    lines = sampled(experiments, SEEDS, values)
    due = due_runs(experiments, lines, {})
    assert {(run.cell.name, run.seed) for run in due} == {  # both always succeed: not decided
        ("stream 4", seed) for seed in range(FIRST_SEED + 20, FIRST_SEED + 30)
    }
    lines[0] = msgspec.structs.replace(lines[0], cpu=20.0 * 3600.0)
    assert due_runs(experiments, lines, {}) == []


def test_a_pair_whose_trajectories_came_before_does_not_count(experiments):
    lines = sampled(experiments, SEEDS, values)
    lines = [
        msgspec.structs.replace(line, trajectory_sha256="the same")
        if line.seed < FIRST_SEED + 3
        else line
        for line in lines
    ]
    job = found_in(experiments, lines)[0]
    assert (job.pairs, job.repeated) == (18, 2)
    assert (job.verdict, job.reason) == ("open", "18 different pairs")


def test_stopped_runs_and_failed_centres_are_worst_but_bounded(experiments):
    lines = sampled(experiments, SEEDS, values)
    lines = [
        line if line.method == "ours"
        else msgspec.structs.replace(
            line, makespan=None, per_hour=None if line.per_hour is None else 0.0, failure="lost",
        )
        for line in lines
    ]  # fmt: skip
    job, stream, _, kept, _, success = found_in(experiments, lines)
    assert job.effect.estimate == pytest.approx(1.0 - 80.0 / 300.0, abs=0.01)  # of the limit
    assert stream.effect.estimate == pytest.approx(1.0)
    assert success.verdict == "ahead"
    assert success.ended == (20, 0)
    assert success.effect.low > 0.5
    assert kept.means == (pytest.approx(1.0, abs=0.01), 0.0)  # of nothing nothing is kept


def test_equal_values_are_equal_and_p_values_are_adjusted(experiments):
    found = found_in(experiments, sampled(experiments, SEEDS, lambda cell, *_: 50.0 * cell.robots))
    assert [each.verdict for each in found[:4]] == ["equal"] * 4
    assert found[0].p == 1.0
    effect, p = effect_of([(2.0, 1.0)] * 20, MEASURES["throughput"])
    assert (effect.low, effect.high) == (0.5, 0.5)
    assert p < 1e-3
    found = found_in(experiments, sampled(experiments, SEEDS, values))
    assert all(each.adjusted >= each.p for each in found)


def test_lines_of_other_cells_or_settings_do_not_fit(experiments):
    lines = sampled(experiments, [FIRST_SEED], values)
    assert fitting_lines(experiments, lines, {}) == lines
    odd = [
        msgspec.structs.replace(lines[0], **change)
        for change in (
            {"condition": "other"}, {"cell": "x 4"}, {"settings": "a=1"}, {"method": "dwa"},
        )
    ]  # fmt: skip
    assert fitting_lines(experiments, odd, {}) == []
    tuned = {"ours": (("a", 1),)}
    assert fitting_lines(experiments, odd, tuned) == [odd[2]]


def test_a_cell_that_says_something_else_is_another_condition(experiments):
    cell = experiments["speed"].cells[0]
    assert cell.condition != msgspec.structs.replace(cell, seconds=301.0).condition
    assert cell.condition == msgspec.structs.replace(cell, quick=False).condition
    run = StudyRun("speed", cell, "ours", 1)
    assert run.key != dataclasses.replace(run, cell=msgspec.structs.replace(cell, loss=0.1)).key


def test_the_protocol_is_what_the_code_does():
    text = (study_folder().parents[1] / "study/protocol.md").read_text(encoding="utf-8")
    assert f"{FIRST_SEED} to {FIRST_SEED + LOOKS[-1] - 1}" in text
    assert "looked at with 20 pairs, then with 30, 40, 50 and 60" in text
    assert LOOKS == (20, 30, 40, 50, 60)
    for name, measure in MEASURES.items():
        row = next(line for line in text.splitlines() if line.startswith(f"| {name} |"))
        assert f"| {measure.smallest:.0%}".replace("%", " %") in row


def test_what_comes_with_the_project_can_be_run():
    experiments = load_experiments(study_folder())
    assert set(experiments) == {"scalability", "adaptability", "fault_tolerance", "makespan"}
    runs = due_runs(experiments, [], {})
    assert len({run.key for run in runs}) == len(runs)
    assert {run.seed for run in runs} == set(SEEDS)
    assert sum(run.cost() for run in runs) < 20.0 * 3600.0


def test_runs_that_compare_times_of_the_machine_follow_each_other():
    runs = due_runs(load_experiments(study_folder()), [], {})
    groups = itertools.groupby(runs, lambda run: (run.experiment, run.cell.scenario, run.seed))
    keys = [key for key, _ in groups]
    assert len(set(keys)) == len(keys)


def test_methods_of_a_cell_and_seed_come_together_and_cheap_seeds_first(experiments):
    runs = due_runs(experiments, [], {})
    pairs = list(zip(runs[::2], runs[1::2], strict=True))
    assert all((a.cell, a.seed) == (b.cell, b.seed) for a, b in pairs)
    assert all(a.faults() == b.faults() for a, b in pairs)
    assert [a.seed for a, _ in pairs[:4]] == [FIRST_SEED] * 4


def test_the_first_look_that_decides_ends_a_comparison(experiments):
    seeds = range(FIRST_SEED, FIRST_SEED + 30)
    lines = [
        msgspec.structs.replace(line, makespan=1.0) if line.seed >= SEEDS[-1] + 1
        and line.makespan and line.method != "ours" else line
        for line in sampled(experiments, seeds, values)
    ]  # fmt: skip
    job, *_, success = found_in(experiments, lines)
    assert (job.look, job.verdict) == (20, "ahead")
    assert success.look == 30


def test_a_hypothesis_is_wrong_only_by_what_matters(experiments):
    def nearly(cell, method, chance):
        return 100.0 * (0.98 if method == "ours" else 1.0) * chance.gauss(1.0, 0.001)

    lines = sampled(experiments, SEEDS, values)
    job = found_in(experiments, lines)[0]
    assert judged([expecting(job, "ahead")]) == judged([expecting(job, "not behind")]) == "right"
    assert judged([expecting(job, "equal")]) == judged([expecting(job, "behind")]) == "wrong"
    small = found_in(experiments, sampled(experiments, SEEDS, nearly))[0]
    assert (small.verdict, judged([expecting(small, "behind")])) == ("equal", "open")


def expecting(finding, expected):
    comparison = finding.comparison._replace(expected=expected)
    return dataclasses.replace(finding, comparison=comparison)


def test_what_is_kept_is_the_sum_by_the_sum():
    """A mean of ratios is larger, the more the twins scatter."""
    chance = random.Random(1)
    wholes = [100.0 * chance.lognormvariate(0.0, 0.3) for _ in range(2000)]
    parts = [100.0 * chance.lognormvariate(0.0, 0.3) for _ in range(2000)]
    assert sum(a / b for a, b in zip(parts, wholes, strict=True)) / 2000 > 1.05
    found = jackknifed_ratio(parts, wholes)
    assert sum(found) / 2000 == pytest.approx(1.0, abs=0.02)
    assert sum(found) / 2000 == pytest.approx(sum(parts) / sum(wholes), rel=1e-3)
    assert jackknifed_ratio([3.0, 0.0], [0.0, 0.0]) == [0.0, 0.0]
    assert jackknifed_ratio([2.0], [4.0]) == [0.5]
    assert jackknifed_ratio([], []) == []


def test_sides_change_between_sizes_that_are_decided():
    def change(*verdicts):
        return SizeVerdicts("hall", dict(zip((10, 20, 50, 100), verdicts, strict=False))).change

    assert change("ahead", "open", "behind", "behind") == (10, 50)
    assert change("ahead", "equal", "ahead") is None
    assert change("ahead", "behind", "ahead") is None  # not once
    assert change() is None


def test_a_run_has_recovered_once_it_does_as_much_as_its_twin():
    twin = [2] * 40
    done = [2] * 10 + [0] * 10 + [2] * 20
    assert recovery_of(done, twin, 15) == (4, True)  # a window of 12 steps with 22 of 24 orders
    assert recovery_of([2] * 10 + [1] * 30, twin, 15) == (14, False)
