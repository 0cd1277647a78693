"""The command `python -m benchmarks decisions`: its options."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.markup import escape

from benchmarks.app import Output, Robots, benchmarks_app
from benchmarks.decisions import decision_markdown, measure_decisions
from swarm_bench.runs.document import replace_part
from swarm_bench.runs.scenario import check_size
from swarm_bench.suite.command import new_console
from swarm_bench.suite.machine import machine_line
from swarm_bench.suite.selection import select
from swarm_common.model.errors import ConfigError


@benchmarks_app.command()
def decisions(
    scenario: Annotated[str, typer.Option(help="Name or file.")] = "slim_blockage",
    robots: Robots = 50,
    ticks: Annotated[int, typer.Option(help="Number of ticks to measure.")] = 300,
    seed: Annotated[int, typer.Option(help="Seed of all random numbers.")] = 0,
    lidar: Annotated[bool, typer.Option(help="With scans and costmaps.")] = False,
    output: Output = None,
) -> None:
    """Measure one robot's decision in CPU time, by the number of neighbours that it hears."""
    if ticks < 1:
        raise ConfigError(f"--ticks is {ticks}; expected 1 or more")
    options = select(scenario, [check_size(robots, "--robots")], [seed], lidar=lidar)
    table = decision_markdown(measure_decisions(options[0], ticks))
    new_console().print(escape(table))
    if output is not None:
        replace_part(output, "decisions", f"Machine: {machine_line()}.\n\n{table}")
