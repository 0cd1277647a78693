"""The runs behind docs/results.md: which they are, and their results on disk.

Each part of the page has a file of compressed JSON lines in `benchmarks/results`, one line per run,
with commit, machine, date and a hash of the run's input files.
"""

from __future__ import annotations

import dataclasses
import datetime
import gzip
import hashlib
import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmarks.scale.plan import GRAPH, HARNESS, plan_jobs
from benchmarks.scale.sweep import run_jobs
from swarm_bench.execution.executor import executor, values
from swarm_bench.execution.task import Executor
from swarm_bench.halls.halls import hall_runs, run_hall
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import run
from swarm_bench.runs.machine import machine_line
from swarm_bench.runs.origin import commit_of
from swarm_bench.runs.result import RunResult, result_from_json
from swarm_bench.runs.ros_run import run_on_graph
from swarm_bench.suite.selection import select
from swarm_bench.suite.store import key_of, key_of_options
from swarm_bench.suite.table import run_line
from swarm_common.files.resources import find_resource
from swarm_common.model.engines import usual_engine

FOLDER = Path(__file__).with_name("results")
BASELINES = ("dwa", "orca")
BASELINE_LIMIT = 1200.0  # [s] of wall time for all seeds of a baseline in one scenario and size
SEEDS = range(10)
GRAPH_ROWS = ("circle", "corridor", "crossing", "doorway", "slim_blockage", "station", "u_shape")
GRAPH_MOST = 24  # robots of a row on the ROS graph
HALL_SEEDS = {(5, 12, 20): range(300), (35, 50): range(20)}  # by swarm sizes, in turn
SCALE_SIZES = (20, 50, 100)
UNKEPT = ("per_robot", "schema")  # fields of a result that the page does not need


@dataclass(frozen=True, slots=True)
class RunOrigin:
    """Where and when a run was made."""

    commit: str  # of the code, shortened
    machine: str  # in one line
    date: str  # ISO 8601
    inputs: str  # first digits of the SHA-256 of the input files; empty where there are none

    @classmethod
    def now(cls, inputs: str = "") -> RunOrigin:
        """Return the origin of a run that ends now."""
        today = datetime.datetime.now(datetime.UTC).date().isoformat()
        return cls(commit_of(Path(__file__).resolve().parents[1]), machine_line(), today, inputs)


@dataclass(frozen=True, slots=True)
class Kept:
    """One line of a file: a result and its origin."""

    data: Mapping[str, Any]  # the result's fields
    origin: RunOrigin

    @property
    def result(self) -> RunResult:
        """The result of a run of the bench or on the ROS graph."""
        return result_from_json({**self.data, "per_robot": {}})


def read_part(name: str) -> list[Kept]:
    """Return the lines of a part's file; none if there is no file."""
    path = FOLDER / f"{name}.jsonl.gz"
    if not path.is_file():
        return []
    with gzip.open(path, "rt", encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    return [Kept(line["result"], RunOrigin(**line["origin"])) for line in lines]


def write_part(name: str, lines: Iterable[Kept]) -> None:
    """Write the lines of a part's file; equal lines give equal bytes."""
    path, part = FOLDER / f"{name}.jsonl.gz", FOLDER / f".{name}.part"
    FOLDER.mkdir(exist_ok=True)
    with part.open("wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as file:
        for line in lines:
            entry = {"origin": dataclasses.asdict(line.origin), "result": line.data}
            text = json.dumps(entry, separators=(",", ":"))
            file.write(f"{text}\n".encode())
    part.replace(path)


def rows() -> list[list[RunOptions]]:
    """Return the runs of our method in the bench, a list per scenario and size."""
    return [cell(item, "ours") for item in first_runs()]


def baselines() -> list[list[RunOptions]]:
    """Return the runs of DWA and ORCA, likewise."""
    return [cell(item, method) for method in BASELINES for item in first_runs()]


def graph() -> list[list[RunOptions]]:
    """Return the runs on the ROS graph, likewise."""
    cells: dict[tuple[str, int], list[RunOptions]] = {}
    for item in select(",".join(GRAPH_ROWS), (), range(3), engine=usual_engine(), lidar=True):
        if item.robots <= GRAPH_MOST:
            cells.setdefault((item.scenario.name, item.robots), []).append(item)
    return list(cells.values())


def halls() -> list[list[RunOptions]]:
    """Return the runs in random halls, in lists of 20 seeds."""
    cells = []
    for sizes, seeds in HALL_SEEDS.items():
        for first in range(seeds.start, seeds.stop, 20):
            runs: list[RunOptions] = []
            for seed in seeds[first : first + 20]:
                size = sizes[seed % len(sizes)]
                runs += hall_runs([seed], [size], "drawn", "drawn", parameters={})
            cells.append(runs)
    return cells


def first_runs() -> list[RunOptions]:
    """Return one run of each scenario and size that comes with the project, small swarms first."""
    return sorted(select("all", (), [0]), key=lambda item: item.robots)


def cell(first: RunOptions, method: str) -> list[RunOptions]:
    """Return the runs of all seeds of a scenario, size and method."""
    return select(first.scenario.name, [first.robots], SEEDS, method=method)


PARTS: dict[str, tuple[Callable[[], list[list[RunOptions]]], Callable[[RunOptions], RunResult]]] = {
    "rows": (rows, run),
    "baselines": (baselines, run),
    "halls": (halls, run_hall),
    "graph": (graph, run_on_graph),
}
SCALE = "scale"


def measure(name: str, jobs: int, console: Console, cluster: str | None = None) -> None:
    """Run what a part of the page lacks, and add it; a list of runs is kept once it is complete.

    `jobs` processes run at once, or a `cluster`; runs on the ROS graph use one process.
    """
    if name == SCALE:
        measure_scale(console)
        return
    make_cells, runner = PARTS[name]
    is_graph = runner is run_on_graph
    at_once = jobs if name == "baselines" else sys.maxsize
    with executor(1 if is_graph else jobs, None if is_graph else cluster) as chosen:
        for options in make_cells():
            kept = read_part(name)
            known = {key_of(line.result) for line in kept}
            todo = [item for item in options if key_of_options(item, ros=is_graph) not in known]
            for result in _limited(chosen, todo, runner, at_once):
                console.print(run_line(result), highlight=False, soft_wrap=True, markup=False)
                data = {key: value for key, value in result.as_json().items() if key not in UNKEPT}
                kept.append(Kept(data, RunOrigin.now(inputs_of(options[0]))))
            if todo:
                write_part(name, kept)


def _limited(
    chosen: Executor,
    todo: Sequence[RunOptions],
    runner: Callable[[RunOptions], RunResult],
    at_once: int,
) -> Iterator[RunResult]:
    """Yield results; none of the next `at_once` begins after `BASELINE_LIMIT` of wall time."""
    end = time.monotonic() + BASELINE_LIMIT
    for first in range(0, len(todo), at_once):
        if time.monotonic() < end:
            yield from values(chosen, runner, todo[first : first + at_once])


def measure_scale(console: Console) -> None:
    """Run what the file of scale lacks: the hall with and without the ROS graph, one at a time."""
    kept = read_part(SCALE)
    known = {tuple(line.data["key"]) for line in kept}
    planned = (*plan_jobs(GRAPH, SCALE_SIZES, 3), *plan_jobs(HARNESS, SCALE_SIZES, 3))
    todo = [job for job in planned if job.key not in known]
    for job, result in zip(todo, run_jobs(todo), strict=True):
        console.print(f"{result.system} {result.robots} robots: {result.real_time_factor:.2f}x")
        data = {"key": list(job.key), **result.as_json()}
        kept.append(Kept(data, RunOrigin.now()))
        write_part(SCALE, kept)


def inputs_of(options: RunOptions) -> str:
    """Return the hash of the files that a run is made from; empty for a random hall."""
    scenario = options.scenario
    if scenario.world == "hall":
        return ""
    world = find_resource("world", scenario.world, "world.sdf").parent
    root = world.parents[1]
    folders = [world, *(root / "robots" / model for model in scenario.models(options.robots))]
    files = [path for folder in dict.fromkeys(folders) for path in folder.rglob("*")]
    files += root.glob(f"maps/{scenario.world}.*")
    files += root.glob(f"params/**/{scenario.mission}.yaml")
    files += root.glob(f"params/scenarios/{scenario.name}.yaml")
    digest = hashlib.sha256()
    for path in sorted(file for file in files if file.is_file()):
        digest.update(f"{path.relative_to(root)}\n".encode() + path.read_bytes())
    return digest.hexdigest()[:12]
