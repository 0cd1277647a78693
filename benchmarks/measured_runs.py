"""The runs behind docs/results.md: which they are, and their results on disk.

Each part of the page has a file of compressed JSON lines in `benchmarks/results`, one line per run,
with commit, processor, date and a hash of the run's inputs.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from benchmarks.scale.plan import GRAPH, HARNESS, plan_jobs
from benchmarks.scale.result import ScaleResult
from benchmarks.scale.runs import store_of as scale_store
from benchmarks.scale.runs import sweep_of
from swarm_bench.execution.executor import executor
from swarm_bench.execution.store import Store
from swarm_bench.halls.halls import hall_runs, load_hall_inputs, run_hall
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.fingerprint import load_inputs
from swarm_bench.runs.harness import run
from swarm_bench.runs.result import line_from_json
from swarm_bench.suite.selection import select
from swarm_bench.suite.sweep import Outcome, RunSweep, key_of
from swarm_common.model.engines import usual_engine
from swarm_run.record.run_record import RunRecord

FOLDER = Path(__file__).with_name("results")
BASELINES = ("dwa", "orca")
BASELINE_LIMIT = 600.0  # [s] of wall time for all seeds of a baseline in one scenario and size
SEEDS = range(10)
GRAPH_ROWS = ("circle", "corridor", "crossing", "doorway", "slim_blockage", "station", "u_shape")
GRAPH_MOST = 24  # robots of a row on the ROS graph
HALL_SEEDS = {(5, 12, 20): range(300), (35, 50): range(20)}  # by swarm sizes, in turn
SCALE = "scale"
SCALE_SIZES = (20, 50, 100)


def store_of(name: str) -> Store[Outcome]:
    """Return the store of a part; robots one by one are left out, as the page has none."""
    return Store(
        FOLDER / f"{name}.jsonl.gz",
        lambda data: line_from_json({**data, "per_robot": {}}),
        "python -m benchmarks results",
    )


def results_of(name: str) -> list[RunRecord]:
    """Return the results of a part; none if there is no file."""
    return [line for _, line in store_of(name).read() if isinstance(line, RunRecord)]


def scale_results() -> list[ScaleResult]:
    """Return the results of the part on scale."""
    return [result for _, result in scale_store(FOLDER / f"{SCALE}.jsonl.gz").read()]


def rows(method: str = "ours") -> list[list[RunOptions]]:
    """Return the runs in the bench, a list per scenario and size, small swarms first."""
    first = sorted(select("all", (), [0]), key=lambda item: item.robots)
    return [select(one.scenario.name, [one.robots], SEEDS, method=method) for one in first]


def halls() -> list[list[RunOptions]]:
    """Return the runs in random halls."""
    return [
        [
            options
            for sizes, seeds in HALL_SEEDS.items()
            for seed in seeds
            for options in hall_runs([seed], [sizes[seed % len(sizes)]], "drawn", "drawn")
        ]
    ]


def graph() -> list[list[RunOptions]]:
    """Return the runs on the ROS graph."""
    runs = select(",".join(GRAPH_ROWS), (), range(3), engine=usual_engine(), lidar=True)
    return [[item for item in runs if item.robots <= GRAPH_MOST]]


PARTS: dict[str, Callable[[], list[list[RunOptions]]]] = {
    "rows": rows,
    "baselines": lambda: [cell for method in BASELINES for cell in rows(method)],
    "halls": halls,
    "graph": graph,
}


def measure(name: str, jobs: int, console: Console, cluster: str | None = None) -> None:
    """Run what a part of the page lacks, and keep it.

    `jobs` processes run at once, or a `cluster`; runs on the ROS graph use one process.
    """
    if name == SCALE:
        planned = [job for system in (GRAPH, HARNESS) for job in plan_jobs(system, SCALE_SIZES, 3)]
        costs = sweep_of(planned, FOLDER / f"{SCALE}.jsonl.gz")
        costs.run(console)
        costs.store.pack(costs.key_of)
        return
    is_graph = name == "graph"
    at_once = jobs if name == "baselines" else sys.maxsize
    store = store_of(name)
    with executor(1 if is_graph else jobs, None if is_graph else cluster) as chosen:
        for cell in PARTS[name]():
            end = time.monotonic() + BASELINE_LIMIT
            for first in range(0, len(cell), at_once):
                if at_once < sys.maxsize and time.monotonic() >= end:
                    break
                sweep = RunSweep(
                    cell[first : first + at_once],
                    store.path,
                    chosen,
                    ros=is_graph,
                    runner=run_hall if name == "halls" else run,
                    load=load_hall_inputs if name == "halls" else load_inputs,
                    any_code=True,
                )
                sweep.run(console)
    store.pack(key_of)
