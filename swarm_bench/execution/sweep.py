"""Many runs on whatever computes them: each once, its result kept as it comes, with progress."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from swarm_bench.execution import task
from swarm_bench.execution.processes import LocalExecutor
from swarm_bench.execution.store import Result, Store
from swarm_bench.execution.task import Done, Executor
from swarm_bench.runs.inputs import Pack

Item = TypeVar("Item")
Tell = Callable[[float, float], None]  # called with what is done, and with all of it
Watch = Callable[[int, Any], bool]  # gets a run's place and what became of it; False ends all


@dataclass(slots=True, kw_only=True)
class Sweep(Generic[Item, Result]):
    """Runs to be made, and the way to make them; a run without a result stops no other.

    Attributes:
        results: Results so far, those that were kept before first.
        failed: Errors of the runs without a result.
    """

    items: Sequence[Item]  # one per run, in order
    runner: Callable[[Item], Any]  # function of a module
    store: Store[Any]
    key: Callable[[Item], Any]  # of a run
    key_of: Callable[[Result], Any]  # of the run of a result
    line: Callable[[Result], str]  # about a result
    name: Callable[[Item], str] = str  # of a run, before its error
    executor: Executor = field(default_factory=LocalExecutor)
    pack: Callable[[Sequence[Item]], Pack | None] = lambda items: None  # of their inputs
    results: list[Result] = field(default_factory=list)
    failed: list[Any] = field(default_factory=list)

    def known(self) -> tuple[dict[Any, Result], str]:
        """Return the results that the store has of these runs, by key, and a remark or none."""
        keys = {self.key(item) for item in self.items}
        found = self.store.by_key(self.key_of)
        return {key: result for key, result in found.items() if key in keys}, ""

    def run(
        self, console: Console, *, watch: Watch = lambda *_: True, seconds: float = math.inf
    ) -> list[Result]:
        """Make the runs whose results are not kept yet, and return all results.

        Args:
            seconds: Wall time after which no further result is waited for.
        """
        end = time.monotonic() + seconds
        known, remark = self.known()
        told = taken_over(len(known), len(self.items), self.store.path)
        for text in filter(None, (told if known else "", remark)):
            console.print(text, soft_wrap=True, markup=False)
        todo: dict[Any, int] = {}
        for index, item in enumerate(self.items):
            key = self.key(item)
            if key in known:
                self.results.append(known[key])
                watch(index, known[key])
            else:
                todo.setdefault(key, index)
        with contextlib.ExitStack() as stack:
            add = stack.enter_context(self.store.adding())
            ended = stack.enter_context(contextlib.closing(self.ended(list(todo.values()))))
            for index, outcome, line in ended:
                if not isinstance(outcome, str):
                    add(outcome)
                console.print(line, highlight=False, soft_wrap=True, markup=False)
                if not watch(index, outcome) or time.monotonic() >= end:
                    break
        return self.results

    def ended(self, indices: Sequence[int]) -> Generator[tuple[int, Any, str], None, None]:
        """Yield each run when it ends: its place, its result or error, and a line about it."""
        todo = [self.items[index] for index in indices]
        ended = self.executor.run(self.runner, todo, self.pack(todo) if todo else None)
        with contextlib.closing(ended):
            for done in ended:
                yield indices[done.index], *self._outcome(todo[done.index], done)

    def _outcome(self, item: Item, done: Done) -> tuple[Any, str]:
        if done.error:
            self.failed.append(done.error)
            return done.error, f"{self.name(item)}: failed: {done.error}"
        self.results.append(done.value)
        return done.value, self.line(done.value)


def taken_over(count: int, total: int, place: Path | None) -> str:
    """Return what to say of runs that are not repeated, since their results are kept."""
    return (
        f"{count} of {total} runs are in {place} already; "
        "take another file after a change of code or scenario"
    )


@contextlib.contextmanager
def bar(console: Console, what: str, total: float) -> Iterator[Tell]:
    """Show how far something is; a second bar comes when this process compiles kernels.

    Args:
        what: The unit, in the plural.
    """
    if not console.is_terminal:
        yield lambda *_: None
        return
    columns = (
        TextColumn("{task.completed:.0f} of {task.total:.0f} {task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("left:"),
        TimeRemainingColumn(),
        TextColumn("passed:"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console) as progress:
        runs = progress.add_task(what, total=total)
        kernels = progress.add_task("kernels compiled", total=1, visible=False)

        def tell(done: float, total: float) -> None:
            progress.update(runs, completed=done, total=total)
            progress.update(kernels, visible=False)

        def tell_compiling(ready: int, known: int) -> None:
            progress.update(kernels, completed=ready, total=known, visible=True)

        with task.telling(tell_compiling):
            yield tell
