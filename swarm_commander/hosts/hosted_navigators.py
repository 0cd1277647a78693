"""`swarm-up --role world`: navigators of a run whose world and mission are here, on other hosts."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from swarm_commander.hosts.run_description import compose
from swarm_commander.run.own_navigators import Navigators
from swarm_commander.run.process_table import SERVER, WORLD
from swarm_commander.run.processes.supervisor import describe_exit
from swarm_commander.run.supervision import Supervision
from swarm_common.middleware.secret import VARIABLE
from swarm_common.model.robot_names import in_short
from swarm_common.process import messages as say
from swarm_common.process.compiled_code import edition
from swarm_run.domain import domain_id
from swarm_run.plan import RunPlan


class HostedNavigators(Navigators):
    """The world's side of a run on several hosts.

    It owns every fact about the run and says it to the robots' hosts (`run_description`). The
    mission runs here, too: goals, collisions and the report are in one hand, wherever a robot is.

    Attributes:
        hosts: Hosts of the robots, for the report.
    """

    def __init__(self, plan: RunPlan, run: Supervision, secret: str) -> None:
        super().__init__(plan, run)
        self.hosts: list[dict[str, Any]] = []
        self._secret = secret
        self._id = f"{run.folder.path.name}-{time.time_ns():x}"  # of this run
        self._unserved = set(plan.alive)
        self._trees: dict[str, dict[str, Any]] = {}  # parameter files
        run.environments[SERVER] = {VARIABLE: secret}

    def complete(self, report: dict[str, Any]) -> None:
        """Put the robots' hosts, and what their navigators used, into the report."""
        report["hosts"] = self.hosts
        seconds = report["swarm_size"] * (report["sim_time"] or 0.0)
        if seconds <= 0.0:
            return
        cpu = report["cpu_ms_per_robot_second"]
        navigators = round(1000.0 * sum(host["cpu_s"] for host in self.hosts) / seconds, 3)
        cpu["navigators"] = navigators
        cpu["total"] = round(cpu["total"] + navigators, 3)
        report["rss_mb"]["navigators"] = round(sum(host["rss_mb"] for host in self.hosts), 1)

    def _write(self, name: str, tree: dict[str, Any]) -> None:
        super()._write(name, tree)
        self._trees[name] = tree

    def release(self, map_file: str) -> None:
        """Say what the robots' hosts need to start them."""
        spec, sites = self._plan.spec, self._plan.sites_path
        description = compose(
            self._id,
            edition(),
            {"world": spec.world, "seed": spec.seed, "robot": spec.model, "swarm_size": spec.size},
            self._trees,
            Path(self._plan.copy_of(str(sites))) if sites is not None else None,
            {robot["name"]: robot["peers"] for robot in self._robots if robot["peers"]},
            self._plan.overrides.source,
            str(spec.naming),
        )
        where = {"address": spec.address, "domain": domain_id()}
        self._run.start(SERVER, {"description": asdict(description), **where})
        self._run.progress.phase("waiting for the robots' hosts")
        first, last = (spec.naming.number_of(self._plan.alive[i]) for i in (0, -1))
        self._run.progress.note(
            f"the world is up; on the hosts of {in_short(self._plan.alive)}, for example:\n"
            f"  {VARIABLE}={self._secret} swarm-up --role robots --robots {first}-{last}"
            f" --connect {spec.address}"
        )

    def check_start(self, missing: Sequence[str]) -> None:
        """See to navigators that are not active yet, and say what may be wrong."""
        if not self._unserved:  # the user may take any time to start the other hosts
            super().check_start(missing)

    def on_event(self, event: say.Event) -> bool:
        """Handle what the world and the robots' hosts report."""
        run = self._run
        match event:
            case say.NavigatorActive():
                self.record_start()
            case say.NavigatorDied():
                if not run.is_stopping:
                    how = describe_exit(event.returncode)
                    run.fail(f"{event.robot} died: {how}; its log is on {event.host}")
                    self._lose([event.robot])
            case say.RobotLate():  # its own host finds out why
                run.warn(f"{event.robot} does not answer; nobody waits for it")
            case say.RobotSpawned(robot=name):
                if not run.is_stopping:
                    run.progress.note(f"{name} came, but has no navigator: no host was told of it")
                    run.tell(WORLD, say.RobotDead(name))
            case say.RobotRemoved(robot=name):
                self.present.discard(name)
                if not run.is_stopping:
                    run.tell(SERVER, say.RobotGone(name))
            case say.StatusReported():
                pass
            case say.WorldProgress():
                figures = say.Figures(event.sim_time, event.real_time_factor, event.collisions)
                run.tell(SERVER, say.ShowFigures(figures))
            case say.HostJoined():
                self._on_host_joined(event)
            case say.HostRejected(host=host, reason=reason):
                run.progress.note(f"{host} was turned away: {reason}")
            case say.HostSilent():
                self._on_host_silent(event)
            case say.HostHeard(host=host, robots=robots, seconds=seconds):
                for name in robots:
                    run.tell(WORLD, say.RobotHeard(name))
                    run.tell_of(say.RobotHeard(name))
                run.progress.note(f"{host} is heard again after {seconds:.1f} s")
            case say.HostDeaf(host=host, seconds=seconds):
                run.warn(
                    f"{host} is heard, but has not heard this host for {seconds:.0f} s: packets"
                    " from here to there are lost"
                )
            case say.HostUnanswered(address=address):
                run.progress.note(
                    f"a robots' host at {address} calls, but hears no answer: UDP from here to"
                    " there is blocked",
                    "yellow",
                )
            case say.HostLost(host=host, robots=robots, seconds=seconds):
                if not run.is_stopping:
                    run.fail(
                        f"nothing was heard of {host} for {seconds:.0f} s: {in_short(robots)} are"
                        " lost"
                    )
                    self._lose(robots)
            case say.HostLeft(host=host, robots=robots):
                if not run.is_stopping:
                    run.progress.note(f"{host} left; {in_short(robots)} stand")
                    self._lose(robots)
            case say.HostsSummary(hosts=hosts):
                self.hosts = hosts
            case _:
                return False
        return True

    def _on_host_joined(self, event: say.HostJoined) -> None:
        self._unserved -= set(event.robots)
        self._run.tell(WORLD, say.ServeHost(event.robots, event.id, self._id, self._secret))
        self._run.progress.note(f"{event.host} has {in_short(event.robots)}")
        if not self._unserved:
            self._run.progress.phase("starting navigators")

    def _on_host_silent(self, event: say.HostSilent) -> None:
        if self._run.is_stopping:
            return
        for name in event.robots:
            self._run.tell(WORLD, say.RobotSilent(name, event.seconds))
            self._run.tell_of(say.RobotSilent(name))
        self._run.warn(f"nothing is heard of {event.host}; {in_short(event.robots)} must stand")

    def _lose(self, robots: Sequence[str]) -> None:
        """Go on without some robots."""
        for name in robots:
            self._run.statistics.robots[name].died = True
            self._run.tell(WORLD, say.RobotDead(name))
            self._run.tell_of(say.RobotDead(name))
        if all(self._run.statistics.robots[name].died for name in self.present):
            self._run.stop("no robot is left")

    def on_stop(self, phase: str) -> None:
        """Tell the robots' hosts why the run ends."""
        self._run.tell(
            SERVER, say.RunOver("stopped by its user" if self._run.is_stopped_by_user else phase)
        )
