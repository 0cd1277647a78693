"""Processes of a run: started, listened to, and ended together."""

from __future__ import annotations

import json
import os
import selectors
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, assert_never

import psutil

from swarm_commander.run.processes.heartbeat import Heartbeats
from swarm_commander.run.processes.launch import ProcessChild
from swarm_commander.run.processes.navigators import NavigatorSupervisor
from swarm_commander.run.processes.restarts import MOST, Restarts
from swarm_commander.run.processes.supervisor import Exit, ProcessSpec, Supervisor, describe_exit
from swarm_commander.run.processes.usage import UsageLog, UsageMeter
from swarm_commander.run.results.progress import Progress
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.rundir import RunFolder, end_of
from swarm_common.files.journal import Journal
from swarm_common.middleware import shared_memory
from swarm_common.model.errors import SwarmError
from swarm_common.process import start
from swarm_common.process.lifetime import BEGINS_ANEW
from swarm_common.process.messages import (
    Alive,
    CentreReported,
    CommandBase,
    Compiling,
    ConditionsChecked,
    Event,
    ForeignPublisher,
    InputsRejected,
    NavigatorDied,
    NavigatorForked,
    Note,
    OwnEvent,
    ProcessEvent,
    Ready,
    RecordingBegun,
    Refused,
    UnknownMessageError,
    VerdictReached,
    WorldProgress,
)
from swarm_common.process.signals import SignalCounter
from swarm_run.domain import DomainLock, Request

USAGE_FILE = "usage.jsonl"
POLL_PERIOD = 0.1  # [s] of wall time
GRACE = 10.0  # [s] for a process to end when asked to
SAMPLE_PERIOD = 2.0  # [s] between two readings of CPU time and memory
FORGOTTEN = "was stopped until the others had forgotten it, and begins anew"


class RunRefusedError(SwarmError):
    """A process refused the user's input."""


class ProcessRun:
    """A run of some processes. `run` returns when nothing is left running.

    Each event of a process goes to the statistics and to the method of its group, see `messages`.

    Attributes:
        statistics: Events added up.
        usage: CPU time and memory.
        failures: Failed components, in words; empty if none failed.
        incidents: What broke and was restarted, for the user.
        active_after_wall: [s] from the start until every navigator was active.
        wall_time: [s] from the start until everything was told to stop.
        is_stopped_by_user: Whether it was a signal that ended the run.
        verdict: What the world measured; empty until it has ended.
    """

    _awaits_activity = True  # whether a navigator becomes active by itself
    fork_server = ""  # the process that starts navigators
    stop_order: Sequence[str] = ()  # order in which processes are stopped; the others after them
    onlookers: Sequence[str] = ()  # the run goes on without them

    def __init__(
        self,
        folder: RunFolder,
        progress: Progress,
        statistics: RunStatistics,
        modules: Mapping[str, str],
        *,
        restarts: bool = True,
    ) -> None:
        """Prepare a run; `run` starts the processes.

        Args:
            modules: Python module of each process by its name.
            restarts: Whether processes that die are restarted.
        """
        self.statistics = statistics
        self.usage = UsageMeter()
        self.failures: list[str] = []
        self.incidents: list[str] = []
        self.active_after_wall: float | None = None
        self.wall_time = 0.0
        self.is_stopped_by_user = False
        self.verdict: dict[str, Any] = {}
        self._modules = modules
        self._folder = folder
        self._progress = progress
        self._refusal: str | None = None
        self._rejected: set[str] = set()  # kinds of inputs that the user was told of
        self._children: dict[str, ProcessChild] = {}
        self._selector = selectors.DefaultSelector()
        self._supervisor = Supervisor(self._spawn, time.monotonic)
        # Of this process, by a clock that nobody sets.
        self._started = time.monotonic() - (time.time() - psutil.Process().create_time())
        self._next_sample = 0.0
        self._usage_log = UsageLog(Journal(folder.trace / USAGE_FILE))
        self._is_stopping = False
        self._restarts = Restarts(is_allowed=restarts)
        self._navigators = NavigatorSupervisor(
            self._restarts, lambda command: self._tell(self.fork_server, command), time.monotonic
        )
        self._heartbeats = Heartbeats(time.monotonic)
        self._signals = SignalCounter()
        self._resigned: set[str] = set()  # onlookers that have said why they end

    def run(self) -> None:
        """Start everything, follow it to its end, stop everything.

        Raises:
            RunRefusedError: If a process refuses its input.
        """
        with self._signals:
            try:
                self._guard(self._begin)
                while not self._supervisor.all_gone:
                    self._turn()
            finally:
                self._clean_up()
        if self._refusal is not None:
            raise RunRefusedError(self._refusal)

    @property
    def never_active(self) -> bool:
        """True before any robot drives: there is nothing to conclude."""
        return False

    @property
    def ending_signal(self) -> int:
        """Number of the signal that ended the run; 0 for none."""
        return self._signals.latest

    @property
    def restarts(self) -> int:
        """Number of processes that were started again."""
        return self._restarts.total

    def serve(self, lock: DomainLock) -> None:
        """Accept requests of the user's other processes until the run ends.

        Args:
            lock: Lock of the run's domain; requests arrive there.
        """

        def take() -> None:
            if (request := lock.take()) is not None:
                self._obey(request)

        self._selector.register(lock, selectors.EVENT_READ, take)

    def complete(self, report: dict[str, Any]) -> None:
        """Add what only this kind of run knows to its report."""

    def _guard(self, do: Callable[[], None]) -> None:
        """Do something that writes files; a full disk ends the run, with its report."""
        try:
            do()
        except OSError as error:
            self._fail(f"cannot go on: {error}")
            self._stop("stopping")

    # What a kind of run is made of

    def _begin(self) -> None:
        raise NotImplementedError

    def _check(self) -> None:
        """Look for what should have happened by now."""

    def _measure(self) -> None:
        """Read CPU time and memory of the processes."""

    def _measure_last(self) -> None:
        """Make the measurements that are made once, just before the end."""

    def _is_fine(self, exit_: Exit) -> bool:
        return False

    def _revives(self, exit_: Exit) -> bool:
        """True if a process that ended like this will be restarted."""
        return False

    def _revive(self, name: str) -> None:
        """Restart a process that `_revives` chose."""

    def _obey(self, request: Request) -> None:
        """Carry out a request of the user from another terminal."""
        request.answer("navigators run where the robots are, not here", is_done=False)

    # Turns

    def _turn(self) -> None:
        for key, _ in self._selector.select(POLL_PERIOD):
            key.data()
        for exit_ in self._supervisor.poll():
            self._read(exit_.name)
            self._on_exit(exit_)
        if self._signals.count and not self._is_stopping:
            self.is_stopped_by_user = True
            never_active = self.never_active
            self._stop("stopping (press Ctrl-C again to kill)")
            if never_active:  # nothing to conclude, and who compiles hears no signal
                self._supervisor.kill()
        if self._signals.count > 1:
            self._supervisor.kill()
        self._heartbeats.look()
        self._check()
        self._guard(self._restart_due)
        self._sample()
        self._progress.update()

    def _read(self, name: str) -> None:
        try:
            events = self._children[name].read_events()
        except UnknownMessageError as error:
            self._fail(f"the {name} process: {error}")
            self._stop("stopping")
            return
        if events:
            self._heartbeats.hear(name)
        for event in events:
            self.statistics.apply(event)
            if isinstance(event, Refused) and self._may_resign(name):
                self._resigned.add(name)
                self._fail(f"the {name} process gave up: {event.message}")
            else:
                self._guard(partial(self._on_event, event))

    def _may_resign(self, name: str) -> bool:
        """Whether the run goes on if a process refuses its input."""
        return name.split("_")[0] in self.onlookers

    def _on_event(self, event: Event) -> None:
        if isinstance(event, ProcessEvent):
            self._on_process_event(event)
        else:
            self._on_own_event(event)

    def _on_own_event(self, event: OwnEvent) -> None:
        """Handle an event that only this kind of run has; overridden by each kind."""
        self._fail(f"no process of this kind of run may report {event}")
        self._stop("stopping")

    def _on_process_event(self, event: ProcessEvent) -> None:
        match event:
            case NavigatorForked(robot=robot):
                self._navigators.on_fork(robot)
            case VerdictReached(verdict=verdict):
                self.verdict = verdict
            case Note(message=message):
                self._progress.note(message)
            case Compiling(ready=ready, known=known):
                self._progress.compiling(ready, known)
            case InputsRejected(notices=notices):
                self._record_rejections(notices)
            case ConditionsChecked(text=text, guaranteed=holds):
                self._progress.note(text, "" if holds else "yellow")
            case ForeignPublisher(topic=topic, node=node):
                notice = f"{node} publishes on {topic}: it is ignored"
                if topic.endswith("/cmd_vel"):
                    notice += f"; drive by hand with swarm-teleop {topic.split('/')[1]}"
                self._progress.breach("foreign publishers", notice)
            case Refused(message=message):
                self._refuse(message)
            case WorldProgress():
                self._on_progress(event)
            case Ready() | Alive() | RecordingBegun() | CentreReported():
                pass
            case _:
                assert_never(event)

    def _on_progress(self, event: WorldProgress) -> None:
        """Handle the progress of the world."""

    def _sample(self, *, now: bool = False) -> None:
        if self._is_stopping or (time.monotonic() < self._next_sample and not now):
            return
        self._next_sample = time.monotonic() + SAMPLE_PERIOD
        self._measure()
        statistics = self.statistics
        self._usage_log.write(
            time.monotonic() - self._started,
            statistics.sim_time,
            statistics.real_time_factor,
            self.usage,
        )

    # Processes

    def _start(self, name: str, config: dict[str, Any], *flags: str) -> None:
        path = self._configure(name, config)
        module = self._modules[name.split("_")[0]]
        command = start.command(module, str(path), *flags)
        self._supervisor.start(ProcessSpec(name, command, GRACE))

    def _configure(self, name: str, config: dict[str, Any]) -> Path:
        path = self._folder.configs / f"{name}.json"
        path.write_text(json.dumps(config, indent=1), encoding="utf-8")
        return path

    def _environment(self, name: str) -> Mapping[str, str]:
        return os.environ

    def _spawn(self, spec: ProcessSpec) -> ProcessChild:
        if spec.name in self._children:
            self._children[spec.name].close()
        child = ProcessChild(spec, self._folder.log(spec.name), self._environment(spec.name))
        self._children[spec.name] = child
        self._selector.register(child.event_fd, selectors.EVENT_READ, lambda: self._read(spec.name))
        return child

    def _tell(self, name: str, command: CommandBase) -> None:
        """Send a command to a process, if it has been started."""
        if name in self._children:
            self._children[name].tell(command)

    # Navigators that die or hang

    def _restart_due(self) -> None:
        """Start anew what is due; notice a fork server that does not do so."""
        if self._is_stopping:
            return
        due = self._restarts.pop_due(time.monotonic())
        self._navigators.turn(due)
        for name in due:
            if name in self.statistics.robots:
                self.statistics.robots[name].restarts += 1
            else:
                self._revive(name)
        for name in self._navigators.overdue() if self._awaits_activity else ():
            self._record_incident(f"{name} did not become active again: it hangs and is killed")
            self._navigators.kill(name)
        if self._navigators.is_fork_server_deaf() and self._supervisor.pid(self.fork_server):
            self._record_incident(
                f"the {self.fork_server} process does not start anybody: it is killed"
            )
            self._navigators.on_fork_server_end()
            self._supervisor.kill_one(self.fork_server)

    def _kill_stragglers(self, missing: Sequence[str]) -> None:
        """Kill navigators that hang at the start; they are restarted like any that die."""
        if not self._restarts.is_allowed:
            return
        for name in self._navigators.stragglers(self.statistics.active, list(missing)):
            self._record_incident(f"{name} did not become active with the others: it hangs")
            self._navigators.kill(name)

    def _receive_death(self, event: NavigatorDied) -> bool:
        """Restart a dead navigator if that may help; return whether it will be restarted."""
        name, begins_anew = event.robot, event.returncode == BEGINS_ANEW
        how = f"died: {describe_exit(event.returncode)}"
        message = f"{name} {FORGOTTEN if begins_anew else how}"
        pause = self._navigators.on_death(name, begins_anew=begins_anew)
        where = f"its log is in {self._folder.logs}"
        if pause is None:
            often = f" more than {MOST} times; it stays down" if self._restarts.is_allowed else ""
            self._fail(f"{message}{often}; {where}")
            return False
        self._record_incident(f"{message}; it is restarted in {pause:g} s; {where}")
        return True

    def _record_all_active(self) -> None:
        """Begin to measure: all navigators are active that are expected."""
        self.active_after_wall = time.monotonic() - self._started
        self._sample(now=True)
        self.usage.mark()
        self._progress.phase("running")

    def _warn(self, message: str) -> None:
        if not self._is_stopping:
            self._progress.note(message, "yellow")

    def _record_incident(self, message: str) -> None:
        self.incidents.append(f"t = {self.statistics.sim_time:.1f} s: {message}")
        self._progress.breach("incidents", message)

    # The end

    def _record_rejections(self, notices: Mapping[str, str]) -> None:
        """Report the first rejection of each kind of input; the report counts the others."""
        for kind, notice in notices.items():
            if kind not in self._rejected:
                self._rejected.add(kind)
                self._progress.note(notice)

    def _refuse(self, message: str) -> None:
        if self._refusal is None:
            self._refusal = message
        self._stop("stopping")

    def _on_exit(self, exit_: Exit) -> None:
        self._heartbeats.forget(exit_.name)
        self._selector.unregister(self._children[exit_.name].event_fd)
        if exit_.killed and self._signals.count < 2 and not self.never_active:
            self._on_overdue(exit_.name)
        if exit_.expected or self._is_stopping or self._refusal is not None:
            return
        is_known = self._is_fine(exit_) or exit_.name in self._resigned
        if is_known or self._revives(exit_):
            return
        reason = describe_exit(exit_.returncode)
        log_end = end_of(self._folder.log(exit_.name))
        self._fail(f"the {exit_.name} process ended: {reason}; {log_end}")
        if exit_.name.split("_")[0] not in self.onlookers:
            self._stop("stopping")

    def _on_overdue(self, name: str) -> None:
        """Report a process that hung, or still compiled; what an onlooker made may lack its end."""
        message = f"the {name} process did not end within {GRACE:g} s and was killed"
        if name.split("_")[0] in self.onlookers:
            self._fail(f"{message} (see {self._folder.log(name)})")
        else:
            self._record_incident(message)

    def _fail(self, message: str) -> None:
        self.failures.append(message)
        self._progress.breach("failures", message)

    def _stop(self, phase: str) -> None:
        if self._is_stopping:
            return
        self._sample(now=True)
        self._is_stopping = True
        self.wall_time = time.monotonic() - self._started
        self._measure_last()
        self._progress.phase(phase)
        self._supervisor.stop(self.stop_order)

    def _clean_up(self) -> None:
        self._supervisor.kill()
        for child in self._children.values():
            child.close()
        self._selector.close()
        shared_memory.remove_abandoned()  # also of a swarm that was killed whole
