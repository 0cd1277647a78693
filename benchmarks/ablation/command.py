"""The command `python -m benchmarks ablate`: its options."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.markup import escape

from benchmarks.ablation.rules import (
    BASE,
    ablation_markdown,
    jobs_of,
    key_of,
    missing,
    run_job,
    variants,
)
from benchmarks.app import benchmarks_app
from swarm_bench.execution.executor import executor, values
from swarm_bench.halls.halls import DRAWN, NONE, hall_runs
from swarm_bench.runs.json_lines import collected, read_json_lines, taken_over
from swarm_bench.runs.result import RunResult, result_from_json
from swarm_bench.suite.command import Cluster, Jobs, JsonLines, new_console
from swarm_bench.suite.selection import check_jobs, parse_seeds, parse_sizes, select
from swarm_bench.suite.table import run_line
from swarm_common.model.errors import ConfigError

NO_ROWS = "none"


@benchmarks_app.command()
def ablate(
    only: Annotated[
        str, typer.Option(help="Rules and numbers, comma-separated.  [default: all]")
    ] = "",
    scenario: Annotated[
        str, typer.Option(help="Rows of the suite, comma-separated, or none.")
    ] = "station,corridor,doorway,crossing,slim_blockage",
    seeds: Annotated[str, typer.Option(help="Of the rows, like 0-9.")] = "0-9",
    halls: Annotated[str, typer.Option(help="Seeds of random halls, or none.")] = "0-9",
    robots: Annotated[str, typer.Option(help="Swarm sizes of the halls.")] = "20",
    trouble: Annotated[
        str, typer.Option(help="Of the halls: none, dead, radio, people, mixed, or drawn.")
    ] = NONE,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    json_: JsonLines = None,
) -> None:
    """Measure what each liveness rule pays: off, and each number halved and doubled.

    A row of the suite in which a change leaves three seeds as they are is not run further.
    """
    check_jobs(jobs, ros=False, method="ours")
    chosen = variants([name.strip() for name in only.split(",") if name.strip()])
    rows = [] if scenario == NO_ROWS else select(scenario, (), parse_seeds(seeds))
    rows = [row for row in rows if row.robots == row.scenario.robots[0]]  # the smallest swarm
    hall_seeds = [] if halls == NO_ROWS else parse_seeds(halls) or range(10)
    in_halls = hall_runs(hall_seeds, parse_sizes(robots), DRAWN, trouble)
    if not rows and not in_halls:
        raise ConfigError("nothing to run: --scenario and --halls are both none")
    console = new_console()
    results: list[tuple[str, RunResult]] = []
    if json_ is not None and json_.is_file():
        results = read_json_lines(json_, _parse, "python -m benchmarks ablate")
    wanted = jobs_of(chosen, rows, in_halls)
    if results:
        known = {key_of(*found) for found in results}
        count = sum(job.key in known for job in wanted)
        console.print(taken_over(count, len(wanted), json_), soft_wrap=True, markup=False)
    with executor(jobs, cluster) as computes:
        while todo := missing(wanted, results):
            results += collected(
                values(computes, run_job, todo),
                json_,
                console,
                lambda found: f"{found[0]}: {run_line(found[1])}",
                lambda found: {"variant": found[0], **found[1].as_json()},
            )
    names = {variant.name for variant in chosen}
    table = ablation_markdown([item for item in results if item[0] in names | {BASE}])
    console.print(escape(table))


def _parse(data: dict[str, Any]) -> tuple[str, RunResult]:
    return data.pop("variant"), result_from_json(data)
