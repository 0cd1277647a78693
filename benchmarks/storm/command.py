"""The command `python -m benchmarks storm`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec
import typer
from rich.table import Table

from benchmarks.app import benchmarks_app
from benchmarks.storm.storm import ROWS, StormOptions, StormResult, run_storm
from swarm_bench.execution.executor import executor, share_of, values
from swarm_bench.execution.task import Executor
from swarm_bench.runs.json_lines import collected, read_json_lines, taken_over
from swarm_bench.suite.command import MISSED, Cluster, Jobs, Shard, new_console
from swarm_bench.suite.selection import check_jobs, parse_seeds
from swarm_common.model.errors import ConfigError, UnknownNameError

KINDS = ("killed", "for_good", "hung", "mute", "deaf")
COLUMNS = (
    "world", "robots", "storms", "killed", "for good", "hung", "mute", "deaf",
    "contacts moving", "standing", "goals", "barred", "clearance [m]",
)  # fmt: skip


@benchmarks_app.command()
def storm(
    seeds: Annotated[str, typer.Option(help="Seeds like 0-199 or 1,5,7.")] = "0-3",
    world: Annotated[
        str, typer.Option(help=f"{', '.join(ROWS)}, or all: the seeds take them in turn.")
    ] = "all",
    jobs: Jobs = 1,
    cluster: Cluster = None,
    shard: Shard = None,
    json_: Annotated[
        Path | None,
        typer.Option("--json", help="File of JSON lines to add to; storms in it are not repeated."),
    ] = None,
) -> None:
    """Let navigators die, hang, go mute and deaf, and come back, among crates and people.

    Exit code: 0 no living robot ran into anything, and the robots that live at the end reached all
    goals with a way to them; 1 otherwise; 2 bad input.
    """
    if world != "all" and world not in ROWS:
        raise UnknownNameError("world", world, (*ROWS, "all"))
    chosen = parse_seeds(seeds)
    if chosen is None:
        raise ConfigError(f"--seeds is '{seeds}'; expected seeds like 0-199")
    check_jobs(jobs, ros=False, method="ours")
    worlds = list(ROWS) if world == "all" else [world]
    options = [StormOptions(worlds[seed % len(worlds)], seed) for seed in chosen]
    with executor(jobs, cluster) as computes:
        results = _run(share_of(options, shard), computes, json_)
    if not all(result.is_flawless for result in results):
        raise typer.Exit(MISSED)


def _run(options: list[StormOptions], chosen: Executor, file: Path | None) -> list[StormResult]:
    console = new_console()
    known: list[StormResult] = []
    if file is not None and file.is_file():
        known = read_json_lines(
            file, lambda data: msgspec.convert(data, StormResult), "python -m benchmarks storm"
        )
    wanted = {(item.world, item.seed) for item in options}
    results = [result for result in known if (result.world, result.seed) in wanted]
    done = {(result.world, result.seed) for result in results}
    todo = [item for item in options if (item.world, item.seed) not in done]
    if results:
        console.print(taken_over(len(results), len(options), file), soft_wrap=True, markup=False)
    new = values(chosen, run_storm, todo)
    results += collected(new, file, console, storm_line, StormResult.as_json)
    console.print(storm_table(results))
    return results


def storm_line(result: StormResult) -> str:
    """Return one line about one storm."""
    faults = ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in result.faults.items())
    text = (
        f"{result.world} seed {result.seed}: {faults}, {result.crates} crates, "
        f"{result.people} people; contacts {result.moving_contacts} moving, "
        f"{result.standing_contacts} standing; goals {result.goals_reached}/{result.goals_sent}, "
        f"{result.goals_barred} barred; {result.sim_time:.0f} s, {result.wall_time:.0f} s wall"
    )
    return "; ".join([text, *[note for note in (result.first_contact, result.first_miss) if note]])


def storm_table(results: list[StormResult]) -> Table:
    """Return a table with a row per world; a row with a storm that is not flawless is red."""
    table = Table(box=None, header_style="bold")
    for column in COLUMNS:
        table.add_column(column, justify="left" if column == "world" else "right")
    for world in ROWS:
        rows = [result for result in results if result.world == world]
        if not rows:
            continue
        kinds = [sum(row.faults[kind] for row in rows) for kind in KINDS]
        contacts = [sum(row.moving_contacts for row in rows)]
        contacts += [sum(row.standing_contacts for row in rows)]
        clearances = [row.min_clearance for row in rows if row.min_clearance is not None]
        table.add_row(
            world, str(rows[0].robots), *map(str, (len(rows), *kinds, *contacts)),
            f"{sum(row.goals_reached for row in rows)}/{sum(row.goals_sent for row in rows)}",
            str(sum(row.goals_barred for row in rows)),
            f"{min(clearances):.3f}" if clearances else "-",
            style="" if all(row.is_flawless for row in rows) else "red",
        )  # fmt: skip
    return table
