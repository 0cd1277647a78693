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

import msgspec
import typer

from swarm_bench.capacity.axes import combinations, name_of, parameter_of
from swarm_bench.capacity.curve import Curve, curve_of
from swarm_bench.capacity.report import print_curves, sentences, write_output
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.ros_run import result_of_report
from swarm_bench.runs.scenario import Scenario
from swarm_bench.suite.command import MISSED, new_console
from swarm_bench.suite.table import run_line
from swarm_common.files.journal import read_journal
from swarm_common.files.resources import RUNS
from swarm_common.model.errors import ConfigError
from swarm_run.command_line import SWARM_UP, run_command
from swarm_run.flags import actions_of, parser, stated_of, text_of
from swarm_run.plan import check_plan
from swarm_run.record.figures import Steady, steady_of
from swarm_run.record.run_record import RunRecord
from swarm_run.spec import RunSpec

FLAGS = {"robots": "--swarm-size"}  # axes that are called otherwise than their option
OF_POINT = ("robots", "swarm_size", "seed")  # axes within a curve
WARM_UP_SHARE = 6  # of --duration is one part warm-up
OUTPUTS = ("sweep.html", "sweep.csv", "sweep.json")


@dataclasses.dataclass(frozen=True, slots=True)
class _GraphRun:
    label: str  # of its curve
    spec: RunSpec
    folder: Path


sweep_app = typer.Typer()


@sweep_app.command(context_settings={"ignore_unknown_options": True, "allow_extra_args": True})
def sweep_on_graph(context: typer.Context) -> None:
    """Run `swarm-up` for all combinations; print and write what they say.

    Exit code: 0 all runs had exit code 0; 1 otherwise; 2 bad input.
    """
    given = parser().make_context("swarm-up", list(context.args))
    actions, stated = actions_of(given), stated_of(given)
    folder = Path(
        stated.get("run_dir") or RUNS / datetime.now().strftime("sweep_%Y-%m-%d_%H-%M-%S")
    )
    folder.mkdir(parents=True, exist_ok=True)
    runs = [
        _run_of(dict(chosen), stated, folder / f"run_{number}")
        for number, (_, chosen) in enumerate(combinations(actions.sweep or ()), 1)
    ]
    for run in runs:
        if actions.warm_up is not None and not 0.0 <= actions.warm_up < (run.spec.duration or 1e9):
            raise ConfigError(
                f"--warm-up is {actions.warm_up:g}; expected 0 or more, less than --duration"
            )
    console, curves, is_flawless = new_console(), dict[str, list[RunRecord]](), True
    try:
        for run in runs:
            described = run.folder.with_suffix(".yaml")
            described.write_text(text_of(run.spec), "utf-8")
            code = subprocess.run((*SWARM_UP, "--spec", described), check=False).returncode
            result = _result(run.spec, run.folder, actions.warm_up)
            is_flawless &= code == 0 and result is not None
            if result is None:
                console.print(f"{run.folder}: no result, exit code {code}", highlight=False)
            else:
                console.print(run_line(result), highlight=False, soft_wrap=True, markup=False)
                curves.setdefault(run.label, []).append(result)
    finally:
        ended = sum(map(len, curves.values()))
        cut = f"The sweep was cut: {ended} of {len(runs)} runs have a result."
        found = [curve_of(label, results) for label, results in curves.items()]
        _tell(found, folder, [cut] if ended < len(runs) else [])
    if not is_flawless:
        raise typer.Exit(MISSED)


def _tell(curves: Sequence[Curve], folder: Path, remarks: Sequence[str]) -> None:
    if not any(curve.points for curve in curves):
        return
    told, console = [*remarks, *sentences(curves, compare=False)], new_console()
    print_curves(curves, told, console)
    for name in OUTPUTS:
        write_output(folder / name, curves, told, " ".join(["swarm-up", *sys.argv[1:]]))
    console.print(f"{folder / OUTPUTS[0]}", highlight=False)


def _run_of(chosen: Mapping[str, str], stated: Mapping[str, Any], folder: Path) -> _GraphRun:
    flags = {item.name: item.opts[0] for item in parser().params}
    words, parameters = list[str](), dict(stated.get("parameters", {}))
    for name, text in chosen.items():
        flag = FLAGS.get(name) or flags.get(name.replace("-", "_"))
        if flag is not None:
            words += [flag, text]
        else:
            parameters |= parameter_of(name, text, [*FLAGS, *flags])
    varied = stated_of(parser().make_context("swarm-up", words))
    own = {"parameters": parameters, "run_dir": str(folder)}
    spec = RunSpec(**{**stated, **varied, **own})
    spec.check_host()
    check_plan(spec)
    label = ", ".join(f"{name}={text}" for name, text in chosen.items() if name not in OF_POINT)
    return _GraphRun(label, spec, folder)


def _result(spec: RunSpec, folder: Path, warm_up: float | None) -> RunRecord | None:
    """Return the result of a run; None without a report, or if all of it was warm-up."""
    try:
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if warm_up is None:
        warm_up = 0.0 if spec.duration is None else spec.duration / WARM_UP_SHARE
    if report["sim_time"] <= warm_up:
        return None
    mission = spec.mission or ""
    scenario = Scenario(
        name=name_of(spec.world, mission), world=spec.world, mission=mission,
    )  # fmt: skip
    run = RunOptions(scenario=scenario, robots=spec.size, seed=spec.seed)
    steady = _steady(report, folder, warm_up)
    return msgspec.structs.replace(result_of_report(run, report), steady=steady)


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
