"""The command `python -m benchmarks scale`: its options, and what it writes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer

from benchmarks.app import benchmarks_app
from benchmarks.scale.compare import compare, comparison_table
from benchmarks.scale.plan import AUTO, GRAPH, HARNESS, WORKLOADS, plan_jobs
from benchmarks.scale.row import NOISY, ScaleRow, columns_of, growth, rows_of, scale_table
from benchmarks.scale.sweep import run_scale
from swarm_bench.suite.command import MISSED, JsonLines, new_console
from swarm_bench.suite.selection import parse_sizes
from swarm_common.model.errors import ConfigError

SIZES = "1,5,20,50,100,200"


@benchmarks_app.command()
def scale(
    robots: Annotated[str, typer.Option(help="Swarm sizes.")] = SIZES,
    harness: Annotated[
        bool, typer.Option("--harness", help="One process, without the ROS graph.")
    ] = False,
    repeats: Annotated[int, typer.Option(help="Runs of each size; tables have medians.")] = 3,
    workload: Annotated[
        str,
        typer.Option(
            help=f"{', '.join(WORKLOADS)}, or {AUTO}: the hall, the warehouse beyond 100 robots."
        ),
    ] = AUTO,
    seconds: Annotated[float, typer.Option(help="Simulated seconds of a run, at most.")] = 120.0,
    goals_per_robot: Annotated[
        int,
        typer.Option(help="End when every robot has reached this many; 0: end after --seconds."),
    ] = 0,
    pack: Annotated[
        int | None,
        typer.Option(
            help="Navigators per process.  [default: 1; 10 beyond 100 robots]", show_default=False
        ),
    ] = None,
    engine: Annotated[
        str | None,
        typer.Option(
            help="bullet or planar.  [default: bullet; planar with --harness]", show_default=False
        ),
    ] = None,
    json_: JsonLines = None,
    compared: Annotated[
        tuple[str, str] | None,
        typer.Option("--compare", help="Two files of --json, or two commits to run in turn."),
    ] = None,
) -> None:
    """Measure what a swarm costs, and how that grows with its size.

    Exit code: 0; 1 if robots collided; 2 bad input.
    """
    system = HARNESS if harness else GRAPH
    if harness and goals_per_robot:
        raise ConfigError("--harness runs for --seconds; leave out --goals-per-robot")
    jobs = plan_jobs(
        system, parse_sizes(robots), repeats, workload=workload, seconds=seconds,
        goals=goals_per_robot, pack=pack, engine=engine,
    )  # fmt: skip
    console = new_console()
    if compared is not None:
        if json_ is not None:
            raise ConfigError("--compare prints a table; leave out --json")
        console.print(comparison_table(*compare(compared, jobs, console)))
        return
    results = run_scale(jobs, json_, console)
    rows = rows_of(results)
    console.print(scale_table(rows, columns_of(rows)))
    for line in _remarks(rows):
        console.print(line)
    if any(result.collisions for result in results):
        raise typer.Exit(MISSED)


def _remarks(rows: Sequence[ScaleRow]) -> list[str]:
    """Return what is to be said beside the figures."""
    remarks = []
    factor = growth([row for row in rows if row.label == rows[0].label])
    if factor is not None:
        remarks.append(f"From 20 to 100 robots a robot-second grows {factor:.2f} times as costly.")
    noisy = sorted({row.first.robots for row in rows if row.is_noisy})
    if noisy:
        remarks.append(
            f"Measured beside other work (more than {100 * NOISY:.0f} % of the processors): "
            f"{', '.join(map(str, noisy))} robots. Real-time factors and start-up are too low "
            "there."
        )
    return remarks
