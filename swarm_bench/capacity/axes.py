"""From the words on the command line to the variants of a study."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarm_bench.runs.episode import RunOptions, parse_parameters
from swarm_bench.runs.methods import load_method
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_sim.world.world import ENGINES

MOST_VARIANTS = 100
TEXTS = ("world", "mission", "robot", "actors", "dispatch")  # fields of a scenario that are texts
NUMBERS = ("loss", "delay", "noise")
FLEET = "fleet"  # models joined by +
OTHERS = ("method", "engine", "with_lidar", FLEET)
OF_CONTROLLER = "controller."  # may stand before its parameters, as in Nav2's files


@dataclass(frozen=True, slots=True)
class SweepVariant:
    """Runs that are made at all sizes."""

    label: str  # how it differs from the other variants; empty if there is no other
    base: RunOptions  # of any size and seed


def variants(base: RunOptions, axes: Sequence[str]) -> list[SweepVariant]:
    """Return every combination of the axes' values.

    Args:
        base: Options that all have in common.
        axes: Each NAME=VALUE,VALUE: a field of a scenario (world, mission, robot, fleet, loss,
            dispatch, ...), method, engine, or a parameter of the navigators.

    Raises:
        ConfigError: If one is malformed, or there are too many combinations.
    """
    found = []
    for label, combination in combinations(axes):
        options = base
        for name, text in combination:
            options = _changed(options, name, text)
        found.append(SweepVariant(label, options))
    return found


def combinations(axes: Sequence[str]) -> list[tuple[str, tuple[tuple[str, str], ...]]]:
    """Return every combination of the axes' values, with a label of those that differ.

    Raises:
        ConfigError: If an axis is malformed, or there are too many combinations.
    """
    choices = [list(_choices(axis)) for axis in axes]
    count = 1
    for values in choices:
        count *= len(values)
    if count > MOST_VARIANTS:
        raise ConfigError(f"--sweep has {count} combinations; expected up to {MOST_VARIANTS}")
    found = []
    for combination in itertools.product(*choices):
        several = [
            f"{name}={text}"
            for (name, text), values in zip(combination, choices, strict=True)
            if len(values) > 1
        ]
        found.append((", ".join(several), combination))
    return found


def _choices(axis: str) -> Iterator[tuple[str, str]]:
    name, equals, text = axis.partition("=")
    values = [value.strip() for value in text.split(",")]
    if not equals or not name or not all(values) or len(set(values)) < len(values):
        raise ConfigError(f"--sweep is '{axis}'; expected NAME=VALUE,VALUE with different values")
    yield from ((name.strip(), value) for value in values)


def _changed(options: RunOptions, name: str, text: str) -> RunOptions:
    """Return options with one thing changed."""
    if name == "method":
        load_method(text)
        return dataclasses.replace(options, method=text)
    if name == "engine":
        if text not in ENGINES:
            raise UnknownNameError("engine", text, ENGINES)
        return dataclasses.replace(options, engine=text)
    value: Any = text
    if name == FLEET:
        value = tuple(text.split("+"))
    elif name in NUMBERS:
        try:
            value = float(text)
        except ValueError:
            raise ConfigError(f"--sweep {name} is '{text}'; expected a number") from None
    elif name == "with_lidar":
        if text not in ("true", "false"):
            raise ConfigError(f"--sweep {name} is '{text}'; expected true or false")
        value = text == "true"
    elif name not in TEXTS:
        found = parameter_of(name, text, (*TEXTS, *NUMBERS, *OTHERS))
        parameters = {**options.parameters, **found}
        return dataclasses.replace(options, parameters=parameters)
    scenario = dataclasses.replace(options.scenario, **{name: value})
    if name in ("world", "mission"):
        scenario = dataclasses.replace(scenario, name=name_of(scenario.world, scenario.mission))
    return dataclasses.replace(options, scenario=scenario)


def parameter_of(name: str, text: str, axes: Sequence[str]) -> dict[str, Any]:
    """Return the parameter that an axis changes, by name.

    Args:
        axes: Names of axes that are no parameters, for the message.

    Raises:
        ConfigError: If there is no such parameter or axis, or the value is wrong.
    """
    name = name.removeprefix(OF_CONTROLLER)
    try:
        return parse_parameters([f"{name}={text}"], "--sweep")
    except UnknownNameError as error:
        if error.name != name:
            raise
        raise UnknownNameError("axis", name, (*axes, *error.known), "--sweep") from None


def name_of(world: str, mission: str) -> str:
    """Return what a run in a world with a mission is called.

    Args:
        world: Name or path, likewise the mission.
    """
    return f"{Path(world).stem}, {Path(mission).stem}"
