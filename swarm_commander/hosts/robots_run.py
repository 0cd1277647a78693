"""`swarm-up --role robots`: the navigators of some robots on this host, the world on another."""

from __future__ import annotations

import os
import secrets
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, assert_never

from swarm_commander.hosts.robots_plan import RobotsPlan
from swarm_commander.hosts.run_description import RunDescription, parse
from swarm_commander.run.local_run import HOST, MODULES
from swarm_commander.run.process_run import ProcessRun
from swarm_commander.run.processes.usage import process_tree
from swarm_commander.run.results.progress import Progress
from swarm_commander.run.results.run_statistics import RobotStatistics, RunStatistics
from swarm_commander.run.rundir import RunFolder
from swarm_common.files.edition import edition
from swarm_common.middleware.ros_env import PROFILES
from swarm_common.middleware.secret import VARIABLE
from swarm_common.model.robot_names import in_short
from swarm_common.process.messages import (
    ClientEvent,
    EndNavigator,
    Go,
    NavigatorActive,
    NavigatorDied,
    NetworkFault,
    NetworkFigures,
    OwnEvent,
    ReportActive,
    ReportDeath,
    ReportUsage,
    RobotTakenOut,
    WorldFound,
    WorldHasOtherSecret,
    WorldHeard,
    WorldLost,
    WorldOver,
    WorldSilent,
    WorldUnanswered,
    WorldUnansweredYet,
    WorldUnhearing,
)
from swarm_run.params import ParameterSource, write_parameter_file
from swarm_run.record.figures import rounded

CLIENT, DISTRIBUTOR = "client", "distributor"
OWN_MODULES = {
    CLIENT: "swarm_commander.hosts.host_client",
    DISTRIBUTOR: "swarm_commander.hosts.distributor",
}
DESCRIPTION_FILE = "run_description.json"
START_LIMIT = 600.0  # [s] for all to be active; the first start compiles the kernels


class RobotsRun(ProcessRun):
    """The robots' side of a run on several hosts.

    Attributes:
        robots: Names of the robots; empty before the world's host has told them.
        ending: Why the run ended, for the report.
        silences: [s] that each silence of the world's host lasted.
        network: What probes found, see `link_probe`.
    """

    fork_server = HOST
    stop_order = (CLIENT, HOST, DISTRIBUTOR)  # the world is told before the navigators end

    def __init__(
        self,
        plan: RobotsPlan,
        folder: RunFolder,
        progress: Progress,
        statistics: RunStatistics,
        robots_profile: Path,
        modules: Mapping[str, str] = MODULES,
    ) -> None:
        super().__init__(
            folder, progress, statistics, {**modules, **OWN_MODULES}, restarts=plan.restart
        )
        self.robots: tuple[str, ...] = ()
        self.ending = ""
        self.silences: list[float] = []
        self.network: dict[str, float] = {}
        self._plan = plan
        self._host = secrets.token_hex(8)  # name of this start
        self._robots_profile = robots_profile
        self._description_path = folder.configs / DESCRIPTION_FILE
        self._source = ParameterSource()
        self._welcomed: float | None = None  # [s] from the start until the world's host answered

    def _environment(self, name: str) -> Mapping[str, str]:
        if name in (CLIENT, DISTRIBUTOR):
            return {**os.environ, VARIABLE: self._plan.secret}
        return {**os.environ, PROFILES: str(self._robots_profile)}

    def _begin(self) -> None:
        plan = self._plan
        self._start(
            CLIENT,
            {
                "host": self._host,
                "label": plan.label,
                "own_address": plan.own_address,
                "world_address": plan.world_address,
                "domain": plan.domain,
                "robots": list(plan.robots),
                "edition": edition(),
                "stated": dict(plan.stated),
                "description_path": str(self._description_path),
            },
        )
        self._start(HOST, {}, "--wait")  # imports and compiles meanwhile

    def _measure(self) -> None:
        self.usage.sample("navigators", process_tree(self._supervisor.pid(HOST)))
        cpu, rss_mb = self.usage.cpu("navigators"), self.usage.rss_mb("navigators")
        self._tell(CLIENT, ReportUsage(cpu, rss_mb))

    def _measure_last(self) -> None:
        self.usage.sample_memory("navigators", process_tree(self._supervisor.pid(HOST)))

    def _check(self) -> None:
        if self._welcomed is None or self.active_after_wall is not None or self._is_stopping:
            return
        waited = time.monotonic() - self._started - self._welcomed
        missing = [name for name in self.robots if not self.statistics.robots[name].active]
        if waited > START_LIMIT:
            self._fail(f"after {waited:.0f} s not active: {in_short(missing)}")
            self._stop("stopping")
        else:
            self._kill_stragglers(missing)

    def _on_own_event(self, event: OwnEvent) -> None:
        if isinstance(event, ClientEvent):
            self._on_client_event(event)
        elif isinstance(event, NavigatorActive):
            self._on_active(event.robot)
        elif isinstance(event, NavigatorDied):
            self._on_died(event)
        else:
            super()._on_own_event(event)

    # What the world's host says

    def _on_client_event(self, event: ClientEvent) -> None:
        address = self._plan.world_address
        match event:
            case WorldFound():
                self._on_world_found()
            case WorldUnansweredYet(seconds=seconds):
                self._warn(f"{self._unanswered(seconds)} Waiting on.")
            case WorldUnanswered(seconds=seconds):
                self._refuse(self._unanswered(seconds))
            case WorldHasOtherSecret():
                self._refuse(
                    f"the world at {address} has another secret; take the command that it shows,"
                    f" or set {VARIABLE} to its contents"
                )
            case NetworkFault(message=message):
                self._warn(f"the network to {address}: {message}")
            case NetworkFigures(figures=figures):
                self.network = figures
            case WorldUnhearing():
                self._warn(
                    f"the world at {address} is heard, but does not hear this host: packets from"
                    " here to there are lost"
                )
            case WorldSilent():
                self._warn(
                    f"nothing is heard of the world at {address}; without data the robots stand"
                )
            case WorldHeard(seconds=seconds):
                self.silences.append(seconds)
                self._progress.note(f"the world is heard again after {seconds:.1f} s")
            case WorldLost(message=message):
                if not self._is_stopping:
                    self.ending = message
                    self._fail(message)
                    self._stop("stopping")
            case WorldOver(reason=reason):
                self.ending = f"the world's host says: {reason}"
                if not self._is_stopping:
                    self._progress.note(self.ending)
                self._stop("stopping")
            case RobotTakenOut(robot=robot):
                self.statistics.robots[robot].left = True
                self._navigators.remove(robot)
                self._tell(HOST, EndNavigator(robot))
            case _:
                assert_never(event)

    def _on_world_found(self) -> None:
        """Start the navigators with the parameters that the description says."""
        if self._is_stopping:
            return
        self._welcomed = time.monotonic() - self._started
        self._progress.phase("starting navigators")
        description = parse(self._description_path.read_text(encoding="utf-8"))
        self._source = description.params
        sites = self._sites_file(description)
        self.robots = description.names_of(self._plan.robots)
        self.statistics.robots.update((name, RobotStatistics()) for name in self.robots)
        numbers = dict(zip(self._plan.robots, self.robots, strict=True))
        self._start(DISTRIBUTOR, {"host": self._host, "run": description.run, "robots": numbers})
        robots = []
        for name in self.robots:
            path = self._folder.params / f"{name}.yaml"
            self._navigators.params[name] = str(path)
            write_parameter_file(path, description.parameter_file(name, sites))
            robots.append(
                {"name": name, "params": str(path), "peers": description.peers.get(name, [])}
            )
        log_dir = str(self._folder.logs)
        world = {"world": self._plan.world_address} if description.peers else {}
        self._configure(
            HOST, {"robots": robots, "pack": self._plan.pack, "log_dir": log_dir, **world}
        )
        self._tell(HOST, Go())

    def _sites_file(self, description: RunDescription) -> str:
        """Return the path of a copy of the world's sites file; empty without one."""
        if not description.sites:
            return ""
        path = self._folder.configs / "sites.yaml"
        path.write_text(description.sites, encoding="utf-8")
        return str(path)

    def _unanswered(self, seconds: float) -> str:
        plan = self._plan
        return (
            f"no world answers at {plan.world_address} within {seconds:.0f} s (ROS domain"
            f" {plan.domain}, from {plan.own_address}); is swarm-up --role world running there, in"
            " the same ROS_DOMAIN_ID, bound to that address, and are its UDP ports open?"
        )

    # What the navigators say

    def _refuse(self, message: str) -> None:
        super()._refuse(self._source.located(message, self._folder.params))

    def _on_active(self, robot: str) -> None:
        if self._navigators.on_active(robot):
            self._progress.note(f"{robot} is active again")
        self._tell(CLIENT, ReportActive(robot))
        if self.statistics.active == len(self.robots) and self.active_after_wall is None:
            self._record_all_active()

    def _on_died(self, event: NavigatorDied) -> None:
        if self._is_stopping:
            return
        if not self._receive_death(event):
            self._tell(CLIENT, ReportDeath(event.robot, event.returncode))


def robots_report(run: RobotsRun, plan: RobotsPlan, code: int) -> dict[str, Any]:
    """Return the report of a robots' host; the verdict is in that of the world's."""
    statistics = run.statistics
    return {
        "schema": 1,
        "role": "robots",
        "robots": list(run.robots),
        "bound_to": plan.own_address,
        "world_host": plan.world_address,
        "ending": run.ending or ("stopped by its user" if run.is_stopped_by_user else ""),
        "wall_time": round(run.wall_time, 3),
        "active_after_wall": rounded(run.active_after_wall),
        "active": statistics.active,
        "restarts": run.restarts,
        "incidents": list(run.incidents),
        "died": [name for name, robot in statistics.robots.items() if robot.died],
        "silences": run.silences,
        "rejected": dict(sorted(statistics.rejected.items())),
        "network": run.network,
        "world": {
            "sim_time": round(statistics.sim_time, 3),
            "collisions": {
                "robot_robot": statistics.robot_robot,
                "robot_world": statistics.robot_world,
            },
        },
        "cpu_s": round(run.usage.cpu("navigators"), 3),
        "rss_mb": round(run.usage.rss_mb("navigators"), 1),
        "private_mb": rounded(run.usage.private_mb("navigators")),
        "exit_code": code,
        "failures": list(run.failures),
    }
