"""One run in whatever process computes it: a result, or why there is none."""

from __future__ import annotations

import functools
import sys
import threading
import traceback
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from swarm_bench.runs.inputs import Pack, install
from swarm_bench.runs.origin import here
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.process import start
from swarm_common.process.compile_watch import watched
from swarm_run.record.run_record import ResultOrigin

Runner = Callable[[Any], Any]
KERNELS = ("swarm_bench", "swarm_central", "swarm_common", "swarm_nav", "swarm_sim")
MOST_TRIES = 3  # of a run whose process dies
DIED = f"its process died {MOST_TRIES} times: killed, or out of memory"
_alone = threading.Lock()  # the inputs of a process are those of one run at a time


@dataclass(frozen=True, slots=True)
class Done:
    """A run that has ended."""

    index: int  # of its item
    value: Any = None  # what the runner returned
    origin: ResultOrigin | None = None  # without the inputs' hash; None where no process survived
    error: str = ""  # why there is no value
    is_refused: bool = False  # whether the error is one of the user's input


Runs = Generator[Done, None, None]  # to be closed by who leaves it early


class Executor(Protocol):
    """Computes runs; `swarm_bench.execution.executor.make_executor` makes one."""

    def run(self, runner: Runner, items: Sequence[Any], pack: Pack | None) -> Runs:
        """Yield each run when it ends.

        Args:
            runner: Function of a module; it gets one item.
            items: One item per run; pickle must be able to keep it.
            pack: Everything that they are made from; None: processes read files themselves.
        """

    def close(self) -> None:
        """End the processes that this executor started, whatever they do."""


def execute(runner: Runner, index: int, item: Any, pack: Pack | None = None) -> Done:
    """Compute a run in this process, with the inputs of a pack if there is one."""
    start.prepare()  # also in a worker process
    with _alone, watched(lambda ready, known: _tell[-1](ready, known), packages=KERNELS):
        try:
            if pack is not None:
                install(pack)
            return Done(index, runner(item), here())
        except SwarmError as error:
            is_refused = isinstance(error, ConfigError)
            return Done(index, None, here(), str(error), is_refused=is_refused)
        except Exception as error:  # a fault of a method or of ours stops no other run
            last = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(last.filename).name}, line {last.lineno}"
            return Done(index, None, here(), f"{type(error).__name__}: {error} ({place})")


@functools.cache  # once per process
def _say_compiling() -> None:
    sys.stderr.write("compiling kernels, once: a minute or two\n")
    sys.stderr.flush()


_tell: list[Callable[[int, int], None]] = [lambda *_: _say_compiling()]  # the last one hears


@contextmanager
def telling(tell: Callable[[int, int], None]) -> Iterator[None]:
    """Tell how many kernels of how many are compiled in this process, in place of one line."""
    _tell.append(tell)
    try:
        yield
    finally:
        _tell.pop()
