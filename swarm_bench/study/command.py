"""`swarm-bench study`: its options."""

from __future__ import annotations

import itertools
import math
import operator
import os
import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from swarm_bench.execution.executor import AUTO, executor, share_of
from swarm_bench.execution.store import Store
from swarm_bench.execution.sweep import Sweep, bar, taken_over
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.fingerprint import gathered, load_inputs
from swarm_bench.runs.inputs import Pack, packed
from swarm_bench.runs.origin import bench_edition
from swarm_bench.study.experiments import (
    Experiment,
    StudyRun,
    load_experiments,
    runs_of,
    study_folder,
)
from swarm_bench.study.lines import StudyLine, store_of
from swarm_bench.study.page import markdown, page
from swarm_bench.study.runner import line_text, run_one
from swarm_bench.study.tuning import choose, load_chosen, load_tuning, tuning_runs, write_chosen
from swarm_bench.suite.command import Cluster, Jobs, Shard, bench_app, keeping, new_console
from swarm_bench.suite.selection import check_jobs, parse_time
from swarm_common.model.errors import ConfigError

DIFFERS = FAILED = 1
CORES = 2  # of the machine that estimates are for
Rates = Mapping[tuple[str, bool], float]
KEY = operator.attrgetter("key")  # of a line
TUNING = "tuning"  # name of the edition of tuning's lines
EXAMPLES = """Example:

swarm-bench study --quick --output study.md
"""


@bench_app.command(epilog=EXAMPLES)
def study(
    quick: Annotated[bool, typer.Option("--quick", help="The short edition: 2 seeds.")] = False,
    tune: Annotated[bool, typer.Option("--tune", help="Choose the methods' parameters.")] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Run nothing; compare the documents with the lines.")
    ] = False,
    estimate: Annotated[
        bool, typer.Option("--estimate", help="Run nothing; print the time needed.")
    ] = False,
    experiments: Annotated[
        Path | None, typer.Option(help="Folder of experiments.", show_default="params/study")
    ] = None,
    folder: Annotated[Path, typer.Option(help="Folder of raw lines and study.html.")] = Path(
        "study"
    ),
    output: Annotated[Path, keeping("-o", "--output", help="Document to write.")] = Path(
        "docs/study.md"
    ),
    most: Annotated[
        int | None, typer.Option(help="Runs to add; another call goes on.", show_default="all")
    ] = None,
    budget: Annotated[str | None, typer.Option(help="Time to end in, like 60min.")] = None,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    shard: Shard = None,
) -> None:
    """Compare decentralised with central control; what was run before is not repeated.

    With --shard only lines are written; a call without it joins them.

    Exit code: 0 written, or as written; 1 if a run failed or, with --check, a document differs;
    2 bad input.
    """
    check_jobs(jobs, ros=False, method="ours", cluster=cluster)
    limit = parse_time(budget)
    if tune and (check or quick):
        raise ConfigError(
            "--tune has no short edition and no documents; leave out --quick and --check"
        )
    place = experiments or study_folder()
    found, settings = load_experiments(place), load_chosen(place)
    edition = TUNING if tune else "quick" if quick else "full"
    task = os.environ.get("SLURM_ARRAY_TASK_ID", "") if shard == AUTO else shard or ""
    store = store_of(folder, edition, task)
    lines = list(store.by_key(KEY).values())
    rates = rates_of(found, lines)
    if estimate:
        _print_estimates(found, tuning_runs(load_tuning(place)), rates)
        return
    console, errors = new_console(), list[str]()
    if not check:
        runs = (
            tuning_runs(load_tuning(place))
            if tune
            else runs_of(found, quick=quick, settings=settings)
        )
        mine, known = share_of(runs, shard), {line.key for line in lines}
        todo = [run for run in mine if run.key not in known]
        if len(todo) < len(mine):
            console.print(taken_over(len(mine) - len(todo), len(mine), folder), markup=False)
        if old := sum(line.edition != bench_edition() for line in lines):
            told = f"{old} of the lines are by other code; delete the files of {edition} to repeat"
            console.print(told, markup=False)
        todo = fitting(todo, rates, math.inf if limit is None else limit * jobs)[:most]
        told = f"{len(todo)} runs to do: about {_time(todo, rates, jobs)} with --jobs {jobs}"
        console.print(told, markup=False)
        folder.mkdir(parents=True, exist_ok=True)
        sweep = _sweep(todo, store, cluster)
        with (
            executor(jobs, cluster, apart=True) as sweep.executor,
            bar(console, "runs", len(todo)) as tell,
        ):
            count = itertools.count(1)
            sweep.run(
                console,
                watch=lambda *_: tell(next(count), len(todo)) is None,
                seconds=math.inf if limit is None else limit,
            )
        lines, errors = lines + sweep.results, sweep.failed
        if shard:
            raise typer.Exit(FAILED if errors else 0)
        if lines:
            store.pack(KEY)
    if not lines:
        raise ConfigError(f"{folder} has no results; run swarm-bench study first")
    if tune:
        chosen = choose(load_tuning(place), lines)
        console.print(f"wrote {write_chosen(place, chosen)}", markup=False)
    else:
        command = "swarm-bench study --quick" if quick else "swarm-bench study"
        texts = {
            output: markdown(found, lines, quick=quick, command=command, settings=settings),
            folder / "study.html": page(found, lines, quick=quick, settings=settings),
        }
        _put(texts, check=check)
    if errors:
        raise typer.Exit(FAILED)


def _sweep(
    runs: Sequence[StudyRun], store: Store[StudyLine], cluster: str | None
) -> Sweep[tuple[StudyRun, RunOptions], StudyLine]:
    def pack(items: Sequence[tuple[StudyRun, RunOptions]]) -> Pack | None:
        """Return the inputs; processes of this machine read them themselves."""
        if cluster is None:
            return None
        return packed(gathered(options, load_inputs)[1] for _, options in items)

    return Sweep(
        items=[(run, run.options()) for run in runs],
        runner=run_one,
        store=store,
        key=lambda item: item[0].key,
        key_of=KEY,
        line=line_text,
        name=lambda item: "{}: {}, {}, seed {}".format(*item[0].key),
        pack=pack,
    )


def rates_of(experiments: Mapping[str, Experiment], lines: Sequence[StudyLine]) -> Rates:
    """Return the measured CPU [ms] of a robot-second by method and LiDARs."""
    lidar = {
        (name, cell.name): cell.lidar
        for name, experiment in experiments.items()
        for cell in experiment.cells
    }
    found: dict[tuple[str, bool], list[float]] = {}
    for line in lines:
        key = line.method, lidar.get((line.experiment, line.cell), False)
        found.setdefault(key, []).append(line.cpu_ms_per_robot_second)
    return {key: statistics.median(values) for key, values in found.items()}


def fitting(runs: Sequence[StudyRun], rates: Rates, seconds: float) -> list[StudyRun]:
    """Return the first runs that fit into a time."""
    chosen: list[StudyRun] = []
    for run in runs:
        seconds -= run.cost(rates)
        if chosen and seconds < 0.0:
            break
        chosen.append(run)
    return chosen


def _print_estimates(
    experiments: Mapping[str, Experiment], tuning: Sequence[StudyRun], rates: Rates
) -> None:
    editions = {
        "full": runs_of(experiments, quick=False),
        "--quick": runs_of(experiments, quick=True),
        "--tune": tuning,
    }
    for title, runs in editions.items():
        typer.echo(f"{title}: {len(runs)} runs, {_time(runs, rates, CORES)} on {CORES} cores")


def _time(runs: Sequence[StudyRun], rates: Rates, processes: int) -> str:
    minutes = sum(run.cost(rates) for run in runs) / processes / 60.0
    return f"{minutes / 60.0:.1f} h" if minutes >= 100.0 else f"{minutes:.0f} min"


def _put(texts: Mapping[Path, str], *, check: bool) -> None:
    """Write files, or exit with `DIFFERS` if one is not what the lines say."""
    for path, text in texts.items():
        if not check:
            try:
                path.write_text(text, encoding="utf-8")
            except OSError as cause:
                raise ConfigError(f"cannot write {path}: {cause}") from cause
        elif not path.is_file() or path.read_text(encoding="utf-8") != text:
            typer.echo(f"{path} differs from the lines; write it with swarm-bench study", err=True)
            raise typer.Exit(DIFFERS)
