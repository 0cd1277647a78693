"""A hash of everything that a run is made from, and the same on its way to other processes."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterator
from pathlib import Path

from swarm_bench.runs.episode import RunOptions, check, prepare, specs_of
from swarm_bench.runs.inputs import Gathered, digest_of, gather

PLUGIN = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")  # module:Class
# Fields of a scenario whose content is hashed, or that decide nothing in one run.
NOT_HASHED = (
    "name", "description", "world", "mission", "robots", "robot", "fleet", "seeds", "targets",
    "time_limit",
)  # fmt: skip


def gathered(options: RunOptions, load: Callable[[RunOptions], str]) -> tuple[str, Gathered]:
    """Return the hash of all inputs of a run but its seed, and the inputs.

    Args:
        load: Loads what the run reads and returns who gives orders, like `load_inputs`.

    Raises:
        SwarmError: If an input is unusable.
    """
    found = gather(lambda: load(options), lambda dispatch: plugins_of(options, dispatch))
    scenario = options.scenario
    plain = {
        field.name: getattr(scenario, field.name)
        for field in dataclasses.fields(scenario)
        if field.name not in NOT_HASHED
    }
    rest = (
        plain, scenario.limit_of(options.robots), specs_of(options), options.robots, options.method,
        options.engine, options.realistic, sorted(options.parameters.items()),
    )  # fmt: skip
    solver = options.central.get("solver", "")
    programs = [Path(solver).read_bytes()] if solver else []
    return digest_of((found.digest, rest, *programs)), found


def load_inputs(options: RunOptions) -> str:
    """Check a run, and read all that it will read.

    Returns:
        Who gives orders; empty without orders.
    """
    check(options)
    _, mission = prepare(options)
    return mission.orders.dispatch if mission is not None and mission.orders is not None else ""


def plugins_of(options: RunOptions, dispatch: str) -> Iterator[str]:
    """Yield the names module:Class in a run's method, parameters and scenario, and `dispatch`."""
    values = [options.method, *options.parameters.values(), dispatch]
    values += [
        getattr(options.scenario, field.name) for field in dataclasses.fields(options.scenario)
    ]
    for value in values:
        if isinstance(value, str) and PLUGIN.fullmatch(value):
            yield value
