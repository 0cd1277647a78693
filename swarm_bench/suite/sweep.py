"""Many runs on whatever computes them, with their results kept on disk."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console

from swarm_bench.execution.processes import LocalExecutor
from swarm_bench.execution.task import Done, Executor
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.fingerprint import gathered, load_inputs
from swarm_bench.runs.harness import run
from swarm_bench.runs.inputs import Gathered, digest_of, packed
from swarm_bench.runs.json_lines import append_json_line, open_to_append, taken_over
from swarm_bench.runs.origin import bench_edition, here
from swarm_bench.runs.result import FailedRun, RunResult
from swarm_bench.runs.result_builder import identity
from swarm_bench.runs.ros_run import ENGINE as ROS
from swarm_bench.runs.ros_run import run_on_graph
from swarm_bench.suite import store
from swarm_bench.suite.table import failure_line, run_line

Runner = Callable[[RunOptions], RunResult]
Outcome = RunResult | FailedRun


@dataclass(slots=True)
class Sweep:
    """Runs to be made, and the way to make them.

    Attributes:
        failed: Runs without a result, so far.
    """

    options: Sequence[RunOptions]  # the runs, in order
    executor: Executor = field(default_factory=LocalExecutor)
    ros: bool = False  # whether on the ROS graph
    runner: Runner = run  # runs one in the bench
    load: Callable[[RunOptions], str] = load_inputs  # reads and checks what one is made from
    # gets the place of each run in `options` and what became of it; False ends the sweep
    watch: Callable[[int, Outcome], bool] = lambda *_: True
    failed: list[FailedRun] = field(default_factory=list)
    _inputs: dict[str, tuple[str, Gathered]] = field(default_factory=dict)

    def check(self) -> None:
        """Check the inputs of all runs before anything runs.

        Raises:
            SwarmError: For the first thing that is wrong.
        """
        for item in self.options:
            self._inputs_of(item)

    def run(
        self, file: Path | None, console: Console, results: list[RunResult] | None = None
    ) -> list[RunResult]:
        """Run the jobs that are not in a result file yet, add their results to it, and return all.

        Args:
            file: File of JSON lines; None to keep nothing.
            results: List to which the results are added as they come; None: a new list.
        """
        results = [] if results is None else results
        fulls = [self._full_key(item) for item in self.options]
        known, others = store.known_of(file, dict(zip(fulls, self.options, strict=True)))
        if known:
            console.print(taken_over(len(known), len(fulls), file), soft_wrap=True, markup=False)
        if others:
            console.print(
                f"{others} results in {file} are of other inputs or another edition, "
                "and are not used", soft_wrap=True, markup=False,
            )  # fmt: skip
        missing = store.missing(fulls, known)
        for index, full in enumerate(fulls):
            if full in known:
                results.append(known[full])
                self.watch(index, known[full])
        with contextlib.ExitStack() as stack:
            output = stack.enter_context(open_to_append(file)) if file is not None else None
            ended = stack.enter_context(contextlib.closing(self._ended(missing)))
            for index, outcome in ended:
                if output is not None:
                    append_json_line(output, outcome.as_json())
                if isinstance(outcome, RunResult):
                    results.append(outcome)
                    line = run_line(outcome)
                else:
                    line = failure_line(outcome)
                console.print(line, highlight=False, soft_wrap=True, markup=False)
                if not self.watch(index, outcome):
                    break
        return results

    def outcomes(self) -> Iterator[Outcome]:
        """Yield what becomes of each run when it ends; those that fail go to `failed`, too."""
        yield from (outcome for _, outcome in self._ended(range(len(self.options))))

    def _ended(self, indices: Sequence[int]) -> Generator[tuple[int, Outcome], None, None]:
        todo = [self.options[index] for index in indices]
        inputs = [self._inputs_of(item) for item in todo]
        pack = packed(found for _, found in inputs) if todo else None
        runner = run_on_graph if self.ros else self.runner
        with contextlib.closing(self.executor.run(runner, todo, pack)) as ended:
            for done in ended:
                outcome = self._outcome(todo[done.index], inputs[done.index][0], done)
                if isinstance(outcome, FailedRun):
                    self.failed.append(outcome)
                yield indices[done.index], outcome

    def _outcome(self, options: RunOptions, inputs: str, done: Done) -> Outcome:
        origin = dataclasses.replace(done.origin or here(), inputs=inputs)
        if done.error:
            named = identity(options) | ({"engine": ROS} if self.ros else {})
            return FailedRun(**named, error=done.error, origin=origin, refused=done.is_refused)
        result: RunResult = dataclasses.replace(done.value, origin=origin)
        return result

    def _full_key(self, options: RunOptions) -> store.Full:
        inputs, _ = self._inputs_of(options)
        return store.key_of_options(options, ros=self.ros), inputs, bench_edition()

    def _inputs_of(self, options: RunOptions) -> tuple[str, Gathered]:
        """Return the hash of a run's inputs and the inputs, which are those of all its seeds."""
        name = digest_of(dataclasses.replace(options, seed=0))
        if name not in self._inputs:
            self._inputs[name] = gathered(options, self.load)
        return self._inputs[name]
