"""`swarm-up --role world`: world and mission on this host, navigators on others."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, assert_never

from swarm_commander.hosts.run_description import RunDescription, compose
from swarm_commander.run.local_run import HOST, MODULES, RUNNER, STOP_ORDER, WORLD, LocalRun
from swarm_commander.run.processes.supervisor import describe_exit
from swarm_commander.run.results.progress import Progress
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.rundir import RunFolder
from swarm_common.files.edition import edition
from swarm_common.middleware.secret import VARIABLE
from swarm_common.model.records import Pose
from swarm_common.model.robot_names import in_short
from swarm_common.process.messages import (
    Figures,
    HostDeaf,
    HostHeard,
    HostJoined,
    HostLeft,
    HostLost,
    HostRejected,
    HostSilent,
    HostsSummary,
    HostUnanswered,
    NavigatorDied,
    OwnEvent,
    RobotDead,
    RobotGone,
    RobotHeard,
    RobotLate,
    RobotRemoved,
    RobotSilent,
    RobotSpawned,
    RunOver,
    ServeHost,
    ServerEvent,
    ShowFigures,
    WorldProgress,
)
from swarm_run.domain import domain_id
from swarm_run.params import write_parameter_file
from swarm_run.plan import RunPlan

SERVER = "server"
OWN_MODULES = {SERVER: "swarm_commander.hosts.host_server"}


class WorldRun(LocalRun):
    """The world's side of a run on several hosts.

    It owns every fact about the run and says it to the robots' hosts (`run_description`). The
    mission runs here, too: goals, collisions and the report are in one hand, wherever a robot is.

    Attributes:
        hosts: Hosts of the robots, for the report.
    """

    stop_order = (*(name for name in STOP_ORDER if name != HOST), SERVER)

    def __init__(
        self,
        plan: RunPlan,
        folder: RunFolder,
        progress: Progress,
        statistics: RunStatistics,
        secret: str,
        modules: Mapping[str, str] = MODULES,
    ) -> None:
        super().__init__(plan, folder, progress, statistics, {**modules, **OWN_MODULES})
        self.hosts: list[dict[str, Any]] = []
        self._secret = secret
        self._run = f"{folder.path.name}-{time.time_ns():x}"
        self._unserved = set(plan.alive)
        self._trees: dict[str, dict[str, Any]] = {}  # parameter files

    def complete(self, report: dict[str, Any]) -> None:
        """Put the robots' hosts, and what their navigators used, into the report."""
        super().complete(report)
        report["hosts"] = self.hosts
        seconds = report["swarm_size"] * (report["sim_time"] or 0.0)
        if seconds <= 0.0:
            return
        cpu = report["cpu_ms_per_robot_second"]
        navigators = round(1000.0 * sum(host["cpu_s"] for host in self.hosts) / seconds, 3)
        cpu["navigators"] = navigators
        cpu["total"] = round(cpu["total"] + navigators, 3)
        report["rss_mb"]["navigators"] = round(sum(host["rss_mb"] for host in self.hosts), 1)

    def _environment(self, name: str) -> Mapping[str, str]:
        return {**os.environ, VARIABLE: self._secret} if name == SERVER else os.environ

    def _begin(self) -> None:
        self._start_world()

    def _prepare_navigators(self, homes: Sequence[Pose]) -> None:
        for number, (name, home) in enumerate(
            zip(self._plan.spec.robot_names, homes, strict=True), 1
        ):
            if name in self._plan.alive:
                self._trees[name] = self._plan.parameter_file(number, home, self.map_sha256)
                write_parameter_file(self._folder.params / f"{name}.yaml", self._trees[name])
                self._robots.append({"name": name, "peers": []})

    def _description(self) -> RunDescription:
        spec = self._plan.spec
        facts = {
            "world": spec.world,
            "seed": spec.seed,
            "robot": spec.model,
            "swarm_size": spec.size,
        }
        peers = {robot["name"]: robot["peers"] for robot in self._robots if robot["peers"]}
        sites = self._plan.sites_path
        return compose(
            self._run,
            edition(),
            facts,
            self._trees,
            Path(self._plan.copy_of(str(sites))) if sites is not None else None,
            peers,
            self._plan.overrides.source,
            str(spec.naming),
        )

    def _release_navigators(self) -> None:
        """Say what the robots' hosts need to start them."""
        where = {"address": self._plan.spec.address, "domain": domain_id()}
        self._start(SERVER, {"description": asdict(self._description()), **where})
        self._progress.phase("waiting for the robots' hosts")
        names = self._plan.spec.naming
        first, last = (names.number_of(self._plan.alive[i]) for i in (0, -1))
        self._progress.note(
            f"the world is up; on the hosts of {in_short(self._plan.alive)}, for example:\n"
            f"  {VARIABLE}={self._secret} swarm-up --role robots --robots {first}-{last}"
            f" --connect {self._plan.spec.address}"
        )

    def _check_start(self) -> None:
        if not self._unserved:  # the user may take any time to start the other hosts
            super()._check_start()

    # What the hosts say

    def _on_own_event(self, event: OwnEvent) -> None:
        if isinstance(event, ServerEvent):
            self._on_server_event(event)
        else:
            super()._on_own_event(event)

    def _on_server_event(self, event: ServerEvent) -> None:
        match event:
            case HostJoined():
                self._on_host_joined(event)
            case HostRejected(host=host, reason=reason):
                self._progress.note(f"{host} was turned away: {reason}")
            case HostSilent():
                self._on_host_silent(event)
            case HostHeard(host=host, robots=robots, seconds=seconds):
                for name in robots:
                    self._tell(WORLD, RobotHeard(name))
                    self._tell(RUNNER, RobotHeard(name))
                self._progress.note(f"{host} is heard again after {seconds:.1f} s")
            case HostDeaf(host=host, seconds=seconds):
                self._warn(
                    f"{host} is heard, but has not heard this host for {seconds:.0f} s: packets"
                    " from here to there are lost"
                )
            case HostUnanswered(address=address):
                self._progress.note(
                    f"a robots' host at {address} calls, but hears no answer: UDP from here to"
                    " there is blocked",
                    "yellow",
                )
            case HostLost(host=host, robots=robots, seconds=seconds):
                self._give_up(robots, f"nothing was heard of {host} for {seconds:.0f} s")
            case HostLeft(host=host, robots=robots):
                if not self._is_stopping:
                    self._progress.note(f"{host} left; {in_short(robots)} stand")
                    self._lose(robots)
            case HostsSummary(hosts=hosts):
                self.hosts = hosts
            case _:
                assert_never(event)

    def _on_host_joined(self, event: HostJoined) -> None:
        self._unserved -= set(event.robots)
        self._tell(WORLD, ServeHost(event.robots, event.id, self._run, self._secret))
        self._progress.note(f"{event.host} has {in_short(event.robots)}")
        if not self._unserved:
            self._progress.phase("starting navigators")

    def _on_host_silent(self, event: HostSilent) -> None:
        if self._is_stopping:
            return
        for name in event.robots:
            self._tell(WORLD, RobotSilent(name, event.seconds))
            self._tell(RUNNER, RobotSilent(name))
        self._warn(f"nothing is heard of {event.host}; {in_short(event.robots)} must stand")

    def _on_late(self, event: RobotLate) -> None:
        """Whether a navigator hangs or cannot be heard is for its own host to find out."""
        self._warn(f"{event.robot} does not answer; nobody waits for it")

    def _on_died(self, event: NavigatorDied) -> None:
        if self._is_stopping:
            return
        how = describe_exit(event.returncode)
        self._fail(f"{event.robot} died: {how}; its log is on {event.host}")
        self._lose([event.robot])

    def _give_up(self, robots: Sequence[str], reason: str) -> None:
        if self._is_stopping:
            return
        self._fail(f"{reason}: {in_short(robots)} are lost")
        self._lose(robots)

    def _lose(self, robots: Sequence[str]) -> None:
        """Go on without some robots."""
        for name in robots:
            self.statistics.robots[name].died = True
            self._tell(WORLD, RobotDead(name))
            self._tell(RUNNER, RobotDead(name))
        if all(self.statistics.robots[name].died for name in self._navigated):
            self._stop("no robot is left")

    # What the world says

    def _on_progress(self, event: WorldProgress) -> None:
        super()._on_progress(event)
        figures = Figures(event.sim_time, event.real_time_factor, event.collisions)
        self._tell(SERVER, ShowFigures(figures))

    def _on_spawned(self, event: RobotSpawned) -> None:
        """A robot that comes later has no host."""
        if not self._is_stopping:
            name = event.robot
            self._progress.note(f"{name} came, but has no navigator: no host was told of it")
            self._tell(WORLD, RobotDead(name))

    def _on_removed(self, event: RobotRemoved) -> None:
        name = event.robot
        self._navigated.discard(name)
        if not self._is_stopping:
            self._tell(SERVER, RobotGone(name))
            self._tell(RUNNER, RobotGone(name))
            self._progress.note(f"{name} was taken out at t = {event.sim_time:.1f} s")

    def _stop(self, phase: str) -> None:
        if not self._is_stopping:
            reason = "stopped by its user" if self.is_stopped_by_user else phase
            self._tell(SERVER, RunOver(reason))
        super()._stop(phase)
