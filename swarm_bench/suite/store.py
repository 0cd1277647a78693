"""Results on disk: a file of JSON lines, one per run, so that a killed sweep can continue."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.json_lines import read_json_lines
from swarm_bench.runs.result import RunResult, result_from_json
from swarm_bench.runs.result_builder import conditions
from swarm_bench.runs.ros_run import ENGINE as ROS

Key = tuple[Any, ...]


def key_of(result: RunResult) -> Key:
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


def read_results(path: Path) -> list[RunResult]:
    """Return the results in a file; see `read_json_lines`.

    Raises:
        ConfigError: If the file cannot be read, or a complete line is not a result.
    """
    return read_json_lines(path, result_from_json, "swarm-bench traffic")


def missing(options: Iterable[RunOptions], known: Iterable[RunResult], *, ros: bool) -> list[Any]:
    """Return the runs whose results are not known yet.

    Args:
        ros: Whether they are on the ROS graph.

    Returns:
        Those of `options`, in their order.
    """
    keys = {key_of(result) for result in known}
    return [item for item in options if key_of_options(item, ros=ros) not in keys]


def _flat(values: Any) -> tuple[tuple[str, Any], ...]:
    return tuple(sorted(dict(values).items()))
