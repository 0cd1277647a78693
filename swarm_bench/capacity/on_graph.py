"""`swarm-up --sweep`: a run on the ROS graph for each value, with the tables of `swarm-bench`."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import typer
import yaml

from swarm_bench.capacity.axes import OF_CONTROLLER, combinations, name_of
from swarm_bench.capacity.curve import Curve, curve_of
from swarm_bench.capacity.report import print_curves, sentences, write_output
from swarm_bench.runs.episode import RunOptions, parse_parameters
from swarm_bench.runs.result import RunResult, Steady
from swarm_bench.runs.ros_run import LAST, result_of_report
from swarm_bench.runs.scenario import Scenario
from swarm_bench.runs.steady import steady_of
from swarm_bench.suite.command import MISSED, new_console
from swarm_bench.suite.table import run_line
from swarm_common.files.journal import read_journal
from swarm_common.files.run_folders import RUNS
from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import ConfigError
from swarm_run.arguments import UpArguments, parser
from swarm_run.command_line import SWARM_UP, run_command
from swarm_run.options import UpOptions
from swarm_run.plan import check_plan

FLAGS = {"robots": "--swarm-size"}  # axes that are called otherwise than their option
OF_POINT = ("robots", "swarm_size", "seed")  # axes within a curve
WARM_UP_SHARE = 6  # of --duration is one part warm-up
OUTPUTS = ("sweep.html", "sweep.csv", "sweep.json")


@dataclasses.dataclass(frozen=True, slots=True)
class _GraphRun:
    label: str  # of its curve
    options: UpOptions
    words: list[str]  # of its command line


sweep_app = typer.Typer()


@sweep_app.command(context_settings={"ignore_unknown_options": True, "allow_extra_args": True})
def sweep_on_graph(context: typer.Context) -> None:
    """Run `swarm-up` for all combinations; print and write what they say.

    Exit code: 0 all runs had exit code 0; 1 otherwise; 2 bad input.
    """
    given = UpArguments(**_parsed(context.args))
    folder = given.run_dir or RUNS / datetime.now().strftime("sweep_%Y-%m-%d_%H-%M-%S")
    folder.mkdir(parents=True, exist_ok=True)
    words = _without(("--sweep", "--warm-up", "--run-dir"), context.args)
    runs = [
        _run_of(dict(chosen), words, folder, number)
        for number, (_, chosen) in enumerate(combinations(given.sweep or ()), 1)
    ]
    for run in runs:
        if given.warm_up is not None and not 0.0 <= given.warm_up < (run.options.duration or 1e9):
            raise ConfigError(
                f"--warm-up is {given.warm_up:g}; expected 0 or more, less than --duration"
            )
    console, curves, is_flawless = new_console(), dict[str, list[RunResult]](), True
    try:
        for run in runs:
            where = Path(run.words[-1])
            code = subprocess.run((*SWARM_UP, *run.words), check=False).returncode
            result = _result(run.options, where, given.warm_up)
            is_flawless &= code == 0 and result is not None
            if result is None:
                console.print(f"{where}: no result, exit code {code}", highlight=False)
            else:
                console.print(run_line(result), highlight=False, soft_wrap=True, markup=False)
                curves.setdefault(run.label, []).append(result)
    finally:
        _tell([curve_of(label, found) for label, found in curves.items()], folder)
    if not is_flawless:
        raise typer.Exit(MISSED)


def _parsed(words: Sequence[str]) -> dict[str, Any]:
    params: dict[str, Any] = parser().make_context("swarm-up", list(words)).params
    return params


def _options(words: Sequence[str]) -> UpOptions:
    options = UpArguments(**_parsed(words)).options()
    check_plan(options)
    return options


def _without(flags: Sequence[str], words: Sequence[str]) -> list[str]:
    """Return a command line without some options, which have a value each."""
    kept: list[str] = []
    is_value = False
    for word in words:
        name, equals, _ = word.partition("=")
        if not is_value and name not in flags:
            kept.append(word)
        is_value = not is_value and name in flags and not equals
    return kept


def _tell(curves: Sequence[Curve], folder: Path) -> None:
    if not any(curve.points for curve in curves):
        return
    told, console = sentences(curves, compare=False), new_console()
    print_curves(curves, told, console)
    for name in OUTPUTS:
        write_output(folder / name, curves, told, " ".join(["swarm-up", *sys.argv[1:]]))
    console.print(f"{folder / OUTPUTS[0]}", highlight=False)


def _run_of(
    chosen: Mapping[str, str], words: Sequence[str], folder: Path, number: int
) -> _GraphRun:
    flags = {item.name: item.opts[0] for item in parser().params}
    changed, parameters = list(words), dict[str, Any]()
    for name, text in chosen.items():
        flag = FLAGS.get(name) or flags.get(name.replace("-", "_"))
        if flag is not None:
            changed += [flag, text]
        else:
            setting = f"{name.removeprefix(OF_CONTROLLER)}={text}"
            parameters |= parse_parameters([setting], "--sweep")
    if parameters:
        given = _options(changed).params
        tree = dict(read_yaml(given)) if given is not None else {}
        section = tree.pop(LAST, {}).get("ros__parameters", {}) | parameters
        path = folder / f"params_{number}.yaml"
        path.write_text(yaml.safe_dump(tree | {LAST: {"ros__parameters": section}}), "utf-8")
        changed += ["--params", str(path)]
    changed += ["--run-dir", str(folder / f"run_{number}")]
    label = ", ".join(f"{name}={text}" for name, text in chosen.items() if name not in OF_POINT)
    return _GraphRun(label, _options(changed), changed)


def _result(options: UpOptions, folder: Path, warm_up: float | None) -> RunResult | None:
    """Return the result of a run; None without a report, or if all of it was warm-up."""
    try:
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if warm_up is None:
        warm_up = 0.0 if options.duration is None else options.duration / WARM_UP_SHARE
    if report["sim_time"] <= warm_up:
        return None
    mission = options.mission or ""
    scenario = Scenario(
        name=name_of(options.world, mission),
        world=options.world,
        mission=mission,
    )
    run = RunOptions(scenario=scenario, robots=options.swarm_size, seed=options.seed)
    steady = _steady(report, folder, warm_up)
    return dataclasses.replace(result_of_report(run, report), steady=steady)


def _steady(report: Mapping[str, Any], folder: Path, warm_up: float) -> Steady:
    if "orders" in report:
        orders = report["orders"]["orders"]
        done = [(each["done"], each["lead_time"]) for each in orders if each["done"] is not None]
        return steady_of(done, warm_up, report["sim_time"], "orders")
    lines = read_journal(folder / "trace" / "robots.jsonl")
    reached = [(one["t"], one["duration"]) for one in lines if one.get("outcome") == "reached"]
    return steady_of(reached, warm_up, report["sim_time"])


if __name__ == "__main__":
    run_command("swarm-up", lambda: sweep_app)
