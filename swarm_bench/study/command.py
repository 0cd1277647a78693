"""`swarm-bench study`: its options."""

from __future__ import annotations

import itertools
import math
import operator
import os
import random
import re
import statistics
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from swarm_bench.execution.executor import AUTO, executor, share_of
from swarm_bench.execution.store import Store
from swarm_bench.execution.sweep import Sweep, bar
from swarm_bench.runs.document import with_part
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.fingerprint import gathered, load_inputs
from swarm_bench.runs.inputs import Pack, packed
from swarm_bench.study import page
from swarm_bench.study.experiments import (
    BUDGET,
    Experiments,
    load_experiments,
    quick_runs,
    study_folder,
)
from swarm_bench.study.trials.cell import Rates, Settings, StudyRun
from swarm_bench.study.trials.line import StudyLine, store_of, study_edition
from swarm_bench.study.trials.trial import line_text, run_one
from swarm_bench.study.tuning import choose, load_chosen, load_tuning, tuning_runs, write_chosen
from swarm_bench.study.verdicts import due_runs, fitting_lines
from swarm_bench.suite.command import Cluster, Jobs, Shard, bench_app, keeping, new_console
from swarm_bench.suite.selection import check_jobs, parse_time
from swarm_common.model.errors import ConfigError

DIFFERS = FAILED = 1
KEY = operator.attrgetter("key")  # of a line
TUNING, QUICK, FULL = "tuning", "quick", "full"  # stores of lines
PROTOCOL, CELLS = "protocol.md", "cells"  # document beside the lines, and its part that is written
README, ANSWER = "README.md", "study"  # beside the folder of lines; it may have such a part
DRAWN_BY = re.compile(r"Matplotlib v([\w.]+)")
EXAMPLES = """Examples:

swarm-bench study --quick --folder short --output short.md

nice -n 19 swarm-bench study --jobs 2 --budget 60min
"""


@bench_app.command(epilog=EXAMPLES)
def study(
    quick: Annotated[
        bool, typer.Option("--quick", help="A short edition, on other seeds than the study's.")
    ] = False,
    tune: Annotated[bool, typer.Option("--tune", help="Choose the methods' parameters.")] = False,
    check: Annotated[
        bool,
        typer.Option("--check", help="Run nothing; compare pages and figures with the lines."),
    ] = False,
    reproduce: Annotated[
        int | None,
        typer.Option(help="Run that many lines, drawn at random, again, and compare.", min=1),
    ] = None,
    estimate: Annotated[
        bool, typer.Option("--estimate", help="Run nothing; print the CPU time needed.")
    ] = False,
    experiments: Annotated[
        Path | None, typer.Option(help="Folder of experiments.", show_default="params/study")
    ] = None,
    folder: Annotated[
        Path, typer.Option(help="Folder of raw lines, protocol.md and study.html.")
    ] = Path("study"),
    output: Annotated[
        Path, keeping("-o", "--output", help="Document to write; figures lie beside it.")
    ] = Path("docs/study.md"),
    most: Annotated[
        int | None, typer.Option(help="Runs to add; another call goes on.", show_default="all")
    ] = None,
    budget: Annotated[str | None, typer.Option(help="Time to end in, like 60min.")] = None,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    shard: Shard = None,
) -> None:
    """Compare decentralised with central control; what was run before is not repeated.

    Comparisons get more seeds until they are decided. With --shard only lines are written, those of
    what is due now; a call without it joins them.

    Exit code: 0 written, or as written; 1 if a run failed, a page differs (--check) or a run does
    (--reproduce); 2 bad input.
    """
    check_jobs(jobs, ros=False, method="ours", cluster=cluster)
    chosen = [
        name
        for name, is_given in (
            ("--check", check), ("--reproduce", reproduce is not None), ("--estimate", estimate),
            ("--tune", tune),
        ) if is_given
    ]  # fmt: skip
    if len(chosen) > 1:
        raise ConfigError(f"{' and '.join(chosen)}: expected one of them at a time")
    if tune and quick:
        raise ConfigError("--tune has no short edition; leave out --quick")
    name = TUNING if tune else QUICK if quick else FULL
    task = os.environ.get("SLURM_ARRAY_TASK_ID", "") if shard == AUTO else shard or ""
    work = _Work(
        place=experiments or study_folder(),
        store=store_of(folder, name, task),
        jobs=jobs,
        cluster=cluster,
        shard=shard,
    )
    if estimate:
        _print_estimates(work)
        return
    console = new_console()
    if reproduce is not None:
        raise typer.Exit(FAILED if _reproduce(work, reproduce, console) else 0)
    if not check:
        limit = parse_time(budget)
        folder.mkdir(parents=True, exist_ok=True)
        work.run(console, name, math.inf if limit is None else limit, most)
        if shard:
            raise typer.Exit(FAILED if work.errors else 0)
        if work.lines:
            work.store.pack(KEY)
    if tune:
        tuning = load_tuning(work.place)
        conditions = {(run.cell.name, run.cell.condition) for run in tuning_runs(tuning)}
        known = [line for line in work.lines if (line.cell, line.condition) in conditions]
        console.print(f"wrote {write_chosen(work.place, choose(tuning, known))}", markup=False)
    else:
        command = "swarm-bench study --quick" if quick else "swarm-bench study"
        found = page.study_of(work.experiments, work.lines, work.settings)
        if check and found.edition not in ("", study_edition()):
            told = f"lines are of edition {found.edition}, and this code is {study_edition()}"
            typer.echo(f"{told}: see with --reproduce whether it makes the same", err=True)
        texts = _texts(found, output, command)
        texts |= {folder / "study.html": texts.pop(Path("study.html"))}
        if not quick:
            texts |= _parts(found, folder)
        _put(texts, check=check)
    if work.errors:
        raise typer.Exit(FAILED)


@dataclass(slots=True)
class _Work:
    """Experiments, the lines so far, and the way to add some."""

    place: Path
    store: Store[StudyLine]
    jobs: int
    cluster: str | None
    shard: str | None
    experiments: Experiments = field(init=False)
    settings: Mapping[str, Settings] = field(init=False)
    lines: list[StudyLine] = field(init=False)
    errors: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.experiments = load_experiments(self.place)
        self.settings = load_chosen(self.place)
        self.lines = list(self.store.by_key(KEY).values())

    @property
    def rates(self) -> Rates:
        """Measured CPU [ms] of a robot-second by method and LiDARs."""
        return rates_of(self.experiments, self.lines)

    def due(self, name: str) -> list[StudyRun]:
        """Return the runs of an edition that are due now."""
        if name == FULL:
            fitting = fitting_lines(self.experiments, self.lines, self.settings)
            return due_runs(self.experiments, fitting, self.settings)
        known = {line.key for line in self.lines}
        wanted = (
            tuning_runs(load_tuning(self.place))
            if name == TUNING
            else quick_runs(self.experiments, self.settings)
        )
        return [run for run in wanted if run.key not in known]

    def run(self, console: Console, name: str, seconds: float, most: int | None) -> None:
        """Make the runs that are due, then those that are due then, up to a time or a number."""
        if most != 0:  # else pages are written only
            _refuse_others(self.lines, self.store)
        end, failed = time.monotonic() + seconds, set[tuple[object, ...]]()
        left = math.inf if most is None else most
        with executor(self.jobs, self.cluster, apart=True) as computing:
            while left and time.monotonic() < end:
                due = [run for run in share_of(self.due(name), self.shard) if run.key not in failed]
                time_left = (end - time.monotonic()) * self.jobs
                todo = fitting(due, self.rates, time_left)
                todo = todo if math.isinf(left) else todo[: int(left)]
                hours = sum(run.cost(self.rates) for run in todo) / 3600.0
                known = f"{len(self.lines)} runs are in {self.store.path} already"
                told = f"{known}; {len(todo)} to do now: about {hours:.2f} h of CPU"
                console.print(told, markup=False, soft_wrap=True)
                if not todo:
                    break
                sweep = _sweep(todo, self.store, self.cluster)
                sweep.executor = computing
                with bar(console, "runs", len(todo)) as tell:
                    count = itertools.count(1)
                    sweep.run(
                        console,
                        watch=lambda *_: tell(next(count), len(todo)) is None,  # noqa: B023
                        seconds=end - time.monotonic(),
                    )
                self.lines += sweep.results
                self.errors += sweep.failed
                left -= len(todo)
                failed |= {run.key for run in todo} - {line.key for line in sweep.results}
                if self.shard:
                    break


def _refuse_others(lines: Sequence[StudyLine], store: Store[StudyLine]) -> None:
    """Refuse to add lines to those of another edition: pairs have to be of one."""
    editions = Counter(line.edition for line in lines if line.edition != study_edition())
    if editions:
        other, count = editions.most_common(1)[0]
        raise ConfigError(
            f"{store.path} has {count} lines of edition {other}, and this code with its worlds and "
            f"parameters is {study_edition()}; a study has one edition: run it with that code, or "
            "give another --folder"
        )


def _sweep(
    runs: Sequence[StudyRun], store: Store[StudyLine], cluster: str | None
) -> Sweep[tuple[StudyRun, RunOptions], StudyLine]:
    return Sweep(
        items=[(run, run.options()) for run in runs],
        runner=run_one,
        store=store,
        key=lambda item: item[0].key,
        key_of=KEY,
        line=line_text,
        name=lambda item: "{}: {}, {}, seed {}".format(*item[0].key),
        pack=lambda items: _pack(items, cluster),
    )


def _pack(items: Sequence[tuple[StudyRun, RunOptions]], cluster: str | None) -> Pack | None:
    """Return the inputs; processes of this machine read them themselves."""
    if cluster is None:
        return None
    return packed(gathered(options, load_inputs)[1] for _, options in items)


def rates_of(experiments: Experiments, lines: Sequence[StudyLine]) -> Rates:
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


def _print_estimates(work: _Work) -> None:
    """Print the hours of CPU of the first look by experiment, and of the other editions."""
    rates, fit = work.rates, fitting_lines(work.experiments, work.lines, work.settings)
    todo = due_runs(work.experiments, fit, work.settings)
    spent = sum(line.cpu for line in work.lines) / 3600.0
    typer.echo(f"{len(work.lines)} lines: {spent:.1f} h of CPU; no more looks after {BUDGET:g} h")
    parts = {name: [run for run in todo if run.experiment == name] for name in work.experiments}
    parts |= {"all of these": todo, "--quick": quick_runs(work.experiments, work.settings)}
    parts |= {"--tune": tuning_runs(load_tuning(work.place))}
    for name, runs in parts.items():
        hours = sum(run.cost(rates) for run in runs) / 3600.0
        typer.echo(f"{name}: {len(runs)} runs due, {hours:.1f} h of CPU")


def _reproduce(work: _Work, count: int, console: Console) -> int:
    """Run lines again; return how many differ in anything but times of the machine."""
    lines = fitting_lines(work.experiments, work.lines, work.settings)
    if not lines:
        raise ConfigError(f"{work.store.path} has no lines of the study's cells to run again")
    drawn = random.SystemRandom().sample(lines, min(count, len(lines)))
    if others := sum(line.edition != study_edition() for line in drawn):
        console.print(f"{others} of the lines are of another edition than this code", markup=False)
    cells = {
        (name, cell.name): cell
        for name, experiment in work.experiments.items()
        for cell in experiment.cells
    }
    runs = [
        StudyRun(
            line.experiment, cells[line.experiment, line.cell], line.method, line.seed,
            work.settings.get(line.method, ()),
        )
        for line in drawn
    ]  # fmt: skip
    items = [(run, run.options()) for run in runs]
    differing = 0
    with executor(work.jobs, work.cluster, apart=True) as computing:
        for done in computing.run(run_one, items, _pack(items, work.cluster)):
            told = done.error or ", ".join(_differences(drawn[done.index], done.value))
            differing += bool(told)
            name = "{}: {}, {}, seed {}".format(*runs[done.index].key)
            console.print(f"{name}: {f'differs: {told}' if told else 'the same'}", markup=False)
    console.print(f"{len(drawn) - differing} of {len(drawn)} lines are the same", markup=False)
    return differing


def _differences(line: StudyLine, again: StudyLine) -> Iterator[str]:
    second = again.repeatable
    for name, value in line.repeatable.items():
        if second[name] != value:
            yield f"{name} is {second[name]}, was {value}"


def _texts(found: page.StudyState, output: Path, command: str) -> dict[Path, str]:
    """Return document, figures and the page with all columns, by file."""
    drawn = page.pictures(found)
    return {
        output: page.markdown(found, output.stem, command),
        **{output.with_name(f"{output.stem}_{name}.svg"): text for name, text in drawn.items()},
        Path("study.html"): page.page(found),
    }


def _parts(found: page.StudyState, folder: Path) -> dict[Path, str]:
    """Return the documents that have a part about the study, by file, with that part anew."""
    protocol, readme = folder / PROTOCOL, folder.resolve().parent / README
    texts = {}
    if protocol.is_file():
        texts[protocol] = with_part(protocol, CELLS, page.protocol_part(found.experiments))
    if readme.is_file() and f"<!-- {ANSWER} -->" in readme.read_text("utf-8", errors="replace"):
        texts[readme] = with_part(readme, ANSWER, page.summary(found))
    return texts


def _put(texts: Mapping[Path, str], *, check: bool) -> None:
    """Write files, or exit with `DIFFERS` if one is not what the lines say."""
    differing = []
    for path, text in texts.items():
        if not check:
            try:
                path.write_text(text, encoding="utf-8")
            except OSError as cause:
                raise ConfigError(f"cannot write {path}: {cause}") from cause
            continue
        old = path.read_text(encoding="utf-8") if path.is_file() else ""
        ours, theirs = DRAWN_BY.search(text), DRAWN_BY.search(old)
        if ours and theirs and ours[1] != theirs[1]:
            told = f"{path} is drawn by matplotlib {theirs[1]}, and this is {ours[1]}: not compared"
            typer.echo(told, err=True)
        elif old != text:
            differing.append(path)
    for path in differing:
        typer.echo(f"{path} differs from the lines; write it with swarm-bench study", err=True)
    if differing:
        raise typer.Exit(DIFFERS)
