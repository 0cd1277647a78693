"""Results on disk: a file of JSON lines, one per run, so that a killed sweep can continue."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TextIO

from swarm_bench.compose import conditions
from swarm_bench.result import RunResult, result_from_json
from swarm_bench.ros_run import ENGINE as ROS
from swarm_bench.stage import RunOptions
from swarm_common.errors import ConfigError

Key = tuple[Any, ...]


def key_of(result: RunResult) -> Key:
    """Return what tells runs apart."""
    return (
        result.scenario, result.method, result.robots, result.seed, result.engine,
        _flat(result.conditions),
    )  # fmt: skip


def key_of_options(options: RunOptions, *, ros: bool) -> Key:
    """Return the key of the result that these options would give."""
    engine = ROS if ros else options.engine
    return (
        options.scenario.name, options.method, options.robots, options.seed, engine,
        _flat(conditions(options)),
    )  # fmt: skip


def read_results(path: Path) -> list[RunResult]:
    """Return the results in a file; a line that a killed bench left unfinished does not count.

    Raises:
        ConfigError: If the file cannot be read, or a complete line is no result.
    """
    try:
        lines = path.read_text(encoding="utf-8").split("\n")
    except (OSError, UnicodeDecodeError) as cause:
        raise ConfigError(f"cannot read {path}: {cause}") from cause
    results = []
    for number, line in enumerate(lines[:-1], 1):  # what follows the last newline is unfinished
        if not line.strip():
            continue
        try:
            results.append(result_from_json(json.loads(line)))
        except (ValueError, TypeError, KeyError, AttributeError) as cause:
            raise ConfigError(
                f"{path}, line {number} is no result of swarm-bench traffic: {cause}"
            ) from cause
    return results


def open_to_append(path: Path) -> TextIO:
    """Open a result file; an unfinished last line is cut off.

    Raises:
        ConfigError: If it cannot be written.
    """
    try:
        if path.is_file():
            data = path.read_bytes()
            if not data.endswith(b"\n"):
                path.write_bytes(data[: data.rfind(b"\n") + 1])
        return path.open("a", encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {path}: {cause}") from cause


def append(file: TextIO, result: RunResult) -> None:
    """Write one result."""
    file.write(json.dumps(result.as_json(), allow_nan=False) + "\n")
    file.flush()


def missing(options: Iterable[RunOptions], known: Iterable[RunResult], *, ros: bool) -> list[Any]:
    """Return the runs whose results are not known yet."""
    keys = {key_of(result) for result in known}
    return [item for item in options if key_of_options(item, ros=ros) not in keys]


def _flat(values: Any) -> tuple[tuple[str, Any], ...]:
    return tuple(sorted(dict(values).items()))
