"""Results on disk: a file of JSON lines, one per run, so that a killed sweep can continue."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.json_lines import numbered_json_lines
from swarm_bench.runs.origin import ResultOrigin
from swarm_bench.runs.result import FailedRun, RunResult, line_from_json
from swarm_bench.runs.result_builder import conditions
from swarm_bench.runs.ros_run import ENGINE as ROS
from swarm_common.model.errors import ConfigError

Key = tuple[Any, ...]
Full = tuple[Key, str, str]  # key, hash of the inputs, edition
# What the machine decides, and not the run.
OF_MACHINE = ("wall_time", "tick_us_median", "tick_us_p99", "cpu_ms_per_robot_second", "origin")


@dataclass(frozen=True, slots=True)
class Line:
    """A result and where it stands."""

    place: str  # file and line
    result: RunResult

    @property
    def origin(self) -> ResultOrigin | None:
        """Where the result comes from; None in older files."""
        return self.result.origin

    @property
    def full_key(self) -> Full:
        """Full key of the run: its key, hash of the inputs and edition."""
        origin = self.origin
        inputs, edition = ("", "") if origin is None else (origin.inputs, origin.edition)
        return key_of(self.result), inputs, edition

    def __str__(self) -> str:
        """Return its place, and the machine."""
        origin = self.origin
        return self.place if origin is None else f"{self.place} ({origin.host}, {origin.processor})"


def key_of(result: RunResult | FailedRun) -> Key:
    """Return what tells runs apart."""
    return (
        result.scenario, result.method, result.robots, result.seed, result.engine,
        _flat(result.conditions),
    )  # fmt: skip


def key_of_options(options: RunOptions, *, ros: bool) -> Key:
    """Return the key of the result that these options would give.

    Args:
        ros: Whether it is on the ROS graph, where the engine is not told apart.
    """
    engine = ROS if ros else options.engine
    return (
        options.scenario.name, options.method, options.robots, options.seed, engine,
        _flat(conditions(options)),
    )  # fmt: skip


def read_lines(path: Path) -> list[Line]:
    """Return the results in a file, also those that occur twice; failed runs are left out.

    Raises:
        ConfigError: If the file cannot be read, or a complete line is not a result.
    """
    return [
        Line(f"{path}, line {number}", line)
        for number, line in numbered_json_lines(path, line_from_json, "swarm-bench traffic")
        if isinstance(line, RunResult)
    ]


def read_results(*paths: Path) -> list[RunResult]:
    """Return the results in files, each run once.

    Raises:
        ConfigError: If a file cannot be read, a complete line is not a result, or two lines tell
            different things of one run, or are of different inputs.
    """
    lines = [line for path in paths for line in read_lines(path)]
    kept = list(once(lines).values())
    by_key: dict[Key, Line] = {}
    for line in kept:
        first = by_key.setdefault(key_of(line.result), line)
        if first is not line and first.full_key[1] != line.full_key[1]:
            raise ConfigError(
                f"{first} and {line} have the same name, {_name(line.result)}, but different "
                "inputs; keep results of other inputs in other files"
            )
    return [line.result for line in by_key.values()]


def once(lines: Iterable[Line]) -> dict[Full, Line]:
    """Return lines by key, inputs and edition; those that occur twice once.

    Raises:
        ConfigError: If two lines under one key differ in more than what machines decide.
    """
    kept: dict[Full, Line] = {}
    for line in lines:
        first = kept.setdefault(line.full_key, line)
        names = _differences(first.result, line.result)
        if names:
            raise ConfigError(
                f"{first} and {line} differ in {', '.join(names[:3])} of one run, "
                f"{_name(line.result)}; delete the wrong one"
            )
    return kept


def known_of(
    path: Path | None, wanted: Mapping[Full, RunOptions]
) -> tuple[dict[Full, RunResult], int]:
    """Return the results in a file that are of the wanted runs.

    The number is of results that have the name of such a run, but are of other inputs.

    Args:
        path: A file need not be there; None for no results.
        wanted: Runs by key, hash of the inputs and edition.

    Raises:
        ConfigError: If a file cannot be read, as in `once`.
    """
    if path is None or not path.is_file():
        return {}, 0
    lines = once(read_lines(path))
    names = {key for key, _, _ in wanted}
    others = sum(full not in wanted and full[0] in names for full in lines)
    return {full: line.result for full, line in lines.items() if full in wanted}, others


def _differences(first: RunResult, other: RunResult) -> list[str]:
    """Return the fields in which two results of one run differ."""
    if first is other:
        return []
    names = [item.name for item in dataclasses.fields(RunResult) if item.name not in OF_MACHINE]
    return [name for name in names if getattr(first, name) != getattr(other, name)]


def _name(result: RunResult) -> str:
    return f"{result.scenario} {result.method} {result.robots} robots seed {result.seed}"


def _flat(values: Any) -> tuple[tuple[str, Any], ...]:
    return tuple(sorted(dict(values).items()))


def missing(fulls: Sequence[Full], known: Iterable[Full]) -> list[int]:
    """Return the places of the runs whose results are not known, each run once.

    Args:
        fulls: Key, hash of the inputs and edition of each run.
    """
    seen, todo = set(known), []
    for index, full in enumerate(fulls):
        if full not in seen:
            seen.add(full)
            todo.append(index)
    return todo
