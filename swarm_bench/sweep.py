"""Many runs, one after the other or in several processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context

from swarm_bench.harness import run
from swarm_bench.result import RunResult
from swarm_bench.stage import RunOptions

Runner = Callable[[RunOptions], RunResult]


def run_all(
    options: Sequence[RunOptions], jobs: int = 1, runner: Runner = run
) -> Iterator[RunResult]:
    """Yield the result of each run as it comes.

    Args:
        options: The runs, in order.
        jobs: Processes.
        runner: Runs one.
    """
    if jobs == 1 or len(options) < 2:
        for item in options:
            yield runner(item)
        return
    # spawned, not forked: the threads of numba and pybullet do not survive a fork
    pool = ProcessPoolExecutor(min(jobs, len(options)), mp_context=get_context("spawn"))
    try:
        for future in as_completed([pool.submit(runner, item) for item in options]):
            yield future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
