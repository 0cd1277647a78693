"""Many runs, one after the other or in several processes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context

from swarm_bench.harness import run
from swarm_bench.result import RunResult
from swarm_bench.stage import RunOptions


def run_all(options: Sequence[RunOptions], jobs: int) -> Iterator[RunResult]:
    """Yield the result of each run as it comes."""
    if jobs == 1:
        for item in options:
            yield run(item)
        return
    # spawned, not forked: numba's and pybullet's threads do not survive a fork
    with ProcessPoolExecutor(min(jobs, len(options)), mp_context=get_context("spawn")) as pool:
        for future in as_completed([pool.submit(run, item) for item in options]):
            yield future.result()
