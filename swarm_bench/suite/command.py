"""The command `swarm-bench`: its options."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from swarm_bench.execution.executor import AUTO, executor, share_of
from swarm_bench.execution.sweep import bar
from swarm_bench.runs.document import check_part, replace_part
from swarm_bench.runs.origin import machine_line
from swarm_bench.runs.result import FailedRun
from swarm_bench.suite.report import traffic_report
from swarm_bench.suite.selection import (
    SUITE,
    check_jobs,
    parse_seeds,
    parse_sizes,
    select,
    suite_sweeps,
)
from swarm_bench.suite.sweep import RunSweep, read_results
from swarm_bench.suite.table import summary_table
from swarm_common.model.engines import usual_engine
from swarm_common.model.errors import ConfigError
from swarm_run.record.run_record import RunRecord

MISSED = 1
REFUSED = 2
PIPE_WIDTH = 170  # columns of tables that nobody looks at on a terminal

running = partial(typer.Option, rich_help_panel="Where it runs")
keeping = partial(typer.Option, rich_help_panel="What is kept")
world_as = partial(typer.Option, rich_help_panel="Conditions")

Jobs = Annotated[int, running(help="Number of processes.")]
JsonLines = Annotated[
    Path | None,
    keeping("--json", help="File of JSON lines to add to; runs in it are not repeated."),
]
Cluster = Annotated[
    str | None, running(help="Dask cluster: local, tcp://HOST:8786 or slurm:nodes=4.")
]
Shard = Annotated[
    str | None, running(help=f"Share of the runs, like 2/8; {AUTO}: of a Slurm array.")
]
Document = Annotated[
    Path, keeping("-o", "--output", help="Document whose part `suite` to write, or a new one.")
]
Settings = Annotated[
    list[str] | None,
    world_as("--set", help="Parameter of the navigators: traffic.safety_margin=0.06"),
]

TRAFFIC = """Examples:

swarm-bench traffic --scenario circle,corridor --robots 20 --jobs 2

swarm-bench traffic --scenario all --seeds 0-9 --json runs.jsonl

swarm-bench traffic --scenario station --method orca
"""
SUITES = """Example:

swarm-bench suite --json suite.jsonl --output docs/results.md --jobs 2
"""
REPORTS = """Example:

swarm-bench report-traffic runs.jsonl --output traffic.md
"""

bench_app = typer.Typer(rich_markup_mode="rich", no_args_is_help=True)


@bench_app.callback(epilog="Example: swarm-bench traffic --scenario circle --robots 20")
def bench() -> None:
    """Measure the swarm: many seeded runs, tables and JSON."""


@bench_app.command(epilog=TRAFFIC)
def traffic(
    scenario: Annotated[str, typer.Option(help="Names or files, comma-separated, or all.")] = "all",
    robots: Annotated[
        str | None, typer.Option(help="Swarm sizes like 20,50.", show_default="the scenario's")
    ] = None,
    seeds: Annotated[
        str, typer.Option(help=f"Seeds like 0-19 or 1,5,7; {SUITE}: as many as the scenario says.")
    ] = "0-2",
    loss: Annotated[float | None, world_as(help="Share of beacons that are lost.")] = None,
    delay: Annotated[float | None, world_as(help="Delay of beacons, in s.")] = None,
    engine: Annotated[
        str | None, world_as(help="planar or bullet.", show_default="planar; bullet with --ros")
    ] = None,
    lidar: Annotated[
        bool | None,
        world_as(help="With LiDARs or without.", show_default="the scenario's; with --ros always"),
    ] = None,
    realistic: Annotated[
        bool,
        world_as(
            "--realistic/--ideal", help="Noisy sensors with LiDARs, and localisation by AMCL."
        ),
    ] = False,
    params: Annotated[Path | None, world_as(help="Parameter file of the navigators.")] = None,
    method: Annotated[
        str,
        typer.Option(help="ours, dwa, orca, central-mapf, central-reservation, or module:Class."),
    ] = "ours",
    central_solver: Annotated[
        str, typer.Option(help="Program that plans for central-mapf by Moving AI files.")
    ] = "",
    set_: Settings = None,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    shard: Shard = None,
    ros: Annotated[bool, running("--ros", help="Run swarm-up on the real ROS graph.")] = False,
    json_: JsonLines = None,
) -> None:
    """Run scenarios; without --ros each run is one process without the ROS graph.

    Exit code: 0 every goal reached without a collision; 1 otherwise; 2 bad input or a refused run.
    """
    options = select(
        scenario,
        parse_sizes(robots),
        parse_seeds(seeds),
        method=method,
        engine=engine or (usual_engine() if ros else "planar"),
        loss=loss,
        delay=delay,
        lidar=True if (ros or realistic) and lidar is None else lidar,
        realistic=realistic,
        settings=set_ or [],
        params=params,
        central_solver=central_solver,
    )
    check_jobs(jobs, ros=ros, method=method, cluster=cluster)
    with executor(jobs, cluster) as chosen:
        run_and_exit([RunSweep(share_of(options, shard), json_, chosen, ros=ros)])


@bench_app.command(epilog=SUITES)
def suite(
    json_: Annotated[
        Path, keeping("--json", help="File of JSON lines; runs in it are not repeated.")
    ],
    output: Document,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    seeds: Annotated[
        str, typer.Option(help=f"Of the bench runs; {SUITE}: as many as each scenario says.")
    ] = SUITE,
    baseline_seeds: Annotated[str, typer.Option(help="Seeds of dwa and orca, or none.")] = "0-2",
    ros_seeds: Annotated[str, typer.Option(help="Seeds on the ROS graph, or none.")] = "0-2",
    ros_most: Annotated[int, typer.Option(help="Largest swarm on the ROS graph.")] = 50,
) -> None:
    """Run the whole suite, the baselines and the ROS rows, and write the document.

    Exit code: as of `traffic`, where the baselines' misses do not count.
    """
    check_jobs(jobs, ros=False, method="ours")
    if output.exists():
        check_part(output, "suite")
    with executor(jobs, cluster) as chosen:
        sweeps = suite_sweeps(seeds, baseline_seeds, ros_seeds, ros_most, json_, chosen)
        run_and_exit(sweeps, lambda found: _write_report(found, output, machine_line()))


@bench_app.command("report-traffic", epilog=REPORTS)
def report_traffic(
    files: Annotated[list[Path], typer.Argument(help="Files of `swarm-bench traffic --json`.")],
    output: Document,
    machine: Annotated[
        str, typer.Option(help="Machine of the measurement.", show_default="this one")
    ] = "",
) -> None:
    """Write the tables of runs that were made before."""
    results = read_results(*files)
    if not results:
        raise ConfigError(f"no results in {', '.join(map(str, files))}")
    _write_report(results, output, machine or machine_line())


def _write_report(results: Sequence[RunRecord], output: Path, machine: str) -> None:
    """Write the part `suite` of a document, or a document of nothing else if there is none yet."""
    text = traffic_report(results, machine, shlex.join(["swarm-bench", *sys.argv[1:]]))
    try:
        if not output.exists():
            output.write_text("# Traffic, measured\n\n<!-- suite -->\n<!-- /suite -->\n", "utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {output}: {cause}") from cause
    replace_part(output, "suite", text)


def run_and_exit(
    sweeps: Sequence[RunSweep], write: Callable[[list[RunRecord]], None] = lambda _: None
) -> None:
    """Check and run sweeps, print the table, and exit with `MISSED` unless all runs are flawless.

    If a run was refused, the exit code is `REFUSED`.

    Runs of other methods than ours count as flawless where several sweeps are run. An interrupt
    ends it with the table of what is done.

    Args:
        write: Writes what else is made of the results.

    Raises:
        typer.Exit: With `MISSED` or `REFUSED`.
    """
    for sweep in sweeps:
        sweep.check()
    console, results, failed = new_console(), list[RunRecord](), list[FailedRun]()
    total = sum(len(sweep.items) for sweep in sweeps)
    for sweep in sweeps:
        sweep.results, sweep.failed = results, failed  # of all
    try:
        with bar(console, "runs", total) as tell:
            for sweep in sweeps:
                sweep.run(console, watch=lambda *_: tell(len(results) + len(failed), total) is None)
    finally:
        if results:
            console.print(summary_table(results).rich())
    write(results)
    if len(sweeps) > 1:
        results = [result for result in results if result.method == "ours"]
        failed = [failure for failure in failed if failure.method == "ours"]
    end_unless_flawless(failed, results)


def end_unless_flawless(failed: Sequence[FailedRun], results: Sequence[RunRecord]) -> None:
    """Exit with what became of runs.

    Raises:
        typer.Exit: With `REFUSED` if one was refused, or with `MISSED` if one failed or is not
            flawless.
    """
    if any(failure.refused for failure in failed):
        raise typer.Exit(REFUSED)
    if failed or not all(result.is_flawless for result in results):
        raise typer.Exit(MISSED)


def new_console() -> Console:
    """Return a console that is wide enough for the tables, also for a pipe."""
    console = Console()
    return console if console.is_terminal else Console(width=PIPE_WIDTH)
