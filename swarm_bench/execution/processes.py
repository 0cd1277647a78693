"""The processes of this machine, each with a pipe; a run whose process dies is repeated."""

from __future__ import annotations

import os
import signal
from collections import deque
from collections.abc import Sequence
from multiprocessing import connection, get_context
from typing import Any

from swarm_bench.execution.task import DIED, MOST_TRIES, Done, Runner, Runs, execute
from swarm_bench.runs.inputs import Pack
from swarm_common.process.lifetime import die_with

MOST_RUNS = 100  # of a process, which then makes room for a new one: caches and leaks stay small
_CONTEXT = get_context("spawn")  # the threads of numba and pybullet do not survive a fork


class LocalExecutor:
    """Computes runs in processes of this machine, or in this process if it is one at a time."""

    def __init__(self, jobs: int = 1, *, apart: bool = False) -> None:
        """Set up; processes are started with the first runs.

        Args:
            jobs: Number of processes; with 1 none is started.
            apart: Whether also a single one is started, so that no run can end this process.
        """
        self._jobs, self._apart = jobs, apart
        self._workers: list[_Worker] = []

    def run(self, runner: Runner, items: Sequence[Any], pack: Pack | None) -> Runs:
        """Yield each run when it ends; see `Executor`."""
        is_alone = self._jobs == 1 or (len(items) == 1 and not self._workers)
        if is_alone and not self._apart:
            for index, item in enumerate(items):
                yield execute(runner, index, item)
            return
        waiting = deque(range(len(items)))
        tries = [0] * len(items)
        under_way: dict[connection.Connection, tuple[_Worker, int]] = {}
        try:
            while waiting or under_way:
                busy = [worker for worker, _ in under_way.values()]
                for worker in self._idle(busy, len(waiting)):
                    index = waiting.popleft()
                    tries[index] += 1
                    worker.send(runner, index, items[index], pack)
                    under_way[worker.pipe] = (worker, index)
                ready = connection.wait(list(under_way))
                for pipe in [pipe for pipe in under_way if pipe in ready]:
                    worker, index = under_way.pop(pipe)
                    done = worker.receive()
                    if done is None or worker.runs == MOST_RUNS:
                        self._workers.remove(worker)
                        worker.kill()
                    if done is not None:
                        yield done
                        continue
                    if tries[index] < MOST_TRIES:
                        waiting.append(index)
                    else:
                        yield Done(index, error=DIED)
        finally:
            for worker, _ in under_way.values():  # interrupted: nobody waits for these any more
                self._workers.remove(worker)
                worker.kill()

    def close(self) -> None:
        """End the processes; see `Executor`."""
        while self._workers:
            self._workers.pop().kill()

    def _idle(self, busy: Sequence[_Worker], needed: int) -> list[_Worker]:
        """Return workers for as many runs as are needed, or as there are."""
        idle = [worker for worker in self._workers if worker not in busy][:needed]
        while len(idle) < needed and len(self._workers) < self._jobs:
            worker = _Worker()
            self._workers.append(worker)
            idle.append(worker)
        return idle


class _Worker:
    """A process and our end of its pipe."""

    def __init__(self) -> None:
        self.pipe, theirs = _CONTEXT.Pipe()
        self._process = _CONTEXT.Process(target=_serve, args=(theirs, os.getpid()), daemon=True)
        self._process.start()
        theirs.close()
        self._has = ""  # hash of the inputs that were sent
        self.runs = 0  # that were sent

    def send(self, runner: Runner, index: int, item: Any, pack: Pack | None) -> None:
        self.runs += 1
        is_new = pack is not None and pack.digest != self._has
        try:
            self.pipe.send((runner, index, item, pack if is_new else None))
        except (BrokenPipeError, ConnectionResetError):
            return  # it is dead, and `receive` says so
        if pack is not None:
            self._has = pack.digest

    def receive(self) -> Done | None:
        """Return what came; None if the process is dead."""
        try:
            done: Done = self.pipe.recv()
            return done
        except (EOFError, ConnectionResetError):
            return None

    def kill(self) -> None:
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _serve(pipe: connection.Connection, parent: int) -> None:
    """Compute runs until the other end of the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent, which ends this one
    die_with(parent)
    while True:
        try:
            runner, index, item, pack = pipe.recv()
        except EOFError:
            return
        pipe.send(execute(runner, index, item, pack))
