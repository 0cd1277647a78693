"""The command `python -m benchmarks peers`: other simulators and ours on the same workload."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.app import benchmarks_app
from benchmarks.peer_jobs import OURS_INCLUDES, PEERS, check_python, run_peer
from benchmarks.scale.plan import HARNESS, ScaleJob, plan_jobs
from benchmarks.scale.process import run_harness
from benchmarks.scale.result import ScaleResult
from benchmarks.scale.row import COMMON, ENDS, Column, ScaleRow, rows_of, scale_table
from benchmarks.scale.sweep import run_scale
from swarm_bench.runs.episode import RunOptions, build
from swarm_bench.suite.command import JsonLines, new_console
from swarm_bench.suite.selection import parse_sizes
from swarm_common.model.errors import UnknownNameError

WORKLOAD = "pillars"
ALL = "all"


@benchmarks_app.command()
def peers(
    python: Annotated[Path, typer.Option(help="Interpreter of the environment with the peers.")],
    robots: Annotated[str, typer.Option(help="Swarm sizes.")] = "1,5,20,50,100",
    names: Annotated[str, typer.Option("--peers", help="Names, comma-separated, or all.")] = ALL,
    repeats: Annotated[int, typer.Option(help="Runs of each size; tables have medians.")] = 3,
    seconds: Annotated[float, typer.Option(help="Simulated seconds of a run, at most.")] = 120.0,
    json_: JsonLines = None,
) -> None:
    """Measure other simulators and our harness: same hall, starts and goals.

    Peers run in an environment of their own, since some need older packages than we do:
    python3 -m venv peers; peers/bin/pip install pybullet-fleet ir-sim pyrvo navground
    """
    chosen = list(PEERS) if names == ALL else [name.strip() for name in names.split(",")]
    for name in chosen:
        if name not in PEERS:
            raise UnknownNameError("peer", name, PEERS)
    check_python(python)
    sizes = parse_sizes(robots)
    jobs = [
        job
        for system in (HARNESS, *chosen)
        for job in plan_jobs(system, sizes, repeats, workload=WORKLOAD, seconds=seconds)
    ]

    def run(job: ScaleJob, code: str, machine: str) -> ScaleResult:
        if job.system == HARNESS:
            return run_harness(job, code, machine)
        return run_peer(job, python, machine)

    console = new_console()
    results = run_scale(jobs, json_, console, run)
    rows = sorted(rows_of(results), key=lambda row: (row.first.robots, row.cpu_total))
    columns = {**_columns(), **_goal_column(sorted({job.robots for job in jobs}))}
    console.print(scale_table(rows, columns))
    console.print(_legend(rows), markup=False)


def _columns() -> dict[str, Column]:
    common = {name: COMMON[name] for name in ("start-up [s]", "real-time factor", "CPU [ms]")}
    return {
        "robots": COMMON["robots"],
        "system": lambda row: "ours" if row.first.system == HARNESS else row.first.system,
        **common,
        "RSS [MB]": lambda row: f"{row.memory('rss') or 0.0:.0f}",
        "simulated [s]": lambda row: f"{row.median(lambda run: run.sim_time) or 0.0:.0f}",
        **ENDS,
    }


def _goal_column(sizes: Sequence[int]) -> dict[str, Column]:
    """Return the column of goals reached, out of those of the mission."""
    asked = {size: _goal_count(size) for size in sizes}
    return {"goals": lambda row: f"{row.total('goals_reached')}/{asked[row.first.robots]}"}


def _goal_count(robots: int) -> int:
    job = plan_jobs(HARNESS, [robots], 1, workload=WORKLOAD)[0]
    stage = build(RunOptions(scenario=job.scenario, robots=robots))
    stage.world.close()
    return sum(itinerary.total for itinerary in stage.itineraries)


def _legend(rows: Sequence[ScaleRow]) -> str:
    """Return what each system computes for its figures."""
    lines = [f"- ours: {OURS_INCLUDES}\n"]
    for name, system in PEERS.items():
        versions = {row.first.code for row in rows if row.first.system == name}
        if versions:
            lines.append(f"- {name} ({', '.join(sorted(versions))}): {system.includes}\n")
    return "What the figures pay for:\n\n" + "".join(lines)
