"""The command `python -m benchmarks storm`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated

import msgspec
import typer

from benchmarks.app import benchmarks_app
from benchmarks.storm.storm import ROWS, StormOptions, StormResult, run_storm
from swarm_bench.execution.executor import executor, share_of
from swarm_bench.execution.store import Store
from swarm_bench.execution.sweep import Sweep
from swarm_bench.suite.command import MISSED, Cluster, Jobs, Shard, new_console
from swarm_bench.suite.selection import check_jobs, parse_seeds
from swarm_bench.tables import BenchTable, number
from swarm_common.model.errors import ConfigError, UnknownNameError

COMMAND = "python -m benchmarks storm"
Storms = list[StormResult]  # in one world
COLUMNS: dict[str, Callable[[Storms], str]] = {
    "world": lambda storms: storms[0].world,
    "robots": lambda storms: str(storms[0].robots),
    "storms": lambda storms: str(len(storms)),
    **{
        kind.replace("_", " "): partial(lambda kind, storms: str(_sum(storms, kind)), kind)
        for kind in ("killed", "for_good", "hung", "mute", "deaf")
    },
    "contacts moving": lambda storms: str(_sum(storms, "moving_contacts")),
    "standing": lambda storms: str(_sum(storms, "standing_contacts")),
    "goals": lambda storms: f"{_sum(storms, 'goals_reached')}/{_sum(storms, 'goals_sent')}",
    "barred": lambda storms: str(_sum(storms, "goals_barred")),
    "clearance [m]": lambda storms: number(
        min((s.min_clearance for s in storms if s.min_clearance is not None), default=None)
    ),
}


def _sum(storms: Storms, name: str) -> int:
    return sum(s.faults[name] if name in s.faults else getattr(s, name) for s in storms)


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
    console = new_console()
    with executor(jobs, cluster) as computes:
        sweep = Sweep(
            items=share_of(options, shard),
            runner=run_storm,
            store=Store(json_, partial(msgspec.convert, type=StormResult), COMMAND),
            key=lambda item: (item.world, item.seed),
            key_of=lambda result: (result.world, result.seed),
            line=storm_line,
            executor=computes,
        )
        results = sweep.run(console)
    console.print(storm_table(results).rich())
    if sweep.failed or not all(result.is_flawless for result in results):
        raise typer.Exit(MISSED)


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


def storm_table(results: list[StormResult]) -> BenchTable:
    """Return a table with a row per world; a row with a storm that is not flawless is red."""
    groups = [[result for result in results if result.world == world] for world in ROWS]
    return BenchTable.of(
        COLUMNS,
        filter(None, groups),
        style=lambda storms: "" if all(storm.is_flawless for storm in storms) else "red",
    )
