"""`swarm-up --role robots`: the navigators of some robots on this host, the world on another."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from swarm_commander.hosts.robots_plan import RobotsPlan
from swarm_commander.hosts.run_description import RunDescription, parse
from swarm_commander.run.fork_server import HostForkServer
from swarm_commander.run.process_table import CLIENT, DISTRIBUTOR, HOST
from swarm_commander.run.results.run_statistics import RobotStatistics
from swarm_commander.run.supervision import RunPart, Supervision
from swarm_common.middleware.ros_env import PROFILES
from swarm_common.middleware.secret import VARIABLE
from swarm_common.model.robot_names import in_short
from swarm_common.process import messages as say
from swarm_common.process.compiled_code import edition
from swarm_run.params import ParameterSource, write_parameter_file
from swarm_run.record.figures import rounded

DESCRIPTION_FILE = "run_description.json"


class RobotsRun(RunPart):
    """The robots' side of a run on several hosts.

    Attributes:
        robots: Names of the robots; empty before the world's host has told them.
        ending: Why the run ended, for the report.
        silences: [s] that each silence of the world's host lasted.
        network: What probes found, see `link_probe`.
    """

    def __init__(self, plan: RobotsPlan, run: Supervision, robots_profile: Path) -> None:
        self.robots: tuple[str, ...] = ()
        self.ending = ""
        self.silences: list[float] = []
        self.network: dict[str, float] = {}
        self._plan = plan
        self._run = run
        self._navigators = HostForkServer(run)
        self._host = secrets.token_hex(8)  # name of this start
        self._description_path = run.folder.configs / DESCRIPTION_FILE
        self._source = ParameterSource()
        self._welcomed: float | None = None  # [s] from the start until the world's host answered
        for name in (CLIENT, DISTRIBUTOR):
            run.environments[name] = {VARIABLE: plan.secret}
        run.environments[HOST] = {PROFILES: str(robots_profile)}

    def begin(self) -> None:
        """Look for the world's host; start the fork server, which imports meanwhile."""
        plan = self._plan
        self._run.start(
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
        self._navigators.begin()

    def on_sample(self) -> None:
        """Report what the navigators use."""
        usage = self._run.usage
        self._run.tell(CLIENT, say.ReportUsage(usage.cpu("navigators"), usage.rss_mb("navigators")))

    def check(self) -> None:
        """See to navigators that are not active yet."""
        run = self._run
        if self._welcomed is not None and run.active_after_wall is None:
            missing = [name for name in self.robots if not run.statistics.robots[name].active]
            if not run.is_start_over(run.elapsed - self._welcomed, in_short(missing)):
                self._navigators.kill_stragglers(missing)

    def on_restarts(self, due: Sequence[str]) -> None:
        """Restart navigators that are due."""
        self._navigators.restart_due(due)

    def located(self, message: str) -> str:
        """Return a refusal that names the file of the world's user."""
        return self._source.located(message, self._run.folder.params)

    def on_event(self, event: say.Event) -> bool:
        """Handle what the world's host and the navigators report."""
        run, address = self._run, self._plan.world_address
        match event:
            case say.WorldProgress():  # the statistics shows it
                pass
            case say.NavigatorForked(robot=robot):
                self._navigators.on_fork(robot)
            case say.NavigatorActive(robot=robot):
                self._on_active(robot)
            case say.NavigatorDied(robot=robot, returncode=code):
                if not run.is_stopping and not self._navigators.on_died(event):
                    run.tell(CLIENT, say.ReportDeath(robot, code))
            case say.RobotTakenOut(robot=robot):
                run.statistics.robots[robot].left = True
                self._navigators.remove(robot)
                run.tell(HOST, say.EndNavigator(robot))
            case say.WorldFound():
                self._on_world_found()
            case say.WorldUnansweredYet(seconds=seconds):
                run.warn(f"{self._unanswered(seconds)} Waiting on.")
            case say.WorldUnanswered(seconds=seconds):
                run.refuse(self._unanswered(seconds))
            case say.WorldHasOtherSecret():
                run.refuse(
                    f"the world at {address} has another secret; take the command that it shows,"
                    f" or set {VARIABLE} to its contents"
                )
            case say.NetworkFault(message=message):
                run.warn(f"the network to {address}: {message}")
            case say.NetworkFigures(figures=figures):
                self.network = figures
            case say.WorldUnhearing():
                run.warn(
                    f"the world at {address} is heard, but does not hear this host: packets from"
                    " here to there are lost"
                )
            case say.WorldSilent():
                run.warn(
                    f"nothing is heard of the world at {address}; without data the robots stand"
                )
            case say.WorldHeard(seconds=seconds):
                self.silences.append(seconds)
                run.progress.note(f"the world is heard again after {seconds:.1f} s")
            case say.WorldLost(message=message):
                if not run.is_stopping:
                    self.ending = message
                    run.fail(message)
                    run.stop("stopping")
            case say.WorldOver(reason=reason):
                self.ending = f"the world's host says: {reason}"
                if not run.is_stopping:
                    run.progress.note(self.ending)
                run.stop("stopping")
            case _:
                return False
        return True

    def _on_world_found(self) -> None:
        """Start the navigators with the parameters that the description says."""
        run = self._run
        if run.is_stopping:
            return
        self._welcomed = run.elapsed
        run.progress.phase("starting navigators")
        description = parse(self._description_path.read_text(encoding="utf-8"))
        self._source = description.params
        sites = self._sites_file(description)
        self.robots = description.names_of(self._plan.robots)
        run.statistics.robots.update((name, RobotStatistics()) for name in self.robots)
        numbers = dict(zip(self._plan.robots, self.robots, strict=True))
        run.start(DISTRIBUTOR, {"host": self._host, "run": description.run, "robots": numbers})
        robots = []
        for name in self.robots:
            path = self._run.folder.params / f"{name}.yaml"
            self._navigators.params[name] = str(path)
            write_parameter_file(path, description.parameter_file(name, sites))
            robots.append(
                {"name": name, "params": str(path), "peers": description.peers.get(name, [])}
            )
        log_dir = str(self._run.folder.logs)
        world = {"world": self._plan.world_address} if description.peers else {}
        self._navigators.release(
            {"robots": robots, "pack": self._plan.pack, "log_dir": log_dir, **world}
        )

    def _sites_file(self, description: RunDescription) -> str:
        """Return the path of a copy of the world's sites file; empty without one."""
        if not description.sites:
            return ""
        path = self._run.folder.configs / "sites.yaml"
        path.write_text(description.sites, encoding="utf-8")
        return str(path)

    def _unanswered(self, seconds: float) -> str:
        plan = self._plan
        return (
            f"no world answers at {plan.world_address} within {seconds:.0f} s (ROS domain"
            f" {plan.domain}, from {plan.own_address}); is swarm-up --role world running there, in"
            " the same ROS_DOMAIN_ID, bound to that address, and are its UDP ports open?"
        )

    def _on_active(self, robot: str) -> None:
        if self._navigators.on_active(robot):
            self._run.progress.note(f"{robot} is active again")
        self._run.tell(CLIENT, say.ReportActive(robot))
        is_complete = self._run.statistics.active == len(self.robots)
        if is_complete and self._run.active_after_wall is None:
            self._run.record_all_active()


def robots_report(side: RobotsRun, run: Supervision, plan: RobotsPlan, code: int) -> dict[str, Any]:
    """Return the report of a robots' host; the verdict is in that of the world's."""
    statistics = run.statistics
    return {
        "schema": 1,
        "role": "robots",
        "robots": list(side.robots),
        "bound_to": plan.own_address,
        "world_host": plan.world_address,
        "ending": side.ending or ("stopped by its user" if run.is_stopped_by_user else ""),
        "wall_time": round(run.wall_time, 3),
        "active_after_wall": rounded(run.active_after_wall),
        "active": statistics.active,
        "restarts": run.restarts.total,
        "incidents": list(run.incidents),
        "died": [name for name, robot in statistics.robots.items() if robot.died],
        "silences": side.silences,
        "rejected": dict(sorted(statistics.rejected.items())),
        "network": side.network,
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
