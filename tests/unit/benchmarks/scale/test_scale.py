"""Jobs, results, tables, plots and comparisons of `benchmarks scale`, without running a swarm."""

import dataclasses
import io

import pytest
from rich.console import Console

from benchmarks.scale.command import comparison_table
from benchmarks.scale.plan import GRAPH, HARNESS, plan_jobs
from benchmarks.scale.result import FIGURES, ScaleResult, growth, rows_of, scale_table
from benchmarks.scale.runs import store_of, sweep_of
from swarm_bench.runs.document import replace_part
from swarm_common.model.engines import usual_engine
from swarm_common.model.errors import ConfigError, UnknownNameError


def result_of(job, code="", machine="", cost=1.0):
    return ScaleResult(
        system=job.system, workload=job.workload, robots=job.robots, repeat=job.repeat,
        setting=job.setting, start_up=2.0 + job.repeat, sim_time=job.seconds, wall_time=30.0,
        cpu_ms={"world": 2.0 * cost, "navigators": 5.0 * cost, "other": 1.0},
        memory_mb={"total": 100.0, "robot": 20.0, "rss": 300.0}, late_ticks=0, collisions=0,
        goals_reached=3, others=0.01, code=code, machine=machine,
    )  # fmt: skip


def text_of(table):
    console = Console(width=250, file=io.StringIO())
    console.print(table.rich())
    return console.file.getvalue()


def test_large_swarms_are_packed_and_jobs_come_repeat_by_repeat():
    jobs = plan_jobs(GRAPH, [20, 100, 200], 1)
    assert [(job.workload, job.pack) for job in jobs] == [
        ("hall", 1), ("hall", 1), ("warehouse", 10),
    ]  # fmt: skip
    assert {job.engine for job in jobs} == {usual_engine()}
    assert plan_jobs(HARNESS, [200], 1)[0].pack == 1
    assert plan_jobs(HARNESS, [20], 1)[0].engine == "planar"
    jobs = plan_jobs(HARNESS, [5, 20], 2)
    assert [(job.repeat, job.robots) for job in jobs] == [(0, 5), (0, 20), (1, 5), (1, 20)]


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        ({"workload": "moon"}, UnknownNameError, "moon"),
        ({"workload": "hall", "sizes": [150]}, ConfigError, "room for 100"),
        ({"engine": "gazebo"}, UnknownNameError, "gazebo"),
        ({"repeats": 0}, ConfigError, "--repeats"),
        ({"seconds": 1.0}, ConfigError, "--seconds"),
        ({"pack": 0}, ConfigError, "--pack"),
        ({"sizes": [0]}, ConfigError, "swarm size"),
    ],
)
def test_impossible_sweeps_are_refused(options, kind, message):
    values = {"sizes": [20], "repeats": 1} | options
    with pytest.raises(kind, match=message):
        plan_jobs(GRAPH, values.pop("sizes"), values.pop("repeats"), **values)


def test_a_sweep_goes_on_where_it_was(tmp_path):
    file, done = tmp_path / "scale.jsonl", []

    def runner(job):
        done.append(job.key)
        return result_of(job)

    jobs = plan_jobs(HARNESS, [5, 20], 2)
    for some in (jobs[:3], jobs):
        results = sweep_of(some, file, runner).run(Console(file=io.StringIO()))
    assert len(done) == len(jobs) == len(results) == len(store_of(file).read())
    assert {result.key for result in results} == {job.key for job in jobs}


def test_rows_are_medians_with_growth_and_other_work_told():
    rows = rows_of(result_of(job) for job in plan_jobs(GRAPH, [100, 20], 3))
    assert [row.first.robots for row in rows] == [20, 100]
    assert rows[0].median(lambda run: run.start_up) == pytest.approx(3.0)
    assert rows[0].median(FIGURES["real-time factor"].of) == pytest.approx(4.0)
    assert rows[0].cpu_total == pytest.approx(8.0)
    assert not rows[0].is_noisy
    assert "start-up [s]" in text_of(scale_table(rows, list(FIGURES)))
    few, many = plan_jobs(GRAPH, [20, 100], 1)
    rows = rows_of([result_of(few), result_of(many, cost=2.0)])
    assert growth(rows) == pytest.approx(15.0 / 8.0)
    assert growth(rows[:1]) is None
    (job,) = plan_jobs(GRAPH, [20], 1)
    (row,) = rows_of([dataclasses.replace(result_of(job), others=0.4)])
    assert row.is_noisy


def test_comparison_gives_ratios():
    jobs = plan_jobs(GRAPH, [20], 1)
    first, second = ([result_of(job, cost=cost) for job in jobs] for cost in (1.0, 0.5))
    text = text_of(comparison_table(("a.jsonl", "b.jsonl"), (first, second)))
    navigators = next(line for line in text.splitlines() if " navigators " in line)
    assert navigators.split()[-3:] == ["5.00", "2.50", "0.50"]


def test_a_part_of_a_document_is_replaced_and_nothing_else(tmp_path):
    file = tmp_path / "document.md"
    file.write_text("a\n<!-- x -->\nold\n<!-- /x -->\nb\n", "utf-8")
    for _ in range(2):
        replace_part(file, "x", "new\n")
    assert file.read_text("utf-8") == "a\n<!-- x -->\n\nnew\n\n<!-- /x -->\nb\n"
    with pytest.raises(ConfigError, match="no part 'y'"):
        replace_part(file, "y", "new")
