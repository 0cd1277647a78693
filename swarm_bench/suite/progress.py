"""Bars with an estimate for runs and for compiling, on a terminal only."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

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

Tell = Callable[[float, float], None]  # called with what is done, and with all of it


@contextmanager
def bar(console: Console, what: str, total: float) -> Iterator[Tell]:
    """Show how far something is; a second bar comes when this process compiles kernels.

    Args:
        what: The unit, in the plural.
    """
    if not console.is_terminal:
        yield lambda *_: None
        return
    columns = (
        TextColumn("{task.completed:.0f} of {task.total:.0f} {task.description}"), BarColumn(),
        TaskProgressColumn(), TextColumn("left:"), TimeRemainingColumn(),
        TextColumn("passed:"), TimeElapsedColumn(),
    )  # fmt: skip
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
