"""From the words on the command line to a list of runs."""

from __future__ import annotations

import dataclasses
import functools
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from swarm_bench.execution.task import Executor
from swarm_bench.runs.episode import RunOptions, parameter_sections, parse_parameters
from swarm_bench.runs.methods import METHODS, TEAMS, load_method
from swarm_bench.runs.scenario import check_size, load_scenario, scenario_names
from swarm_bench.suite.sweep import RunSweep
from swarm_central.config import central_from_texts
from swarm_central.movingai import check_program
from swarm_common.model.engines import usual_engine
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_sim.world.world import ENGINES

MOST_SEEDS = 100_000
UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}  # [s]
MOST_JOBS = 256
SUITE = "suite"  # as many seeds as each scenario says
ALL = "all"  # scenarios
CENTRAL = "central."  # begins the parameters of a centre
NONE = "none"  # seeds


def parse_seeds(text: str) -> list[int] | None:
    """Return the seeds in a text like 0-19 or 1,5,7-9; None for `suite`.

    Args:
        text: Numbers and ranges, comma-separated, or `suite`.

    Returns:
        In the order given, each once.

    Raises:
        ConfigError: If it is malformed.
    """
    if text == SUITE:
        return None
    seeds: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise ConfigError(f"--seeds is '{text}'; expected seeds like 0-19 or 1,5,7")
        low, high = int(first), int(last or first)
        if high < low or high - low >= MOST_SEEDS:
            raise ConfigError(f"--seeds has the range '{part.strip()}'; expected FIRST-LAST")
        seeds.extend(seed for seed in range(low, high + 1) if seed not in seeds)
    return seeds


def parse_sizes(text: str | None) -> list[int]:
    """Return the swarm sizes in a text like 20,50 or 4..60:4; none for None.

    Args:
        text: Sizes and ranges FIRST..LAST:STEP, comma-separated.

    Raises:
        ConfigError: If one is not a number or out of bounds.
    """
    if text is None:
        return []
    sizes = []
    for part in text.split(","):
        first, dots, rest = part.partition("..")
        last, colon, step = rest.partition(":")
        try:
            low = check_size(int(first), "--robots")
            high = check_size(int(last), "--robots") if dots else low
            by = int(step) if colon else 1
        except ValueError:
            raise ConfigError(
                f"--robots is '{text}'; expected sizes like 20,50 or 4..60:4"
            ) from None
        if high < low or by < 1:
            raise ConfigError(f"--robots has the range '{part}'; expected FIRST..LAST:STEP")
        sizes += [size for size in range(low, high + 1, by) if size not in sizes]
    return sizes


def parse_time(text: str | None) -> float | None:
    """Return the seconds in a text like 90s, 30min or 2h.

    Raises:
        ConfigError: If it is none.
    """
    if text is None:
        return None
    found = re.fullmatch(r"([0-9.]+) ?(s|min|h)", text)
    try:
        value = float(found[1]) * UNITS[found[2]] if found else 0.0
    except ValueError:
        value = 0.0
    if value <= 0.0:
        raise ConfigError(f"--budget is '{text}'; expected a time like 90s, 30min or 2h")
    return value


def select(
    names: str,
    sizes: Sequence[int],
    seeds: Sequence[int] | None,
    *,
    method: str = "ours",
    engine: str = "planar",
    loss: float | None = None,
    delay: float | None = None,
    lidar: bool | None = None,
    realistic: bool = False,
    settings: Sequence[str] = (),
    params: Path | None = None,
    central_solver: str = "",
) -> list[RunOptions]:
    """Return the runs asked for, scenario by scenario, size by size, seed by seed.

    Args:
        names: Scenario names, comma-separated; `all` for every one that comes with the project.
        sizes: Swarm sizes; empty for those of each scenario.
        seeds: The seeds; None for as many as each scenario says.
        loss: Share of beacons that are lost, in place of the scenario's.
        delay: [s] of beacons, likewise.
        realistic: Whether sensors err and navigators localise by AMCL; needs LiDARs.
        settings: Parameters like traffic.safety_margin=0.06, or central.planner=lacam.
        central_solver: Path of a program that plans for the centre; empty for none.

    Raises:
        ConfigError: For the first thing that is wrong.
    """
    load_method(method)
    if engine not in ENGINES:
        raise UnknownNameError("engine", engine, ENGINES)
    if realistic and (lidar is False or method != "ours"):
        given = "--no-lidar" if lidar is False else f"--method {method}"
        raise ConfigError(f"--realistic localises by LiDAR in our navigators; leave out {given}")
    ours = [setting for setting in settings if not setting.startswith(CENTRAL)]
    central = _central([text for text in settings if text.startswith(CENTRAL)], central_solver)
    if central and method not in TEAMS:
        name = "--central-solver" if central_solver else f"--set {CENTRAL}..."
        raise ConfigError(f"{name} needs --method {' or '.join(TEAMS)}, not {method}")
    common: dict[str, Any] = {
        "method": method,
        "engine": engine,
        "parameters": parse_parameters(ours),
        "realistic": realistic,
        "central": central,
    }
    changes: dict[str, Any] = {
        key: value
        for key, value in {"loss": loss, "delay": delay, "with_lidar": lidar}.items()
        if value is not None
    }
    chosen = scenario_names() if names == ALL else [name.strip() for name in names.split(",")]
    scenarios = [dataclasses.replace(load_scenario(name), **changes) for name in chosen]
    sections = functools.cache(lambda size: parameter_sections(params, size) if params else {})
    return [
        RunOptions(scenario=scenario, robots=size, seed=seed, sections=sections(size), **common)
        for scenario in scenarios
        for size in (sizes or scenario.robots)
        for seed in (range(scenario.seeds_of(size)) if seeds is None else seeds)
    ]


def _central(settings: Sequence[str], solver: str) -> dict[str, Any]:
    """Return the parameters of a centre by name, as far as they are given."""
    texts = {}
    for setting in settings:
        name, equals, text = setting.removeprefix(CENTRAL).partition("=")
        if not equals:
            raise ConfigError(f"--set is '{setting}'; expected NAME=VALUE")
        texts[name] = text
    if solver:
        texts["solver"] = solver
    config = central_from_texts(texts)
    if config.solver:
        check_program(Path(config.solver))
    return {name: getattr(config, name) for name in texts}


def check_jobs(jobs: int, *, ros: bool, method: str, cluster: str | None = None) -> None:
    """Refuse a number of processes, or a way to run, that cannot be.

    Args:
        ros: Whether runs are on the ROS graph.
        cluster: Value of `--cluster`; None without it.

    Raises:
        ConfigError: With what to do.
    """
    if not 1 <= jobs <= MOST_JOBS:
        raise ConfigError(f"--jobs is {jobs}; expected 1 to {MOST_JOBS}")
    if ros and (jobs > 1 or cluster is not None):
        option = "--jobs" if jobs > 1 else "--cluster"
        raise ConfigError(f"--ros takes all cores for each run; leave out {option}")
    if ros and method != "ours" and method in METHODS:
        raise ConfigError(f"--ros runs our navigators; --method {method} needs the bench")


def suite_sweeps(
    seeds: str,
    baseline_seeds: str,
    ros_seeds: str,
    ros_most: int,
    file: Path | None,
    executor: Executor,
) -> list[RunSweep]:
    """Return everything that the suite's document is written from.

    Each sweep goes seed by seed, so that a killed one has something of every row.

    Args:
        baseline_seeds: Seeds of the other methods; `none` to leave them out.
        executor: Executor of the runs in the bench.
    """
    sweeps = [RunSweep(_by_seed(select(ALL, (), parse_seeds(seeds))), file, executor)]
    if baseline_seeds != NONE:
        chosen = parse_seeds(baseline_seeds)
        others = [method for method in METHODS if method != "ours" and method not in TEAMS]
        sweeps += [
            RunSweep(_by_seed(select(ALL, (), chosen, method=method)), file, executor)
            for method in others
        ]
    if ros_seeds != NONE:
        runs = select(ALL, (), parse_seeds(ros_seeds), engine=usual_engine(), lidar=True)
        runs = _by_seed([run for run in runs if run.robots <= ros_most])
        sweeps.append(RunSweep(runs, file, ros=True))
    return sweeps


def _by_seed(options: Sequence[RunOptions]) -> list[RunOptions]:
    return sorted(options, key=lambda item: (item.seed, -item.robots))
