"""Sweeps of the bench and of the ROS graph: which runs are the same, and their results on disk."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from swarm_bench.execution.processes import LocalExecutor
from swarm_bench.execution.store import Store
from swarm_bench.execution.sweep import Sweep
from swarm_bench.execution.task import Done, Executor
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.fingerprint import gathered, load_inputs
from swarm_bench.runs.harness import run
from swarm_bench.runs.inputs import Gathered, Pack, digest_of, packed
from swarm_bench.runs.origin import bench_edition, here
from swarm_bench.runs.result import FailedRun, line_from_json
from swarm_bench.runs.result_builder import conditions, identity
from swarm_bench.runs.ros_run import ENGINE as ROS
from swarm_bench.runs.ros_run import run_on_graph
from swarm_bench.suite.table import failure_line, run_line
from swarm_common.model.errors import ConfigError
from swarm_run.record.run_record import RunRecord

Outcome = RunRecord | FailedRun
Runner = Callable[[RunOptions], RunRecord]
Key = tuple[Any, ...]
Full = tuple[Key, str, str]  # key, hash of the inputs, edition
Line = tuple[str, RunRecord]  # its place and the result
COMMAND = "swarm-bench traffic"
# What the machine decides, and not the run.
OF_MACHINE = ("wall_time", "tick_us_median", "tick_us_p99", "cpu_ms_per_robot_second", "origin")


def key_of(result: Outcome) -> Key:
    """Return what tells runs apart."""
    return (
        result.scenario,
        result.method,
        result.robots,
        result.seed,
        result.engine,
        tuple(sorted(result.conditions.items())),
    )


def key_of_options(options: RunOptions, *, ros: bool) -> Key:
    """Return the key of the result that these options would give.

    Args:
        ros: Whether it is on the ROS graph, where the engine is not told apart.
    """
    engine = ROS if ros else options.engine
    return (
        options.scenario.name,
        options.method,
        options.robots,
        options.seed,
        engine,
        tuple(sorted(conditions(options).items())),
    )


def full_key_of(result: Outcome) -> Full:
    """Return key, hash of the inputs and edition; older files have only the key."""
    origin = result.origin
    return key_of(result), origin.inputs if origin else "", origin.edition if origin else ""


class RunSweep(Sweep[RunOptions, RunRecord]):
    """Runs of the bench or on the ROS graph; `failed` has those without a result."""

    def __init__(
        self,
        options: Sequence[RunOptions],
        file: Path | None = None,
        executor: Executor | None = None,
        *,
        ros: bool = False,
        runner: Runner = run,
        load: Callable[[RunOptions], str] = load_inputs,
        any_code: bool = False,
    ) -> None:
        """Set up; nothing is read yet.

        Args:
            options: Runs in the order in which they are made.
            file: File of JSON lines; None to keep nothing.
            executor: Where they are computed; None for this process.
            ros: Whether on the ROS graph.
            runner: Runs one in the bench.
            load: Reads and checks what one is made from.
            any_code: Whether results by other code and of other inputs count, too.
        """
        super().__init__(
            items=options,
            runner=run_on_graph if ros else runner,
            store=Store(file, line_from_json, COMMAND),
            key=partial(key_of_options, ros=ros) if any_code else self._full_key,
            key_of=key_of if any_code else full_key_of,
            line=run_line,
            executor=executor or LocalExecutor(),
            pack=self._pack,
        )
        self._ros, self._load, self._any_code = ros, load, any_code
        self._inputs: dict[str, tuple[str, Gathered]] = {}

    def check(self) -> None:
        """Check the inputs of all runs before anything runs.

        Raises:
            SwarmError: For the first thing that is wrong.
        """
        for item in self.items:
            self._inputs_of(item)

    def known(self) -> tuple[dict[Any, RunRecord], str]:
        """Return the results that the file has of these runs, and a remark about others."""
        if self._any_code:
            found, told = super().known()
            return {key: line for key, line in found.items() if isinstance(line, RunRecord)}, told
        wanted = {self._full_key(item) for item in self.items}
        names = {key for key, _, _ in wanted}
        lines = once(lines_of(self.store))
        known: dict[Any, RunRecord] = {}
        others = 0
        for full, (_, result) in lines.items():
            if full in wanted:
                known[full] = result
            else:
                others += full[0] in names
        told = (
            f"{others} results in {self.store.path} are of other inputs or another edition, "
            "and are not used"
        )
        return known, told if others else ""

    def _outcome(self, item: RunOptions, done: Done) -> tuple[Any, str]:
        origin = replace(done.origin or here(), inputs=self._inputs_of(item)[0])
        if done.error:
            named = identity(item) | ({"engine": ROS} if self._ros else {})
            failed = FailedRun(**named, error=done.error, origin=origin, refused=done.is_refused)
            self.failed.append(failed)
            return failed, failure_line(failed)
        result: RunRecord = replace(done.value, origin=origin)
        self.results.append(result)
        return result, run_line(result)

    def _full_key(self, options: RunOptions) -> Full:
        inputs, _ = self._inputs_of(options)
        return key_of_options(options, ros=self._ros), inputs, bench_edition()

    def _pack(self, items: Sequence[RunOptions]) -> Pack:
        return packed(self._inputs_of(item)[1] for item in items)

    def _inputs_of(self, options: RunOptions) -> tuple[str, Gathered]:
        """Return the hash of a run's inputs and the inputs, which are those of all its seeds."""
        name = digest_of(dataclasses.replace(options, seed=0))
        if name not in self._inputs:
            self._inputs[name] = gathered(options, self._load)
        return self._inputs[name]


def lines_of(store: Store[Outcome]) -> list[Line]:
    """Return the results in a store with their places, also those that occur twice."""
    return [(place, line) for place, line in store.read() if isinstance(line, RunRecord)]


def once(lines: Iterable[Line]) -> dict[Full, Line]:
    """Return lines by key, inputs and edition; those that occur twice once.

    Raises:
        ConfigError: If two lines under one key differ in more than what machines decide.
    """
    kept: dict[Full, Line] = {}
    for line in lines:
        first = kept.setdefault(full_key_of(line[1]), line)
        names = [
            name
            for name in RunRecord.__struct_fields__
            if name not in OF_MACHINE and getattr(first[1], name) != getattr(line[1], name)
        ]
        if names:
            raise ConfigError(
                f"{_place(first)} and {_place(line)} differ in {', '.join(names[:3])} of one run, "
                f"{_name(line)}; delete the wrong one"
            )
    return kept


def read_results(*paths: Path) -> list[RunRecord]:
    """Return the results in files, each run once.

    Raises:
        ConfigError: If a file cannot be read, a complete line is not a result, or two lines tell
            different things of one run, or are of different inputs.
    """
    for path in paths:
        if not path.exists():
            raise ConfigError(f"cannot read {path}: there is no such file")
    lines = [line for path in paths for line in lines_of(Store(path, line_from_json, COMMAND))]
    by_key: dict[Key, Line] = {}
    for full, line in once(lines).items():
        first = by_key.setdefault(full[0], line)
        if full_key_of(first[1])[1] != full[1]:
            raise ConfigError(
                f"{_place(first)} and {_place(line)} have the same name, {_name(line)}, but "
                "different inputs; keep results of other inputs in other files"
            )
    return [result for _, result in by_key.values()]


def _place(line: Line) -> str:
    place, origin = line[0], line[1].origin
    return place if origin is None else f"{place} ({origin.host}, {origin.processor})"


def _name(line: Line) -> str:
    result = line[1]
    return f"{result.scenario} {result.method} {result.robots} robots seed {result.seed}"
