"""Table of the processes of a run: which run, which have ended, and the order of stopping."""

from __future__ import annotations

import signal
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol


class Child(Protocol):
    """A started process."""

    @property
    def pid(self) -> int:
        """Process id."""

    def poll(self) -> int | None:
        """Return the return code (negative: the signal), or None while it runs."""

    def terminate(self) -> None:
        """Ask the process to end; harmless if it has ended already."""

    def kill(self) -> None:
        """End it and all of its own children; harmless if it has ended."""


@dataclass(frozen=True, slots=True)
class ProcessSpec:
    """One line of the table."""

    name: str  # for messages and the log file
    argv: tuple[str, ...]  # command
    grace: float = 5.0  # [s] of wall time to end in when asked to, before it is killed


class ChildState(Enum):
    """State of a process."""

    RUNNING = "running"
    STOPPING = "stopping"
    KILLED = "killed"
    GONE = "gone"


class ChildEvent(Enum):
    """Event in the life of a process."""

    STOP = "stop"
    DEADLINE = "deadline"
    EXIT = "exit"


TRANSITIONS: dict[ChildState, dict[ChildEvent, ChildState]] = {
    ChildState.RUNNING: {ChildEvent.STOP: ChildState.STOPPING, ChildEvent.EXIT: ChildState.GONE},
    ChildState.STOPPING: {
        ChildEvent.STOP: ChildState.STOPPING,
        ChildEvent.DEADLINE: ChildState.KILLED,
        ChildEvent.EXIT: ChildState.GONE,
    },
    ChildState.KILLED: {
        ChildEvent.STOP: ChildState.KILLED,
        ChildEvent.DEADLINE: ChildState.KILLED,
        ChildEvent.EXIT: ChildState.GONE,
    },
    ChildState.GONE: {ChildEvent.STOP: ChildState.GONE},
}


@dataclass(frozen=True, slots=True)
class Exit:
    """A process has ended; `expected` if it had been asked to, `killed` if it then did not."""

    name: str
    returncode: int
    expected: bool
    killed: bool = False


@dataclass(slots=True)
class _Entry:
    spec: ProcessSpec
    child: Child
    state: ChildState = ChildState.RUNNING
    deadline: float = 0.0

    def enter(self, event: ChildEvent) -> ChildState:
        self.state = TRANSITIONS[self.state][event]
        return self.state


class Supervisor:
    """Starts processes, notices their end, stops them one after the other.

    It never waits: `poll` does the due work and returns the events.

    Attributes:
        restarts: Number of processes started in the place of one that had ended.
    """

    def __init__(self, spawn: Callable[[ProcessSpec], Child], clock: Callable[[], float]) -> None:
        """Begin without processes.

        Args:
            clock: Wall time [s].
        """
        self.restarts = 0
        self._spawn = spawn
        self._clock = clock
        self._entries: dict[str, _Entry] = {}
        self._stop_order: list[str] = []

    def start(self, spec: ProcessSpec) -> None:
        """Start a process, or start it again if it has ended.

        Raises:
            ValueError: If one of that name still runs.
        """
        before = self._entries.get(spec.name)
        if before is not None and before.state is not ChildState.GONE:
            raise ValueError(f"process {spec.name} has been started before and still runs")
        self.restarts += before is not None
        self._entries[spec.name] = _Entry(spec, self._spawn(spec))

    def pid(self, name: str) -> int | None:
        """Return the id of a process that runs, else None."""
        entry = self._entries.get(name)
        return entry.child.pid if entry and entry.state is not ChildState.GONE else None

    @property
    def all_gone(self) -> bool:
        """Whether no process is left."""
        return all(entry.state is ChildState.GONE for entry in self._entries.values())

    def stop(self, order: Sequence[str]) -> None:
        """Begin to stop everything: the named first, each after the one before has ended.

        Args:
            order: Names to begin with; unknown ones are ignored.
        """
        rest = [name for name in self._entries if name not in order]
        self._stop_order = [name for name in order if name in self._entries] + rest

    def kill(self) -> None:
        """End everything at once."""
        for entry in self._entries.values():
            if entry.state is not ChildState.GONE:
                entry.enter(ChildEvent.STOP)
                entry.enter(ChildEvent.DEADLINE)
                entry.child.kill()

    def kill_one(self, name: str) -> None:
        """End a process that hangs; it counts as one that ended without having been asked to."""
        entry = self._entries.get(name)
        if entry is not None and entry.state is not ChildState.GONE:
            entry.child.kill()

    def poll(self) -> list[Exit]:
        """Notice ended processes and go on stopping; return those that ended since last time."""
        exits = []
        for entry in self._entries.values():
            if entry.state is ChildState.GONE:
                continue
            returncode = entry.child.poll()
            if returncode is not None:
                is_expected = entry.state is not ChildState.RUNNING
                is_killed = entry.state is ChildState.KILLED
                exits.append(Exit(entry.spec.name, returncode, is_expected, is_killed))
                entry.enter(ChildEvent.EXIT)
                entry.child.kill()  # processes that it may have left behind
        self._continue_stopping()
        return exits

    def _continue_stopping(self) -> None:
        for name in self._stop_order:
            entry = self._entries[name]
            if entry.state is ChildState.GONE:
                continue
            if entry.state is ChildState.RUNNING:
                entry.enter(ChildEvent.STOP)
                entry.deadline = self._clock() + entry.spec.grace
                entry.child.terminate()
            elif self._clock() >= entry.deadline and entry.state is ChildState.STOPPING:
                entry.enter(ChildEvent.DEADLINE)
                entry.child.kill()
            return


def describe_exit(returncode: int) -> str:
    """Return a return code in words.

    Args:
        returncode: Negative: the signal that killed the process.
    """
    if returncode == -signal.SIGBUS:  # memory of a file for which there is no room any more
        return "killed by SIGBUS: /dev/shm or the disk is full (see df -h /dev/shm)"
    if returncode < 0:
        return f"killed by {signal.Signals(-returncode).name}"
    return f"exit code {returncode}"
