"""Starts a child process with its log and two pipes, so that it never outlives us."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Mapping
from pathlib import Path

from swarm_commander.run.processes.supervisor import ProcessSpec
from swarm_common.process.lifetime import die_with
from swarm_common.process.messages import EVENTS, CommandBase, Event, encode
from swarm_common.process.pipes import MessageReader


class ProcessChild:
    """A process in a session of its own, with a pipe for its events and one for commands to it.

    The child gets ``--event-fd N --control-fd M`` appended to its command line; both carry
    messages, see `messages`. It is killed by the kernel when this process dies.
    """

    def __init__(self, spec: ProcessSpec, log: Path, environment: Mapping[str, str]) -> None:
        """Start the process.

        Args:
            spec: Its command; the flags of the pipes are appended.
            log: File that its output is appended to.
            environment: All that it gets; nothing is inherited.

        Raises:
            OSError: If it cannot be started, or the log not be written.
        """
        self.event_fd, child_event = os.pipe()
        child_control, self._control_fd = os.pipe()
        os.set_blocking(self._control_fd, False)
        self._events = MessageReader(self.event_fd, EVENTS)
        flags = ("--event-fd", str(child_event), "--control-fd", str(child_control))
        parent = os.getpid()
        try:
            with log.open("ab") as output:
                self._process = subprocess.Popen(
                    (*spec.argv, *flags),
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    pass_fds=(child_event, child_control),
                    start_new_session=True,
                    env=dict(environment),
                    preexec_fn=lambda: die_with(parent),
                )
        except BlockingIOError as error:
            why = "this user may have no more processes (ulimit -u)"
            raise OSError(error.errno, f"cannot start {spec.name}: {why}") from None
        finally:
            os.close(child_event)
            os.close(child_control)

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    def poll(self) -> int | None:
        """Return the return code, or None while it runs."""
        return self._process.poll()

    def terminate(self) -> None:
        """Ask the process to end."""
        with contextlib.suppress(ProcessLookupError):
            self._process.terminate()

    def kill(self) -> None:
        """End it and its process group."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)

    def tell(self, command: CommandBase) -> None:
        """Send it a command; a process that has ended or does not listen misses it.

        Args:
            command: Written at once, or dropped if the pipe is full.
        """
        with contextlib.suppress(BrokenPipeError, BlockingIOError):
            os.write(self._control_fd, encode(command))

    def read_events(self) -> list[Event]:
        """Return the events that have arrived.

        Raises:
            UnknownMessageError: If it reports something that is not an event.
        """
        return self._events.read()

    def close(self) -> None:
        """Close the pipes."""
        for descriptor in (self.event_fd, self._control_fd):
            with contextlib.suppress(OSError):
                os.close(descriptor)
