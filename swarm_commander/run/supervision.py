"""Supervision of a run: its processes are started, listened to, restarted and ended together."""

from __future__ import annotations

import json
import os
import selectors
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import psutil

from swarm_commander.run.process_table import (
    MAY_END,
    OPERATOR,
    RESTARTED,
    TOLD,
    TOLD_OWN,
    VITAL,
    Configs,
    Process,
    kind_of,
)
from swarm_commander.run.processes.launch import ProcessChild
from swarm_commander.run.processes.restarts import Heartbeats, Restarts
from swarm_commander.run.processes.supervisor import Exit, ProcessSpec, Supervisor, describe_exit
from swarm_commander.run.processes.usage import UsageLog, UsageMeter, process_tree
from swarm_commander.run.results.progress import Progress
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.rundir import RunFolder, end_of
from swarm_common.files.journal import Journal
from swarm_common.middleware import ros_env
from swarm_common.model.errors import SwarmError
from swarm_common.process import messages as say
from swarm_common.process import start
from swarm_common.process.signals import SignalCounter
from swarm_run.domain import DomainLock, Request

USAGE_FILE = "usage.jsonl"
POLL_PERIOD = 0.1  # [s] of wall time
GRACE = 10.0  # [s] for a process to end when asked to
START_LIMIT = 600.0  # [s] for all to be active; the first start compiles the kernels
SAMPLE_PERIOD = 2.0  # [s] between two readings of CPU time and memory


class RunRefusedError(SwarmError):
    """A process refused the user's input."""


class RunPart:
    """A part of a run: what it does when something happens; nothing by default."""

    def begin(self) -> None:
        """Start the first processes."""

    def on_event(self, event: say.Event) -> bool:
        """Handle an event; return whether a process of this part may report it."""
        return False

    def check(self) -> None:
        """Look for what should have happened by now; not once the run is about to end."""

    def on_exit(self, exit_: Exit) -> None:
        """Handle the end of a process, before it is restarted or the run ends with it."""

    def restart(self, name: str, config: dict[str, Any]) -> None:
        """Restart a process that had this configuration."""

    def on_restarts(self, due: Sequence[str]) -> None:
        """Restart navigators that are due."""

    def on_sample(self) -> None:
        """CPU time and memory were read."""

    def on_stop(self, phase: str) -> None:
        """Tell others that the run is about to end."""

    def located(self, message: str) -> str:
        """Return a refusal that names the user's own file."""
        return message


class Supervision:
    """Processes of a run. `run` returns when nothing is left running.

    Each event of a process goes to the statistics, and to the parts of the run.

    Attributes:
        statistics: Events added up.
        usage: CPU time and memory.
        failures: Failed components, in words; empty if none failed.
        incidents: What broke and was restarted, for the user.
        awaits_activity: Whether there is nothing to conclude before all navigators were active.
        active_after_wall: [s] from the start until every navigator was active.
        wall_time: [s] from the start until everything was told to stop.
        is_stopping: Whether everything was told to stop.
        is_stopped_by_user: Whether it was a signal that ended the run.
        verdict: What the world measured; empty until it has ended.
        table: Lines of the process table, in the order of stopping.
        restarts: Decides when what died is restarted.
        environments: Variables of single processes, by the name of their line.
    """

    def __init__(
        self,
        table: Sequence[Process],
        folder: RunFolder,
        progress: Progress,
        statistics: RunStatistics,
        *,
        restarts: bool = True,
    ) -> None:
        """Prepare a run; `run` starts the processes.

        Args:
            restarts: Whether processes that die are restarted.
        """
        self.folder = folder
        self.progress = progress
        self.statistics = statistics
        self.usage = UsageMeter()
        self.failures: list[str] = []
        self.incidents: list[str] = []
        self.awaits_activity = False
        self.active_after_wall: float | None = None
        self.wall_time = 0.0
        self.is_stopping = False
        self.is_stopped_by_user = False
        self.verdict: dict[str, Any] = {}
        self.restarts = Restarts(is_allowed=restarts)
        self.environments: dict[str, Mapping[str, str]] = {}
        self.table = tuple(table)
        self._rows = {row.name: row for row in table}
        self._parts: Sequence[RunPart] = ()
        self._refusal: str | None = None
        self._rejected: set[str] = set()  # kinds of inputs that the user was told of
        self._configs: dict[str, dict[str, Any]] = {}
        self._children: dict[str, ProcessChild] = {}
        self._selector = selectors.DefaultSelector()
        self._supervisor = Supervisor(self._spawn, time.monotonic)
        # Of this process, by a clock that nobody sets.
        self._started = time.monotonic() - (time.time() - psutil.Process().create_time())
        self._next_sample = 0.0
        self._usage_log = UsageLog(Journal(folder.trace / USAGE_FILE))
        self._heartbeats = Heartbeats(time.monotonic)
        self._signals = SignalCounter()
        self._resigned: set[str] = set()  # processes that have said why they end

    def run(self, *parts: RunPart) -> None:
        """Start everything, follow it to its end, stop everything.

        Args:
            parts: What happens is told to each, in this order.

        Raises:
            RunRefusedError: If a process refuses its input.
        """
        self._parts = parts
        with self._signals:
            try:
                for part in parts:
                    self._guard(part.begin)
                while not self._supervisor.all_gone:
                    self._turn()
            finally:
                self._clean_up()
        if self._refusal is not None:
            raise RunRefusedError(self._refusal)

    @property
    def never_active(self) -> bool:
        """True before any robot drives."""
        return self.awaits_activity and self.active_after_wall is None

    @property
    def ending_signal(self) -> int:
        """Number of the signal that ended the run; 0 for none."""
        return self._signals.latest

    @property
    def elapsed(self) -> float:
        """Wall time [s] since this process was started."""
        return time.monotonic() - self._started

    def serve(self, lock: DomainLock, obey: Callable[[Request], None]) -> None:
        """Accept requests of the user's other processes until the run ends.

        Args:
            lock: Lock of the run's domain; requests arrive there.
            obey: Called with each request; answers it.
        """

        def receive() -> None:
            if (request := lock.take()) is not None:
                obey(request)

        self._selector.register(lock, selectors.EVENT_READ, receive)

    # For parts: processes

    def start(self, name: str, config: dict[str, Any], *flags: str) -> None:
        """Start a process of the table with a configuration."""
        path = self.configure(name, config)
        command = start.command(self._rows[kind_of(name)].module, str(path), *flags)
        self._supervisor.start(ProcessSpec(name, command, GRACE))

    def start_all(self, configs: Configs) -> None:
        """Start processes with their configurations."""
        for name, config in configs.items():
            self.start(name, config)

    def configure(self, name: str, config: dict[str, Any]) -> Path:
        """Write the configuration of a process; return its file."""
        self._configs[name] = config
        path = self.folder.configs / f"{name}.json"
        path.write_text(json.dumps(config, indent=1), encoding="utf-8")
        return path

    def tell(self, name: str, command: say.CommandBase) -> None:
        """Send a command to a process, if it has been started."""
        if name in self._children:
            self._children[name].tell(command)

    def tell_of(self, command: say.RobotCommand) -> None:
        """Send a command about a robot to all processes that the table has told of robots."""
        for name in self._children:
            traits = self._rows[kind_of(name)].traits
            if traits & TOLD or (traits & TOLD_OWN and command.robot in self.robots_of(name)):
                self.tell(name, command)

    def robots_of(self, name: str) -> list[str]:
        """Return the names of the robots in the configuration of a process."""
        return list(self._configs[name].get("robots", ()))

    def is_running(self, name: str) -> bool:
        """Whether a process runs."""
        return self._supervisor.pid(name) is not None

    def silence(self, name: str) -> float:
        """Return how long [s] a process has been silent; 0 for one that was never heard."""
        return self._heartbeats.silence(name)

    def kill(self, name: str) -> None:
        """End a process that hangs; it counts as one that ended without having been asked to."""
        self._heartbeats.forget(name)
        self._supervisor.kill_one(name)

    # For parts: how it goes

    def record_all_active(self) -> None:
        """Begin to measure: all navigators are active that are expected."""
        self.active_after_wall = self.elapsed
        self._sample(now=True)
        self.usage.mark()
        self.progress.phase("running")

    def is_start_over(self, waited: float, missing: str) -> bool:
        """End the run if navigators do not become active; return whether it ends.

        Args:
            waited: For how long [s].
            missing: Those that are not active, in words for people.
        """
        if waited > START_LIMIT:
            self.fail(f"after {waited:.0f} s not active: {missing}")
            self.stop("stopping")
        return self.is_stopping

    def warn(self, message: str) -> None:
        """Tell the user of something, unless the run is about to end."""
        if not self.is_stopping:
            self.progress.note(message, "yellow")

    def record_incident(self, message: str) -> None:
        """Report something that broke and is mended."""
        self.incidents.append(f"t = {self.statistics.sim_time:.1f} s: {message}")
        self.progress.breach("incidents", message)

    def fail(self, message: str) -> None:
        """Report a component that failed."""
        self.failures.append(message)
        self.progress.breach("failures", message)

    def refuse(self, message: str) -> None:
        """End the run, as the user's input is unusable."""
        if self._refusal is None:
            for part in self._parts:
                message = part.located(message)
            self._refusal = message
        self.stop("stopping")

    def stop(self, phase: str) -> None:
        """Begin to stop all processes, in the order of the table."""
        if self.is_stopping:
            return
        for part in self._parts:
            part.on_stop(phase)
        self._sample(now=True)
        self.is_stopping = True
        self.wall_time = self.elapsed
        for name in ("world", "navigators"):
            self.usage.sample_memory(name, process_tree(self._supervisor.pid(name)))
        self.progress.phase(phase)
        order = list(self._rows)
        self._supervisor.stop(sorted(self._children, key=lambda name: order.index(kind_of(name))))

    # Turns

    def _guard(self, do: Callable[[], object]) -> None:
        """Do something that writes files; a full disk ends the run, with its report."""
        try:
            do()
        except OSError as error:
            self.fail(f"cannot go on: {error}")
            self.stop("stopping")

    def _turn(self) -> None:
        for key, _ in self._selector.select(POLL_PERIOD):
            key.data()
        for exit_ in self._supervisor.poll():
            self._read(exit_.name)
            self._on_exit(exit_)
        if self._signals.count and not self.is_stopping:
            self.is_stopped_by_user = True
            never_active = self.never_active
            self.stop("stopping (press Ctrl-C again to kill)")
            if never_active:  # nothing to conclude, and who compiles hears no signal
                self._supervisor.kill()
        if self._signals.count > 1:
            self._supervisor.kill()
        self._heartbeats.look()
        if not self.is_stopping:
            self._check_silence()
            for part in self._parts:
                part.check()
            self._guard(self._restart_due)
        self._sample()
        self.progress.update()

    def _check_silence(self) -> None:
        for name in self._children:
            if self.silence(name) > self._rows[kind_of(name)].silence:
                self.record_incident(f"the {name} process hangs and is killed")
                self.kill(name)

    def _restart_due(self) -> None:
        if self.is_stopping:
            return
        due = self.restarts.pop_due(time.monotonic())
        for part in self._parts:
            for name in self._configs.keys() & set(due):
                part.restart(name, self._configs[name])
            part.on_restarts(due)

    def _read(self, name: str) -> None:
        try:
            events = self._children[name].read_events()
        except say.UnknownMessageError as error:
            self.fail(f"the {name} process: {error}")
            self.stop("stopping")
            return
        if events:
            self._heartbeats.hear(name)
        for event in events:
            self.statistics.apply(event)
            if isinstance(event, say.Refused) and self._rows[kind_of(name)].may_refuse:
                self._resigned.add(name)
                self.fail(f"the {name} process gave up: {event.message}")
            else:
                self._guard(partial(self.receive, event))

    def receive(self, event: say.Event) -> None:
        """Handle an event of a process."""
        match event:
            case say.VerdictReached(verdict=verdict):
                self.verdict = verdict
            case say.Note(message=message):
                self.progress.note(message)
            case say.Compiling(ready=ready, known=known):
                self.progress.compiling(ready, known)
                self._pass_on(event)
            case say.InputsRejected(notices=notices):  # the report counts all of each kind
                for kind in [kind for kind in notices if kind not in self._rejected]:
                    self._rejected.add(kind)
                    self.progress.note(notices[kind])
            case say.ConditionsChecked(text=text, guaranteed=holds):
                self.progress.note(text, "" if holds else "yellow")
            case say.ForeignPublisher(topic=topic, node=node):
                notice = f"{node} publishes on {topic}: it is ignored"
                if topic.endswith("/cmd_vel"):
                    notice += f"; drive by hand with swarm-teleop {topic.split('/')[1]}"
                self.progress.breach("foreign publishers", notice)
            case say.Refused(message=message):
                self.refuse(message)
            case say.Ready() | say.Alive():
                pass
            case _:
                if not self._pass_on(event):
                    self.fail(f"no process of this kind of run may report {event}")
                    self.stop("stopping")

    def _pass_on(self, event: say.Event) -> bool:
        return any([part.on_event(event) for part in self._parts])

    def _sample(self, *, now: bool = False) -> None:
        if self.is_stopping or (time.monotonic() < self._next_sample and not now):
            return
        self._next_sample = time.monotonic() + SAMPLE_PERIOD
        groups: dict[str, list[psutil.Process]] = {"world": [], "navigators": []}
        groups[OPERATOR] = [psutil.Process()]
        for name in self._children:
            if group := self._rows[kind_of(name)].group:
                groups.setdefault(group, []).extend(process_tree(self._supervisor.pid(name)))
        for group, processes in groups.items():
            self.usage.sample(group, processes)
        statistics = self.statistics
        self._usage_log.write(
            self.elapsed, statistics.sim_time, statistics.real_time_factor, self.usage
        )
        for part in self._parts:
            part.on_sample()

    def _spawn(self, spec: ProcessSpec) -> ProcessChild:
        if spec.name in self._children:
            self._children[spec.name].close()
        environment = {**os.environ, **self.environments.get(kind_of(spec.name), {})}
        child = ProcessChild(spec, self.folder.log(spec.name), environment)
        self._children[spec.name] = child
        self._selector.register(child.event_fd, selectors.EVENT_READ, lambda: self._read(spec.name))
        return child

    # The end

    def _on_exit(self, exit_: Exit) -> None:
        name, row = exit_.name, self._rows[kind_of(exit_.name)]
        for part in self._parts:
            part.on_exit(exit_)
        self._heartbeats.forget(name)
        self._selector.unregister(self._children[name].event_fd)
        if exit_.killed and self._signals.count < 2 and not self.never_active:
            message = f"the {name} process did not end within {GRACE:g} s and was killed"
            if row.traits & VITAL:
                self.record_incident(message)
            else:  # what it made may lack its end
                self.fail(f"{message} (see {self.folder.log(name)})")
        if exit_.expected or self.is_stopping or self._refusal is not None:
            return
        has_ended_well = row.traits & MAY_END and exit_.returncode == 0
        if has_ended_well or name in self._resigned or self._is_restarted(exit_, row):
            return
        reason = describe_exit(exit_.returncode)
        self.fail(f"the {name} process ended: {reason}; {end_of(self.folder.log(name))}")
        if row.traits & VITAL:
            self.stop("stopping")

    def _is_restarted(self, exit_: Exit, row: Process) -> bool:
        pause = None
        if row.traits & RESTARTED:
            pause = self.restarts.on_death(exit_.name, time.monotonic())
        if pause is None:
            return False
        self.record_incident(
            f"the {exit_.name} process ended: {describe_exit(exit_.returncode)};"
            f" it is restarted in {pause:g} s (see {self.folder.log(exit_.name)})"
        )
        return True

    def _clean_up(self) -> None:
        self._supervisor.kill()
        for child in self._children.values():
            child.close()
        self._selector.close()
        ros_env.remove_abandoned()  # also of a swarm that was killed whole
