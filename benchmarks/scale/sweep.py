"""The runs of `benchmarks scale`, one after the other, with their results kept on disk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from rich.console import Console

from benchmarks.scale.graph import run_graph
from benchmarks.scale.plan import GRAPH, ScaleJob
from benchmarks.scale.process import run_harness
from benchmarks.scale.result import ScaleResult, read_scale_results
from swarm_bench.runs.episode import RunOptions, check
from swarm_bench.runs.json_lines import collected, taken_over
from swarm_bench.runs.machine import machine_line
from swarm_bench.runs.origin import commit_of
from swarm_bench.suite.table import number

Runner = Callable[[ScaleJob, str, str], ScaleResult]


def run_scale(
    jobs: Sequence[ScaleJob], file: Path | None, console: Console, runner: Runner | None = None
) -> list[ScaleResult]:
    """Run the jobs that are not in a result file yet, add their results to it, and return all.

    Args:
        file: JSON lines; None to keep nothing.
        runner: Runs peers; None for our own systems.
    """
    for job in {(job.workload, job.robots): job for job in jobs}.values():
        check(RunOptions(scenario=job.scenario, robots=job.robots))
    known = read_scale_results(file) if file is not None and file.is_file() else []
    keys = {job.key for job in jobs}
    results = [result for result in known if result.key in keys]
    done = {result.key for result in results}
    if results:
        console.print(taken_over(len(results), len(jobs), file), soft_wrap=True, markup=False)
    new = run_jobs([job for job in jobs if job.key not in done], runner)
    return results + collected(new, file, console, scale_line, ScaleResult.as_json)


def run_jobs(jobs: Sequence[ScaleJob], runner: Runner | None = None) -> Iterator[ScaleResult]:
    """Yield the result of each run as it comes; `runner` is None for our own systems."""
    machine = machine_line()
    for job in jobs:
        run = runner or (run_graph if job.system == GRAPH else run_harness)
        folder = job.code or Path(__file__).resolve().parents[2]
        yield run(job, commit_of(folder), machine)


def scale_line(result: ScaleResult) -> str:
    """Return one line about one run."""
    cpu = result.cpu_ms
    others = None if result.others is None else 100.0 * result.others
    return (
        f"{result.system} {result.workload} {result.robots} robots run {result.repeat + 1}: "
        f"start {number(result.start_up, 1)} s, {result.sim_time:.0f} s at "
        f"{result.real_time_factor:.2f}x, {result.cpu_total:.2f} ms per robot-second "
        f"(world {number(cpu.get('world'), 2)}, navigators {number(cpu.get('navigators'), 2)}, "
        f"other {number(cpu.get('other'), 2)}), "
        f"memory {number(result.memory_mb.get('total'), 0)} MB, late {result.late_ticks}, "
        f"collisions {result.collisions}, others used {number(others, 0)} % of the machine"
    )
