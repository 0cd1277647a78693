"""The command `swarm-bench`: its options."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from swarm_bench import sweep
from swarm_bench.result import RunResult
from swarm_bench.selection import parse_seeds, parse_sizes, select
from swarm_bench.table import run_line, summary_table

MISSED = 1

bench_app = typer.Typer(add_completion=False, rich_markup_mode=None, no_args_is_help=True)


@bench_app.callback()
def bench() -> None:
    """Measure the swarm: many seeded runs, tables and JSON."""


@bench_app.command()
def traffic(
    scenario: Annotated[str, typer.Option(help="Names or files, comma-separated, or all.")] = "all",
    robots: Annotated[str | None, typer.Option(help="Swarm sizes, like 20,50.")] = None,
    seeds: Annotated[str, typer.Option(help="Seeds, like 0-19 or 1,5,7.")] = "0-2",
    loss: Annotated[float | None, typer.Option(help="Share of beacons that are lost.")] = None,
    delay: Annotated[float | None, typer.Option(help="[s] by which beacons are late.")] = None,
    engine: Annotated[str, typer.Option(help="planar (fast) or bullet (physics).")] = "planar",
    lidar: Annotated[bool | None, typer.Option(help="In place of the scenario's.")] = None,
    method: Annotated[str, typer.Option(help="ours, dwa or orca.")] = "ours",
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Parameter, like traffic.safety_margin=0.06.")
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes.")] = 1,
    json_: Annotated[
        Path | None, typer.Option("--json", help="Append each run to this file of JSON lines.")
    ] = None,
) -> None:
    """Run the traffic suite without the ROS graph.

    Exit code: 0 every goal reached without a collision; 1 otherwise; 2 bad input.
    """
    options = select(
        scenario,
        parse_sizes(robots),
        parse_seeds(seeds),
        method=method,
        engine=engine,
        loss=loss,
        delay=delay,
        lidar=lidar,
        settings=set_ or [],
    )
    console = Console()
    results: list[RunResult] = []
    with_file = json_.open("a", encoding="utf-8") if json_ is not None else None
    for result in sweep.run_all(options, jobs):
        results.append(result)
        console.print(run_line(result), highlight=False, soft_wrap=True)
        if with_file is not None:
            with_file.write(json.dumps(result.as_json(), allow_nan=False) + "\n")
            with_file.flush()
    console.print(summary_table(results))
    if not all(result.is_flawless for result in results):
        raise typer.Exit(MISSED)
