"""The command `python -m benchmarks scale`: its options, and comparisons."""

from __future__ import annotations

import contextlib
import dataclasses
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from benchmarks.app import benchmarks_app
from benchmarks.scale.plan import AUTO, GRAPH, HARNESS, WORKLOADS, ScaleJob, plan_jobs
from benchmarks.scale.result import (
    FEW,
    FIGURES,
    MANY,
    NOISY,
    ScaleResult,
    ScaleRow,
    growth,
    rows_of,
    scale_table,
)
from benchmarks.scale.runs import REPOSITORY, store_of, sweep_of
from swarm_bench.suite.command import MISSED, JsonLines, new_console
from swarm_bench.suite.selection import parse_sizes
from swarm_bench.tables import BenchTable, number
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

    Exit code: 0; 1 if robots collided or a run failed; 2 bad input.
    """
    system = HARNESS if harness else GRAPH
    if harness and goals_per_robot:
        raise ConfigError("--harness runs for --seconds; leave out --goals-per-robot")
    jobs = plan_jobs(
        system,
        parse_sizes(robots),
        repeats,
        workload=workload,
        seconds=seconds,
        goals=goals_per_robot,
        pack=pack,
        engine=engine,
    )
    console = new_console()
    if compared is not None:
        if json_ is not None:
            raise ConfigError("--compare prints a table; leave out --json")
        sides = compare(compared, jobs, console)
        console.print(comparison_table(compared, sides).rich())
        return
    sweep = sweep_of(jobs, json_)
    results = sweep.run(console)
    rows = rows_of(results)
    names = [name for name, figure in FIGURES.items() if figure.only in ("", system)]
    console.print(scale_table(rows, names).rich())
    for line in _remarks(rows):
        console.print(line)
    if sweep.failed or any(result.collisions for result in results):
        raise typer.Exit(MISSED)


def _remarks(rows: Sequence[ScaleRow]) -> list[str]:
    """Return what is to be said beside the figures."""
    remarks = []
    factor = growth([row for row in rows if row.label == rows[0].label])
    if factor is not None:
        remarks.append(
            f"From {FEW} to {MANY} robots a robot-second grows {factor:.2f} times as costly."
        )
    noisy = sorted({row.first.robots for row in rows if row.is_noisy})
    if noisy:
        remarks.append(
            f"Measured beside other work (more than {100 * NOISY:.0f} % of the processors): "
            f"{', '.join(map(str, noisy))} robots. Real-time factors and start-up are too low "
            "there."
        )
    return remarks


def compare(
    names: tuple[str, str], jobs: Sequence[ScaleJob], console: Console
) -> list[list[ScaleResult]]:
    """Return the results of two files, or of two commits that are run now, in turn."""
    if all(Path(name).is_file() for name in names):
        return [[result for _, result in store_of(Path(name)).read()] for name in names]
    with contextlib.ExitStack() as stack:
        folders = [stack.enter_context(_worktree(name)) for name in names]
        # in turn, so that both meet the same disturbances
        runs = [dataclasses.replace(job, code=folder) for job in jobs for folder in folders]
        sides: list[list[ScaleResult]] = [[], []]

        def watch(index: int, outcome: ScaleResult | str) -> bool:
            if not isinstance(outcome, str):
                sides[index % 2].append(outcome)
            return True

        sweep_of(runs).run(console, watch=watch)
    return sides


def comparison_table(names: tuple[str, str], sides: Sequence[Sequence[ScaleResult]]) -> BenchTable:
    """Return each figure of both sides and their ratio, second to first, of runs both have."""
    cells = []
    others = {row.first.kind: row for row in rows_of(sides[1])}
    for row in rows_of(sides[0]):
        other = others.get(row.first.kind)
        if other is None:
            continue
        for name, figure in FIGURES.items():
            before, after = row.median(figure.of), other.median(figure.of)
            if before is None or after is None:
                continue
            ratio = after / before if before else None
            figures = (number(value, 2) for value in (before, after, ratio))
            cells.append([row.first.system, row.label, str(row.first.robots), name, *figures])
    head = ["system", "workload", "robots", "figure", *names, "ratio"]
    return BenchTable(head, cells, texts=head[:2])


@contextlib.contextmanager
def _worktree(commit: str) -> Iterator[Path]:
    """Yield a folder with the code of a commit."""
    with tempfile.TemporaryDirectory(prefix="swarm-commit-") as name:
        folder = Path(name) / "code"
        git = ("git", "-C", str(REPOSITORY), "worktree")
        made = subprocess.run(
            (*git, "add", "--detach", str(folder), commit), capture_output=True, text=True
        )
        if made.returncode:
            raise ConfigError(
                f"--compare: '{commit}' is neither a file nor a commit of this repository: "
                f"{made.stderr.strip()}"
            )
        try:
            yield folder
        finally:
            subprocess.run((*git, "remove", "--force", str(folder)), capture_output=True)
