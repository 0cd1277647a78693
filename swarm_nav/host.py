"""The nursery: `python -m swarm_nav.host CONFIG.json [--event-fd N] [--control-fd M]`.

Imports everything and warms the kernels once, then forks one process per robot (or per pack of
robots). A fork costs almost nothing; a fresh interpreter costs a CPU second and 60 MB.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import json
import os
import select
import signal
import sys
import time
import traceback
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from swarm_common import ros_env
from swarm_common.errors import ConfigError, SwarmError
from swarm_common.pipes import EventWriter, LineReader
from swarm_common.process import die_with
from swarm_nav.node import NavigatorNode
from swarm_nav.ros_loop import TickLoop
from swarm_nav.ros_types import load_type_supports
from swarm_nav.settings import NodeSettings, read_node_settings
from swarm_nav.warm_up import warm_up

WAIT_SLICE = 0.25  # [s] of wall time between two looks at signals
GRACE = 5.0  # [s] for the children to end when asked to


class Nursery:
    """Forks, watches and ends the navigators' processes."""

    def __init__(self, events: EventWriter) -> None:
        """Begin without children."""
        self._events = events
        self._children: dict[int, Sequence[NodeSettings]] = {}
        self._starts: dict[str, str] = {}  # parameter files of robots that are to get one
        self._leaving: set[str] = set()  # robots that are to have no navigator
        self._is_stopping = False
        self._commands: LineReader | None = None

    def stop(self) -> None:
        """Make `watch` end the children and return."""
        self._is_stopping = True

    def wait_for_go(self, control_fd: int) -> bool:
        """Return True once the pipe says go, False if it ends before or `stop` was called."""
        self._commands = LineReader(control_fd)
        while not self._is_stopping:
            is_readable = select.select([control_fd], [], [], WAIT_SLICE)[0]
            commands = self._commands.read()
            for command in commands:
                self._obey(command)
            if any(command.get("cmd") == "go" for command in commands):
                return True
            if is_readable and not commands:
                return False
        return False

    def fork(self, group: Sequence[NodeSettings], log_dir: Path | None) -> None:
        """Start one process for a group of robots; its output goes to a file in `log_dir`."""
        parent = os.getpid()
        self._leaving -= {settings.name for settings in group}
        pid = os.fork()
        if pid:
            self._children[pid] = group
            return
        code = 1
        try:
            die_with(parent)
            if log_dir is not None:
                _open_log(log_dir / f"{group[0].name}.log")
            run_navigators(group, self._events)
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)

    def watch(self, log_dir: Path | None = None) -> None:
        """Report children that die until none is left or `stop` was called.

        Who said go may say which robots come and go; then having no children is no reason to end.

        Args:
            log_dir: Where the output of those that come goes.
        """
        while (self._children or self._commands) and not self._is_stopping:
            self._reap()
            for command in self._commands.read() if self._commands else []:
                self._obey(command)
            self._start_waiting(log_dir)
            time.sleep(0.1)
        self._end_children()

    def _obey(self, command: Mapping[str, Any]) -> None:
        """Start `{"cmd": "start", "robot": name, "params": file}` or end `{"cmd": "end", ...}`."""
        name = str(command.get("robot"))
        if command.get("cmd") == "start":
            self._starts[name] = str(command["params"])
        elif command.get("cmd") == "end" and self._starts.pop(name, None) is None:
            self._end(name)

    def _start_waiting(self, log_dir: Path | None) -> None:
        """Start navigators whose predecessors of the same name have ended."""
        busy = {settings.name for group in self._children.values() for settings in group}
        for name in [name for name in self._starts if name not in busy]:
            try:
                settings = read_node_settings(name, self._starts.pop(name))
                _ = settings.sites
            except SwarmError as error:
                self._events.write("note", message=f"{name} has no navigator: {error}")
                self._events.write("died", robot=name, returncode=2)
                continue
            self.fork([settings], log_dir)

    def _end(self, name: str) -> None:
        """End the process of a robot, unless others of its pack still need it."""
        self._leaving.add(name)
        for pid, group in self._children.items():
            names = {settings.name for settings in group}
            if name in names and names <= self._leaving:
                os.kill(pid, signal.SIGTERM)

    def _reap(self) -> None:
        while self._children:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                return
            group = self._children.pop(pid, ())
            code = os.waitstatus_to_exitcode(status)
            if self._is_stopping:
                continue
            for settings in group:
                if settings.name in self._leaving:
                    self._leaving.discard(settings.name)
                    continue
                self._events.write("died", robot=settings.name, returncode=code)

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


def run_navigators(group: Sequence[NodeSettings], events: EventWriter) -> None:
    """Run the navigators of one process until SIGTERM."""
    is_stopped = False

    def stop(*_: object) -> None:
        nonlocal is_stopped
        is_stopped = True

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, stop)
    context = Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    executor = EventsExecutor(context=context)
    nodes = [
        NavigatorNode(
            settings,
            context,
            lambda name=settings.name: events.write(  # type: ignore[misc]
                "active", robot=name, pid=os.getpid()
            ),
        )
        for settings in group
    ]
    loop = TickLoop(nodes, executor, context)
    with contextlib.suppress(ExternalShutdownException):
        while not is_stopped:
            loop.turn()


def read_config(path: str | Path) -> tuple[list[list[NodeSettings]], Path | None]:
    """Return the groups of robots that share a process, and the folder for logs.

    Raises:
        SwarmError: If the configuration or a robot's parameters are unusable.
    """
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
        robots = [(robot["name"], robot["params"]) for robot in data["robots"]]
        pack = int(data.get("pack", 1))
    except (OSError, ValueError, KeyError, TypeError) as cause:
        raise ConfigError(f"{path}: unusable configuration of the navigators: {cause!r}") from cause
    if pack < 1:
        raise ConfigError(f"{path}: pack is {pack}; it must be 1 or more")
    settings = [read_node_settings(name, params) for name, params in robots]
    for robot in settings:
        _ = robot.sites  # now, and not once more in each child
    groups = [settings[start : start + pack] for start in range(0, len(settings), pack)]
    log_dir = data.get("log_dir")
    return groups, Path(log_dir) if log_dir else None


def _prepare() -> None:
    """Do once what every child would do."""
    load_type_supports()
    warm_up()


def main(arguments: list[str] | None = None) -> int:
    """Run all navigators until told to stop; returns the exit code."""
    parser = argparse.ArgumentParser(description="Navigators of a swarm; started by swarm-up.")
    parser.add_argument("config", help="JSON file: robots, their parameter files, pack, log_dir")
    parser.add_argument("--event-fd", type=int, help="pipe to which events are written")
    parser.add_argument("--control-fd", type=int, help="pipe from which commands are read")
    parser.add_argument(
        "--wait", action="store_true", help='read CONFIG only when told {"cmd": "go"}'
    )
    options = parser.parse_args(arguments)
    ros_env.set_defaults()
    events = EventWriter(options.event_fd)
    nursery = Nursery(events)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: nursery.stop())
    if options.wait:
        _prepare()
        if not nursery.wait_for_go(options.control_fd):
            return 0
    try:
        groups, log_dir = read_config(options.config)
    except SwarmError as error:
        events.write("error", message=str(error))
        sys.stderr.write(f"{error}\n")
        return 2
    if not options.wait:
        _prepare()
    ros_env.announce_to_few(Path(options.config).resolve().parent, len(groups))
    gc.collect()
    gc.freeze()  # what the children share must not be touched by the collector
    for group in groups:
        nursery.fork(group, log_dir)
    events.write("ready")
    nursery.watch(log_dir)
    return 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # the interpreter's own end takes seconds with numba in it
