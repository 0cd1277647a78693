"""Many runs, one after the other or in several processes, with their results kept on disk."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

from rich.console import Console

from swarm_bench.runs.episode import RunOptions, check
from swarm_bench.runs.harness import run
from swarm_bench.runs.json_lines import collected, taken_over
from swarm_bench.runs.result import RunResult
from swarm_bench.runs.ros_run import run_on_graph
from swarm_bench.suite import store
from swarm_bench.suite.table import run_line
from swarm_common.process import start
from swarm_common.process.compile_watch import watched

T = TypeVar("T")
R = TypeVar("R")
Runner = Callable[[RunOptions], RunResult]


@dataclass(frozen=True, slots=True)
class Sweep:
    """What to run, and how."""

    options: Sequence[RunOptions]  # the runs, in order
    jobs: int = 1  # processes
    ros: bool = False  # whether on the ROS graph
    runner: Runner = run  # runs one in the bench

    def check(self) -> None:
        """Check each scenario and size before anything runs.

        Raises:
            SwarmError: For the first thing that is wrong.
        """
        seen: set[tuple[str, int]] = set()
        for item in self.options:
            if (item.scenario.name, item.robots) not in seen:
                seen.add((item.scenario.name, item.robots))
                check(item)

    def run(self, file: Path | None, console: Console) -> list[RunResult]:
        """Run the jobs that are not in a result file yet, add their results to it, and return all.

        Args:
            file: Of JSON lines; None to keep nothing.
        """
        known = store.read_results(file) if file is not None and file.is_file() else []
        keys = {store.key_of_options(item, ros=self.ros) for item in self.options}
        results = [result for result in known if store.key_of(result) in keys]
        todo = store.missing(self.options, known, ros=self.ros)
        if results:
            console.print(
                taken_over(len(results), len(self.options), file), soft_wrap=True, markup=False
            )
        new = in_processes(todo, self.jobs, run_on_graph if self.ros else self.runner)
        return results + collected(new, file, console, run_line, RunResult.as_json)


def in_processes(options: Sequence[T], jobs: int, runner: Callable[[T], R]) -> Iterator[R]:
    """Yield the result of each job as it comes."""
    told = functools.partial(_run_and_tell, runner)
    if jobs == 1 or len(options) < 2:
        for item in options:
            yield told(item)
        return
    # spawned, not forked: the threads of numba and pybullet do not survive a fork
    pool = ProcessPoolExecutor(min(jobs, len(options)), mp_context=get_context("spawn"))
    try:
        for future in as_completed([pool.submit(told, item) for item in options]):
            yield future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _run_and_tell(runner: Callable[[T], R], item: T) -> R:
    """Run one; a first compilation, which takes a minute or two, does not look like a hang."""
    start.prepare()  # also in a worker process
    with watched(lambda *_: _say_compiling(), packages=()):
        return runner(item)


@functools.cache  # once per process
def _say_compiling() -> None:
    sys.stderr.write("compiling kernels, once: a minute or two\n")
    sys.stderr.flush()
