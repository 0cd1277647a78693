"""One run on the real ROS graph: `swarm-up` with a scenario's input, and its report read."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from msgspec.structs import replace

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.methods import METHODS
from swarm_bench.runs.result_builder import identity
from swarm_common.model.errors import SwarmError
from swarm_common.model.robot_names import RobotNames
from swarm_common.process.lifetime import die_with
from swarm_describe.worlds.world_file import find_world
from swarm_run.command_line import SWARM_UP
from swarm_run.flags import text_of
from swarm_run.params import EVERY_NAVIGATOR
from swarm_run.record.report_file import record_of
from swarm_run.record.run_record import RunRecord
from swarm_run.spec import RunSpec

ENGINE = "ros"  # what a result's engine is called: rigid bodies behind the ROS graph
LAST_LINES = 5  # of swarm-up's output, in an error


class SwarmUpError(SwarmError):
    """`swarm-up` could not run."""


def run_on_graph(options: RunOptions) -> RunRecord:
    """Run a scenario once with `swarm-up`: processes, DDS, rigid bodies, LiDARs.

    Args:
        options: What to run; the method has to be ours, or a plug-in.

    Raises:
        SwarmUpError: If it left no report; the message ends with what it said last.
    """
    with tempfile.TemporaryDirectory(prefix="swarm-bench-") as name:
        folder = Path(name)
        described, parent = folder / "run.yaml", os.getpid()
        described.write_text(text_of(spec_of(options, folder)), encoding="utf-8")
        with subprocess.Popen(
            (*SWARM_UP, "--spec", described), cwd=folder, env=_with_plugins(),
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            preexec_fn=lambda: die_with(parent),
        ) as process:  # fmt: skip
            try:
                said, _ = process.communicate()
            except BaseException:  # an interrupted bench takes its swarm along
                process.terminate()
                process.wait()
                raise
        report_path = folder / "run" / "report.json"
        if not report_path.is_file():
            raise SwarmUpError(
                f"swarm-up ended with code {process.returncode} and no report; it said:\n"
                f"{last_lines(said)}"
            )
        report = json.loads(report_path.read_text(encoding="utf-8"))
    return result_of_report(options, report)


def _with_plugins() -> dict[str, str]:
    """Return the environment of a run that finds the modules of the present folder, too."""
    path = [os.environ["PYTHONPATH"]] if os.environ.get("PYTHONPATH") else []
    return {**os.environ, "PYTHONPATH": os.pathsep.join([*path, os.getcwd()])}


def last_lines(said: str) -> str:
    """Return the last lines of a program's output, for an error.

    Returns:
        At most `LAST_LINES` lines.
    """
    return "\n".join(said.strip().splitlines()[-LAST_LINES:])


def spec_of(options: RunOptions, folder: Path) -> RunSpec:
    """Return a run as `swarm-up` takes it; writes the files that it names to a folder.

    Args:
        folder: Existing folder; the run's own folder is made in it.
    """
    scenario, count = options.scenario, options.robots
    params, fleet = folder / "params.yaml", folder / "fleet.yaml"
    params.write_text(yaml.safe_dump(_parameters(options)), encoding="utf-8")
    if scenario.fleet:
        fleet.write_text(yaml.safe_dump(_fleet(scenario.fleet, count)), encoding="utf-8")
    return RunSpec(
        swarm_size=count,
        world=scenario.world,
        robot=None if scenario.fleet else scenario.robot,
        fleet=str(fleet) if scenario.fleet else None,
        mission=scenario.mission or None,
        seed=options.seed,
        laps=scenario.laps,
        params=str(params),
        run_dir=str(folder / "run"),
        duration=scenario.limit_of(count),
        speed="max",
        realistic=options.realistic,
        until_done=True,
        headless=True,
        over_limit=True,
        report=False,
    )


def _parameters(options: RunOptions) -> dict[str, Any]:
    """Return the parameter file of a run."""
    scenario = options.scenario
    world: dict[str, Any] = {
        "engine": options.engine,
        "with_lidar": scenario.with_lidar,
        "actuation_noise": float(scenario.noise),
        "radio.loss": float(scenario.loss),
        "radio.delay": float(scenario.delay),
    }
    if scenario.actors:
        home = find_world(scenario.world).absolute().parent
        world["actors"] = str(home / scenario.actors)
    first_dead = options.robots - len(scenario.dead) + 1
    for number, pose in enumerate(scenario.dead, first_dead):
        world[f"broken.{RobotNames().name_of(number)}"] = list(pose)
    robots = dict(options.parameters)
    if not scenario.with_lidar:
        robots["costmap.scan_timeout"] = 0.0
    if options.method not in METHODS:
        robots["brain.plugin"] = options.method
    sections = {"/world": world, **options.sections, EVERY_NAVIGATOR: robots}
    return {name: {"ros__parameters": values} for name, values in sections.items() if values}


def _fleet(models: tuple[str, ...], count: int) -> dict[str, Any]:
    shares = [len(range(index, count, len(models))) for index in range(len(models))]
    groups = [
        {"model": model, "count": share}
        for model, share in zip(models, shares, strict=True)
        if share
    ]
    return {"order": "mixed", "groups": groups}


def result_of_report(options: RunOptions, report: Mapping[str, Any]) -> RunRecord:
    """Return the record in a `report.json`, under the bench's names for the run."""
    return replace(record_of(report), **identity(options) | {"engine": ENGINE})
