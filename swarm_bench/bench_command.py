"""The command `swarm-bench`: its options."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from swarm_bench import store
from swarm_bench.machine import machine_line
from swarm_bench.report import traffic_report
from swarm_bench.result import RunResult
from swarm_bench.ros_run import run_on_graph
from swarm_bench.selection import SUITE, check_jobs, parse_seeds, parse_sizes, select
from swarm_bench.sweep import run_all
from swarm_bench.table import run_line, summary_table
from swarm_common.errors import ConfigError

MISSED = 1
PIPE_WIDTH = 170  # columns of tables that nobody looks at on a terminal

bench_app = typer.Typer(add_completion=False, rich_markup_mode=None, no_args_is_help=True)


@bench_app.callback()
def bench() -> None:
    """Measure the swarm: many seeded runs, tables and JSON."""


@bench_app.command()
def traffic(
    scenario: Annotated[str, typer.Option(help="Names or files, comma-separated, or all.")] = "all",
    robots: Annotated[
        str | None,
        typer.Option(help="Swarm sizes like 20,50.  [default: the scenario's]", show_default=False),
    ] = None,
    seeds: Annotated[
        str, typer.Option(help=f"Seeds like 0-19 or 1,5,7; {SUITE}: as many as the scenario says.")
    ] = "0-2",
    loss: Annotated[float | None, typer.Option(help="Share of beacons that are lost.")] = None,
    delay: Annotated[float | None, typer.Option(help="[s] by which beacons are late.")] = None,
    engine: Annotated[
        str | None,
        typer.Option(help="planar or bullet.  [default: planar; bullet with --ros]"),
    ] = None,
    lidar: Annotated[
        bool | None,
        typer.Option(help="[default: the scenario's; with --ros always]", show_default=False),
    ] = None,
    method: Annotated[str, typer.Option(help="ours, dwa or orca.")] = "ours",
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", help="Parameter of the navigators: traffic.safety_margin=0.06"),
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes.")] = 1,
    ros: Annotated[bool, typer.Option("--ros", help="By swarm-up, on the real ROS graph.")] = False,
    json_: Annotated[
        Path | None,
        typer.Option("--json", help="File of JSON lines to add to; runs in it are not repeated."),
    ] = None,
) -> None:
    """Run the traffic suite; without --ros in one process per run, without the ROS graph.

    Exit code: 0 every goal reached without a collision; 1 otherwise; 2 bad input.
    """
    wanted = select(
        scenario,
        parse_sizes(robots),
        parse_seeds(seeds),
        method=method,
        engine=engine or ("bullet" if ros else "planar"),
        loss=loss,
        delay=delay,
        lidar=True if ros and lidar is None else lidar,
        settings=set_ or [],
    )
    check_jobs(jobs, ros=ros, method=method)
    console = _console()
    known = store.read_results(json_) if json_ is not None and json_.is_file() else []
    keys = {store.key_of_options(item, ros=ros) for item in wanted}
    results = [result for result in known if store.key_of(result) in keys]
    todo = store.missing(wanted, known, ros=ros)
    if results:
        console.print(f"{len(results)} of {len(wanted)} runs are in {json_} already")
    with contextlib.ExitStack() as stack:
        file = stack.enter_context(store.open_to_append(json_)) if json_ is not None else None
        for result in run_all(todo, jobs, run_on_graph) if ros else run_all(todo, jobs):
            results.append(result)
            console.print(run_line(result), highlight=False, soft_wrap=True, markup=False)
            if file is not None:
                store.append(file, result)
    console.print(summary_table(results))
    if not all(result.is_flawless for result in results):
        raise typer.Exit(MISSED)


@bench_app.command("report-traffic")
def report_traffic(
    files: Annotated[list[Path], typer.Argument(help="Files of `swarm-bench traffic --json`.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Markdown file to write.")],
    machine: Annotated[str, typer.Option(help="Where it was measured.  [default: here]")] = "",
) -> None:
    """Write the tables of a sweep, as in docs/traffic.md."""
    results: list[RunResult] = []
    for path in files:
        results += store.read_results(path)
    if not results:
        raise ConfigError(f"no results in {', '.join(map(str, files))}")
    try:
        output.write_text(traffic_report(results, machine or machine_line()), encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {output}: {cause}") from cause


def _console() -> Console:
    console = Console()
    return console if console.is_terminal else Console(width=PIPE_WIDTH)
