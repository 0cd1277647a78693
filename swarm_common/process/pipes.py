"""Pipes between swarm-up and its processes; one message per line, see `messages`."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import sys
from pathlib import Path
from typing import Any, Generic, NoReturn

import msgspec

from swarm_common.process.messages import Event, Kind, Refused, decode, encode


class MessageReader(Generic[Kind]):
    """Reader of messages that never waits."""

    def __init__(self, descriptor: int, decoder: msgspec.json.Decoder[Kind]) -> None:
        """Switch the descriptor to non-blocking."""
        os.set_blocking(descriptor, False)
        self._descriptor = descriptor
        self._decoder = decoder
        self._partial = b""

    def read(self) -> list[Kind]:
        """Return the messages that have arrived; a line that is not whole yet waits."""
        with contextlib.suppress(BlockingIOError):
            while chunk := os.read(self._descriptor, 65536):
                self._partial += chunk
        *lines, self._partial = self._partial.split(b"\n")
        return [decode(line, self._decoder) for line in lines if line.strip()]


class EventWriter:
    """Writer of events; without a descriptor it writes nothing."""

    def __init__(self, descriptor: int | None) -> None:
        """Start to write.

        Args:
            descriptor: Descriptor of the pipe; None for none.
        """
        self._descriptor = descriptor

    def write(self, event: Event) -> None:
        """Write one event; nobody left to read it is not an error."""
        if self._descriptor is None:
            return
        data = encode(event)
        try:
            while data:
                data = data[os.write(self._descriptor, data) :]
        except BrokenPipeError:
            self._descriptor = None


def child_options(about: str, arguments: list[str] | None = None) -> argparse.Namespace:
    """Return the options with which swarm-up starts a process.

    Args:
        arguments: Command line; None for this process's own.

    Returns:
        `config` (a path), `event_fd`, `control_fd` (None without) and `wait`.
    """
    parser = argparse.ArgumentParser(description=f"{about}; started by swarm-up.")
    parser.add_argument("config", type=Path, help="JSON file")
    parser.add_argument("--event-fd", type=int, help="pipe to which events are written")
    parser.add_argument("--control-fd", type=int, help="pipe from which commands are read")
    parser.add_argument("--wait", action="store_true", help="read CONFIG only when told to go")
    return parser.parse_args(arguments)


class StartedProcess(Generic[Kind]):
    """This process, which swarm-up has started: what it is told, and what it tells.

    Attributes:
        path: File of the configuration.
        config: Its content.
        events: Pipe to swarm-up.
        is_stopping: Whether SIGTERM has asked for the end.
    """

    def __init__(
        self, about: str, decoder: msgspec.json.Decoder[Kind], arguments: list[str] | None = None
    ) -> None:
        """Read the configuration; from now on SIGTERM only sets `is_stopping`.

        Args:
            decoder: Decoder of the commands that it takes.
            arguments: Command line; None for this process's own.
        """
        options = child_options(about, arguments)
        self.path: Path = options.config
        self.config: dict[str, Any] = json.loads(self.path.read_text(encoding="utf-8"))
        self.events = EventWriter(options.event_fd)
        self.is_stopping = False
        self._commands = MessageReader(options.control_fd, decoder)
        signal.signal(signal.SIGTERM, self._stop)

    def _stop(self, *_: object) -> None:
        self.is_stopping = True

    def commands(self) -> list[Kind]:
        """Return the commands of swarm-up that have arrived."""
        return self._commands.read()

    def refuse(self, reason: object) -> int:
        """Tell swarm-up, and the log, that the input is unusable; return the exit code."""
        self.events.write(Refused(str(reason)))
        sys.stderr.write(f"{reason}\n")
        return 2


def leave(code: int = 0) -> NoReturn:
    """End at once: the interpreter's own end would wait for threads of libraries like DDS."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
