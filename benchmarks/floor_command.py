"""The commands `python -m benchmarks floor` and `python -m benchmarks profile`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from benchmarks.app import Output, Robots, benchmarks_app
from benchmarks.floor import floor_markdown, measure_floor
from benchmarks.profile_parts import profile_harness, profile_markdown
from benchmarks.scale.plan import GRAPH
from benchmarks.scale.result import read_scale_results
from benchmarks.scale.row import rows_of
from swarm_bench.runs.document import replace_part
from swarm_bench.runs.scenario import check_size
from swarm_bench.suite.command import new_console
from swarm_bench.suite.machine import machine_line
from swarm_common.model.engines import usual_engine


@benchmarks_app.command()
def floor(
    robots: Robots = 20,
    measured: Annotated[
        Path | None, typer.Option(help="File of `scale --json`, to compare with.")
    ] = None,
    output: Output = None,
) -> None:
    """Measure what messages, physics and rays cost, and what a robot-second costs at least."""
    check_size(robots, "--robots")
    results = read_scale_results(measured) if measured is not None else []
    rows = rows_of([result for result in results if result.system == GRAPH])
    _show(floor_markdown(measure_floor(robots), rows), "floor", output)


@benchmarks_app.command()
def profile(
    robots: Robots = 20,
    engine: Annotated[
        str | None,
        typer.Option(
            help="bullet or planar.  [default: bullet; planar without PyBullet]",
            show_default=False,
        ),
    ] = None,
    output: Output = None,
) -> None:
    """Profile world and navigators without the ROS graph, summed up by module."""
    check_size(robots, "--robots")
    _show(
        profile_markdown(profile_harness(robots, engine or usual_engine()), robots),
        "profile",
        output,
    )


def _show(table: str, part: str, output: Path | None) -> None:
    new_console().print(escape(table))
    if output is not None:
        replace_part(output, part, f"Machine: {machine_line()}.\n\n{table}")
