"""The command `swarm-bench sweep`: its options."""

from __future__ import annotations

import dataclasses
import math
import shlex
import sys
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from swarm_bench.capacity.axes import SweepVariant, name_of, variants
from swarm_bench.capacity.report import check_output, print_curves, sentences, write_output
from swarm_bench.capacity.study import Study
from swarm_bench.execution.executor import executor
from swarm_bench.execution.sweep import bar
from swarm_bench.runs.episode import RunOptions, check, parse_parameters
from swarm_bench.runs.methods import load_method
from swarm_bench.runs.scenario import Scenario, load_scenario
from swarm_bench.suite.command import (
    Cluster,
    Jobs,
    JsonLines,
    Settings,
    Shard,
    bench_app,
    end_unless_flawless,
    keeping,
    new_console,
    world_as,
)
from swarm_bench.suite.selection import check_jobs, parse_seeds, parse_sizes, parse_time
from swarm_bench.suite.sweep import RunSweep
from swarm_common.model.errors import ConfigError
from swarm_run.record.figures import HOUR

precise = partial(typer.Option, rich_help_panel="How precise")

PRECISION = 0.03  # where only a budget is given
EXAMPLES = """Examples:

swarm-bench sweep --robots 4..24:4 --jobs 2 --output sweep.html

swarm-bench sweep --world warehouse --sweep max_vel_x=0.26,0.5 --budget 30min
"""


@bench_app.command("sweep", epilog=EXAMPLES)
def sweep_command(
    world: Annotated[str, typer.Option(help="Name or path.")] = "slim_blockage",
    mission: Annotated[str, typer.Option(help="Name or path.")] = "loading_route",
    robots: Annotated[str, typer.Option(help="Swarm sizes like 4..60:4 or 20,50.")] = "4..24:4",
    seeds: Annotated[str, typer.Option(help="Seeds like 0-9 or 1,5,7.")] = "0-2",
    seconds: Annotated[float, world_as(help="Simulated time of each run, in s.")] = 1800.0,
    warm_up: Annotated[float, world_as(help="Time that does not count, in s.")] = 300.0,
    sweep: Annotated[
        list[str] | None,
        typer.Option(
            help="Axis: max_vel_x=0.26,0.5; world, mission, robot, fleet=A+B, method, loss, ..."
        ),
    ] = None,
    compare: Annotated[
        tuple[Path, Path] | None,
        typer.Option(help="Two scenario files: the difference on the same seeds."),
    ] = None,
    precision: Annotated[
        str | None, precise(help="Adds seeds and sizes, until intervals are like 3%.")
    ] = None,
    budget: Annotated[
        str | None, precise(help="Likewise, for this wall time: 90s, 30min, 2h.")
    ] = None,
    method: Annotated[str, world_as(help="ours, dwa, orca, or module:Class of your own.")] = "ours",
    set_: Settings = None,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    shard: Shard = None,
    json_: JsonLines = None,
    output: Annotated[
        list[Path] | None,
        keeping("-o", "--output", help="Page .html, points .csv or summary .json; several."),
    ] = None,
) -> None:
    """Run swarms of several sizes for a fixed time: throughput, lead times, knee and reason.

    Exit code: 0 no collision, no missed goal, no failed run; 1 otherwise; 2 bad input.
    """
    chosen = _variants(world, mission, seconds, warm_up, method, set_ or [], sweep or [], compare)
    outputs = output or []
    for path in outputs:
        check_output(path)
    check_jobs(jobs, ros=False, method=method)
    wished = parse_precision(precision)
    limit = parse_time(budget)
    if shard is not None and (wished or limit):
        raise ConfigError("--shard needs a fixed list of runs; leave out --precision and --budget")
    if limit is not None and wished is None:
        wished = PRECISION
    study = Study(
        chosen,
        parse_sizes(robots),
        parse_seeds(seeds) or range(3),
        precision=wished,
        budget=limit,
        shard=shard,
    )
    with executor(jobs, cluster) as computes:
        runs = study.all_runs()
        RunSweep(runs).check()
        console = new_console()
        smallest = [run for run in runs if run.robots == min(each.robots for each in runs)]
        for remark in dict.fromkeys(told for run in smallest for told in check(run)):
            console.print(remark, style="yellow", highlight=False, markup=False)
        try:
            with bar(console, "robot-hours", study.planned / HOUR) as tell:
                study.run(
                    lambda runs: RunSweep(runs, json_, computes),
                    console,
                    lambda: tell(study.done / HOUR, study.planned / HOUR),
                )
        finally:
            _report(study, console, outputs, compare=compare is not None)
    results = [run for found in study.results for run in found]
    end_unless_flawless(study.failed, results)


def _variants(
    world: str,
    mission: str,
    seconds: float,
    warm_up: float,
    method: str,
    settings: list[str],
    axes: list[str],
    compare: tuple[Path, Path] | None,
) -> list[SweepVariant]:
    """Return what is run at all sizes."""
    timing: dict[str, Any] = {"duration": seconds, "warm_up": warm_up}
    if seconds <= 0.0:
        raise ConfigError(f"--seconds is {seconds:g}; it must be positive")
    if not 0.0 <= warm_up < seconds:
        raise ConfigError(
            f"--warm-up is {warm_up:g}; expected 0 or more, and less than --seconds {seconds:g}"
        )
    load_method(method)
    common: dict[str, Any] = {"method": method, "parameters": parse_parameters(settings)}
    if compare is None:
        scenario = Scenario(name=name_of(world, mission), world=world, mission=mission, **timing)
        return variants(RunOptions(scenario=scenario, robots=1, **common), axes)
    if axes:
        raise ConfigError("--compare has two variants already; leave out --sweep")
    found = []
    for path in compare:
        scenario = dataclasses.replace(load_scenario(str(path)), **timing)
        found.append(SweepVariant(path.stem, RunOptions(scenario=scenario, robots=1, **common)))
    if found[0].label == found[1].label:
        raise ConfigError(f"--compare has two files of one name, {found[0].label}; rename one")
    return found


def parse_precision(text: str | None) -> float | None:
    """Return the share in a text like 3% or 0.03.

    Raises:
        ConfigError: If it is none, or not between 0 and 100 %.
    """
    if text is None:
        return None
    try:
        value = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1.0:
        raise ConfigError(f"--precision is '{text}'; expected a share like 3%")
    return value


def _report(study: Study, console: Console, outputs: list[Path], *, compare: bool) -> None:
    """Print and write what is known, also after an interrupt."""
    curves = study.curves
    if not any(curve.points for curve in curves):
        return
    told = [*filter(None, [study.cut]), *sentences(curves, compare=compare)]
    print_curves(curves, told, console)
    for path in outputs:
        write_output(path, curves, told, shlex.join(["swarm-bench", *sys.argv[1:]]))
