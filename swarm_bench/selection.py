"""From the words on the command line to a list of runs."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from swarm_bench.methods import METHODS
from swarm_bench.scenario import Scenario, check_size, load_scenario, scenario_names
from swarm_bench.stage import RunOptions, parse_parameters
from swarm_common.errors import ConfigError, UnknownNameError
from swarm_sim.world import ENGINES

MOST_SEEDS = 100_000


def parse_seeds(text: str) -> list[int]:
    """Return the seeds in a text like 0-19 or 1,5,7-9.

    Raises:
        ConfigError: If it is malformed.
    """
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
    """Return the swarm sizes in a text like 20,50; none for None.

    Raises:
        ConfigError: If one is no number or out of bounds.
    """
    if text is None:
        return []
    sizes = []
    for part in text.split(","):
        try:
            sizes.append(check_size(int(part), "--robots"))
        except ValueError:
            raise ConfigError(f"--robots is '{text}'; expected sizes like 20,50") from None
    return sizes


def select(
    names: str,
    sizes: Sequence[int],
    seeds: Sequence[int],
    *,
    method: str = "ours",
    engine: str = "planar",
    loss: float | None = None,
    delay: float | None = None,
    lidar: bool | None = None,
    settings: Sequence[str] = (),
) -> list[RunOptions]:
    """Return the runs asked for, scenario by scenario, size by size, seed by seed.

    Raises:
        ConfigError: For the first thing that is wrong.
    """
    if method not in METHODS:
        raise UnknownNameError("method", method, METHODS)
    if engine not in ENGINES:
        raise UnknownNameError("engine", engine, ENGINES)
    parameters = parse_parameters(list(settings))
    changes: dict[str, Any] = {
        key: value
        for key, value in {"loss": loss, "delay": delay, "with_lidar": lidar}.items()
        if value is not None
    }
    scenarios = [dataclasses.replace(item, **changes) for item in _scenarios(names)]
    return [
        RunOptions(
            scenario=scenario,
            robots=size,
            seed=seed,
            method=method,
            engine=engine,
            parameters=parameters,
        )
        for scenario in scenarios
        for size in (sizes or scenario.robots)
        for seed in seeds
    ]


def _scenarios(names: str) -> list[Scenario]:
    if names == "all":
        return [load_scenario(name) for name in scenario_names()]
    return [load_scenario(name.strip()) for name in names.split(",")]
