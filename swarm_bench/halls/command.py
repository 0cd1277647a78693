"""The command `swarm-bench halls`: its options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from swarm_bench.execution.executor import executor, share_of
from swarm_bench.halls.halls import DRAWN, hall_runs, load_hall_inputs, run_hall
from swarm_bench.halls.report import halls_markdown
from swarm_bench.runs.document import check_part, replace_part
from swarm_bench.runs.episode import parse_parameters
from swarm_bench.suite.command import (
    Cluster,
    Jobs,
    JsonLines,
    Settings,
    Shard,
    bench_app,
    keeping,
    run_and_exit,
)
from swarm_bench.suite.selection import check_jobs, parse_seeds, parse_sizes
from swarm_bench.suite.sweep import RunSweep
from swarm_run.record.run_record import RunRecord

EXAMPLES = """Example:

swarm-bench halls --seeds 0-19 --jobs 2 --json halls.jsonl
"""


@bench_app.command(epilog=EXAMPLES)
def halls(
    seeds: Annotated[str, typer.Option(help="Seeds like 0-199 or 1,5,7.")] = "0-199",
    robots: Annotated[
        str | None, typer.Option(help="Swarm sizes like 20,50.", show_default="by the seed")
    ] = None,
    mission: Annotated[
        str, typer.Option(help="random order, pipeline, roam, swap; drawn: by the seed.")
    ] = DRAWN,
    trouble: Annotated[
        str, typer.Option(help="none, dead, radio, people, mixed; drawn: by the seed.")
    ] = DRAWN,
    set_: Settings = None,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    shard: Shard = None,
    json_: JsonLines = None,
    output: Annotated[
        Path | None, keeping("-o", "--output", help="Document whose part `halls` to write.")
    ] = None,
) -> None:
    """Run random missions in random halls: each seed is a hall with doors, aisles and stations.

    Exit code: 0 every goal reached without a collision; 1 otherwise; 2 bad input.
    """
    options = hall_runs(
        parse_seeds(seeds) or range(200),
        parse_sizes(robots),
        mission,
        trouble,
        parameters=parse_parameters(set_ or []),
    )
    check_jobs(jobs, ros=False, method="ours")
    if output is not None:
        check_part(output, "halls")

    def write(results: list[RunRecord]) -> None:
        if output is not None:
            replace_part(output, "halls", halls_markdown(results))

    with executor(jobs, cluster) as chosen:
        runs = share_of(options, shard)
        sweep = RunSweep(runs, json_, chosen, runner=run_hall, load=load_hall_inputs)
        run_and_exit([sweep], write)
