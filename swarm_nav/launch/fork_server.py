"""Forks, watches and ends the navigators' processes."""

from __future__ import annotations

import os
import select
import signal
import sys
import time
import traceback
from pathlib import Path
from typing import assert_never

from swarm_common.model.errors import SwarmError
from swarm_common.process.lifetime import die_with, interrupt_nobody
from swarm_common.process.messages import (
    FORK_SERVER,
    EndNavigator,
    ForkServerCommand,
    Go,
    KillNavigator,
    NavigatorDied,
    NavigatorForked,
    Note,
    StartNavigator,
)
from swarm_common.process.pipes import EventWriter, MessageReader
from swarm_common.process.quick_start import thread_count
from swarm_nav.launch.navigator_process import run_navigators
from swarm_nav.launch.process_groups import Group, Grouping

WAIT_SLICE = 0.25  # [s] of wall time between two looks at signals
FORKED_BESIDE = "a navigator was forked beside"  # a fault of ours: it may hang
GRACE = 5.0  # [s] for the children to end when asked to


class ForkServer:
    """Forks, watches and ends the navigators' processes."""

    def __init__(self, events: EventWriter) -> None:
        """Start without children and without a parent that is listened to."""
        self._events = events
        self._children: dict[int, set[str]] = {}  # names of the robots of each
        self._starts: dict[str, str] = {}  # parameter files of robots that are to get one
        self._leaving: set[str] = set()  # robots that are to have no navigator
        self._ending: set[int] = set()  # processes that have been told to end
        self._is_stopping = False
        self._commands: MessageReader[ForkServerCommand] | None = None

    def stop(self) -> None:
        """Make `watch` end the children and return."""
        self._is_stopping = True

    def listen(self, control_fd: int) -> None:
        """Receive commands from a pipe in `watch`.

        Args:
            control_fd: Descriptor to read from; it becomes non-blocking.
        """
        self._commands = MessageReader(control_fd, FORK_SERVER)

    def wait_for_go(self, control_fd: int) -> bool:
        """Wait until the pipe says go; `watch` takes further commands from it.

        Args:
            control_fd: Descriptor to read from; it becomes non-blocking.

        Returns:
            False if the pipe ended before, or `stop` was called.

        Raises:
            UnknownMessageError: If a line is not a known command.
        """
        self._commands = MessageReader(control_fd, FORK_SERVER)
        while not self._is_stopping:
            is_readable = select.select([control_fd], [], [], WAIT_SLICE)[0]
            commands = self._commands.read()
            for command in commands:
                self._obey(command)
            if Go() in commands:
                return True
            if is_readable and not commands:
                return False
        return False

    def fork(self, group: Group, log_dir: Path | None) -> None:
        """Start one process for a group of robots; the child does not return.

        Args:
            log_dir: Folder of the file that gets its output, named after the first robot. None: the
                output goes where that of the fork server goes.
        """
        parent = os.getpid()
        self._leaving -= group.names
        if (threads := thread_count()) > 1:
            sys.stderr.write(f"{FORKED_BESIDE} {threads - 1} other threads\n")
        pid = os.fork()
        if pid:
            self._children[pid] = group.names
            for name in sorted(group.names):
                self._events.write(NavigatorForked(name, pid))
            return
        code = 1
        try:
            die_with(parent)
            interrupt_nobody()
            if log_dir is not None:
                _open_log(log_dir / f"{group.robots[0].name}.log")
            group.enter()
            run_navigators(group.robots, self._events)
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)

    def watch(self, grouping: Grouping) -> None:
        """Report children that die until none is left or `stop` was called.

        The parent that said go may say which robots come and go; then having no children is no
        reason to end.

        Args:
            grouping: Knows how to start those that come.

        Raises:
            UnknownMessageError: If a line from the parent is not a known command.
        """
        while (self._children or self._commands) and not self._is_stopping:
            self._reap()
            for command in self._commands.read() if self._commands else []:
                self._obey(command)
            self._start_waiting(grouping)
            time.sleep(0.1)
        self._end_children()

    def _obey(self, command: ForkServerCommand) -> None:
        match command:
            case Go():  # see `wait_for_go`
                pass
            case StartNavigator(robot=name, params=params):
                self._starts[name] = params
            case KillNavigator(robot=name):
                self._kill(name)
            case EndNavigator(robot=name):
                if self._starts.pop(name, None) is None:
                    self._end(name)
            case _:
                assert_never(command)

    def _start_waiting(self, grouping: Grouping) -> None:
        """Start navigators whose predecessors of the same name have ended."""
        busy = {name for pid in self._ending for name in self._children.get(pid, ())}
        for name in [name for name in self._starts if name not in busy]:
            for names in self._children.values():  # of the pack that the robot has left, see `pack`
                names.discard(name)
            try:
                group = grouping.newcomer(name, self._starts.pop(name))
            except SwarmError as error:
                self._events.write(Note(f"{name} has no navigator: {error}"))
                self._events.write(NavigatorDied(name, 2))
                continue
            self.fork(group, grouping.log_dir)

    def _end(self, name: str) -> None:
        """End the process of a robot, unless others of its pack still need it."""
        self._leaving.add(name)
        for pid, names in self._children.items():
            if name in names and names <= self._leaving:
                self._ending.add(pid)
                os.kill(pid, signal.SIGTERM)

    def _kill(self, name: str) -> None:
        for pid, names in self._children.items():
            if name in names:
                self._ending.add(pid)
                os.kill(pid, signal.SIGKILL)

    def _reap(self) -> None:
        while self._children:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                return
            names = self._children.pop(pid, set())
            self._ending.discard(pid)
            code = os.waitstatus_to_exitcode(status)
            if self._is_stopping:
                continue
            for name in sorted(names):
                if name in self._leaving:
                    self._leaving.discard(name)
                    continue
                self._events.write(NavigatorDied(name, code))

    def _end_children(self) -> None:
        self._is_stopping = True
        for pid in self._children:
            os.kill(pid, signal.SIGTERM)
        end = time.monotonic() + GRACE
        while self._children and time.monotonic() < end:
            self._reap()
            time.sleep(0.02)
        for pid in self._children:
            os.kill(pid, signal.SIGKILL)
        while self._children:
            self._reap()
            time.sleep(0.02)


def _open_log(path: Path) -> None:
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    os.dup2(descriptor, 1)
    os.dup2(descriptor, 2)
    os.close(descriptor)
