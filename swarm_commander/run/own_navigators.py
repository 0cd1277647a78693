"""Navigators of a run on one host: who has one, is active, late, lost, or restarted."""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Sequence
from typing import Any

from swarm_commander.run.fork_server import HostForkServer
from swarm_commander.run.process_table import HOST, WORLD
from swarm_commander.run.processes.supervisor import Exit
from swarm_commander.run.supervision import RunPart, Supervision
from swarm_commander.viewers.layouts import write_foxglove, write_rviz
from swarm_common.middleware import ros_env
from swarm_common.model.records import Pose
from swarm_common.process import messages as say
from swarm_mission.routes import goals
from swarm_run.domain import Request
from swarm_run.params import write_parameter_file
from swarm_run.plan import RunPlan

SUSPICION = 60.0  # [s] of wall time for robots to be heard again that were late with most others
SLOW_START = 60.0  # [s] after which to say what may keep all of them from being heard


class Navigators(RunPart):
    """Navigators of a run, wherever they are.

    Attributes:
        present: Robots that have a navigator, or had one that died.
    """

    def __init__(self, plan: RunPlan, run: Supervision) -> None:
        self.present = set(plan.alive)
        self._plan = plan
        self._run = run
        self._robots: list[dict[str, Any]] = []  # name, ports that it announces itself to, ...
        self._map_sha256 = ""
        self._has_hinted = False

    @property
    def lost(self) -> set[str]:
        """Robots whose navigator stays down."""
        return set()

    @property
    def down(self) -> set[str]:
        """Robots whose navigator will be restarted."""
        return set()

    def prepare(self, homes_map: list[Pose], map_sha256: str) -> None:
        """Write the parameters of all robots that work.

        Args:
            map_sha256: Digest of the map that the world will send.
        """
        self._map_sha256 = map_sha256
        leads_to = goals(self._plan.runner_config(homes_map))
        names = self._plan.spec.robot_names
        for number, (name, home) in enumerate(zip(names, homes_map, strict=True), 1):
            if name in self._plan.alive:
                tree = self._plan.parameter_file(number, home, map_sha256)
                self._write(name, tree)
                self._robots.append({"name": name, "goals": leads_to.get(name, []), "peers": []})

    def _write(self, name: str, tree: dict[str, Any]) -> None:
        write_parameter_file(self._run.folder.params / f"{name}.yaml", tree)

    def meet(self, ports: dict[str, list[int]]) -> None:
        """Let each robot announce itself to ports of a process, too."""
        for robot in self._robots:
            robot["peers"] += ports.get(robot["name"], [])

    def release(self, map_file: str) -> None:
        """Start all of them."""
        raise NotImplementedError

    def restart_server(self, config: dict[str, Any]) -> None:
        """Restart what starts them, which had this configuration."""

    def obey(self, request: Request) -> None:
        """Carry out a request of the user from another terminal."""
        name = request.command.robot
        request.answer(f"no navigator of '{name}' runs; there are none on this host", is_done=False)

    def complete(self, report: dict[str, Any]) -> None:
        """Add what is known of them only to the report."""

    def missing(self) -> list[str]:
        """Return the robots that are not active, and not lost either."""
        robots = self._run.statistics.robots
        return [
            name for name in self._plan.alive if not robots[name].active and name not in self.lost
        ]

    def record_start(self) -> None:
        """Notice that all navigators are active that are not lost."""
        awaited = set(self._plan.alive) - self.lost
        if self._run.active_after_wall is not None or self._run.statistics.active < len(awaited):
            return
        self._run.record_all_active()
        if self._plan.mission is None:
            sites = self._plan.sites
            has_goals = bool(sites.stations or sites.places)
            command = "swarm-commander" if has_goals else "swarm-teleop"
            script = shlex.quote(str(self._run.folder.path / "env.sh"))
            self._run.progress.note(
                "all robots are active; drive one from another terminal, for example with\n"
                f"  source {script}; {command} {self._plan.alive[0]}"
            )

    def check(self) -> None:
        """Say what may be wrong where no navigator is heard of."""
        if self._run.never_active and not self._run.is_stopping:
            self.check_start(self.missing())

    def check_start(self, missing: Sequence[str]) -> None:
        """See to navigators that are not active yet, and say what may be wrong."""
        waited = self._run.elapsed
        if self._run.is_start_over(waited, ", ".join(missing)):
            return
        settings = sorted(ros_env.FOREIGN & os.environ.keys())
        is_slow = waited > SLOW_START and len(missing) == len(self._plan.alive)
        if is_slow and settings and not ros_env.bound_address() and not self._has_hinted:
            self._has_hinted = True
            self._run.warn(
                f"no navigator is heard after {waited:.0f} s; {' and '.join(settings)} of this"
                " terminal decides who finds whom: check it, or unset it"
            )


class OwnNavigators(Navigators):
    """Navigators of this host."""

    def __init__(self, plan: RunPlan, run: Supervision) -> None:
        super().__init__(plan, run)
        self._server = HostForkServer(run, awaits_activity=plan.spec.autostart)
        self._suspects: dict[str, float] = {}  # that may hang: until when they may be silent
        self._requests: dict[str, list[Request]] = {}  # answered when a robot is active again
        self._is_released = False

    @property
    def lost(self) -> set[str]:
        """Robots whose navigator stays down."""
        return self._server.given_up

    @property
    def down(self) -> set[str]:
        """Robots whose navigator will be restarted."""
        return self._server.down

    def begin(self) -> None:
        """Start the fork server, which imports and compiles meanwhile."""
        self._server.begin()

    def _write(self, name: str, tree: dict[str, Any]) -> None:
        super()._write(name, tree)
        self._server.params[name] = str(self._run.folder.params / f"{name}.yaml")

    def release(self, map_file: str) -> None:
        """Let the fork server start all of them."""
        self._is_released = True
        params = self._server.params
        self._server.release(
            {
                "robots": [{**robot, "params": params[robot["name"]]} for robot in self._robots],
                "pack": self._plan.spec.pack_size,
                "map": map_file,
                "log_dir": str(self._run.folder.logs),
            }
        )

    def restart_server(self, config: dict[str, Any]) -> None:
        """Restart the fork server, with all navigators that it is to have."""
        if not self._is_released:
            self._server.begin()
            return
        known = {robot["name"]: robot for robot in self._robots}
        robots = [
            {**known.get(robot, {}), "name": robot, "params": params}
            for robot, params in self._server.params.items()
            if robot not in self.lost
        ]
        self._run.start(HOST, config | {"robots": robots})

    def on_event(self, event: say.Event) -> bool:
        """Handle what world, mission or navigators report."""
        match event:
            case say.NavigatorForked(robot=name):
                self._server.on_fork(name)
            case say.StatusReported(robot=name):
                self._suspects.pop(name, None)
            case say.NavigatorActive(robot=name):
                self._on_active(name)
            case say.NavigatorDied():
                self._on_died(event)
            case say.RobotLate():
                self._on_late(event)
            case say.RobotSpawned():
                self._on_spawned(event)
            case say.RobotRemoved(robot=name):
                self.present.discard(name)
                self._server.remove(name)
                if not self._run.is_stopping:
                    self._run.tell(HOST, say.EndNavigator(name))
            case _:
                return False
        return True

    def _on_active(self, name: str) -> None:
        if self._server.on_active(name):
            self._run.tell_of(say.RobotHeard(name))
            self._run.progress.note(f"{name} is active again")
        for request in self._requests.pop(name, []):
            request.answer(f"the navigator of {name} is active again", is_done=True)
        self.record_start()

    def _on_died(self, event: say.NavigatorDied) -> None:
        if self._run.is_stopping:
            return
        name = event.robot
        self._run.tell(WORLD, say.RobotDead(name))
        if self._server.on_died(event):
            self._run.tell_of(say.RobotSilent(name))
            return
        self._run.tell_of(say.RobotDead(name))
        for request in self._requests.pop(name, []):
            request.answer(f"the navigator of {name} died", is_done=False)
        if self.present <= self.lost:
            self._run.stop("no robot is left")
        else:
            self.record_start()

    def _on_spawned(self, event: say.RobotSpawned) -> None:
        """Start the navigator of a robot that came while the run goes on."""
        run, name = self._run, event.robot
        if run.is_stopping:
            return
        self.present.add(name)
        home = Pose(*event.pose)
        self._write(
            name,
            self._plan.parameter_file_of_newcomer(
                name, event.number, event.model, home, self._map_sha256
            ),
        )
        present = [robot for robot in run.statistics.robots if robot in self.present]
        write_rviz(run.folder.rviz, present, {name})
        write_foxglove(run.folder.foxglove, present, {name})
        run.tell(HOST, say.StartNavigator(name, self._server.params[name]))
        run.tell_of(say.WatchRobot(name))
        run.progress.note(f"{name} ({event.model}) came at t = {event.sim_time:.1f} s")

    def _on_late(self, event: say.RobotLate) -> None:
        """A navigator hangs: the world waits for it no longer."""
        run, name = self._run, event.robot
        silence = f"has not answered for {event.seconds:.0f} s"
        if run.is_stopping or name in self.down | self.lost:
            return
        if name in self._plan.spec.driven_by_users:  # a new node of its user may go on
            run.fail(f"the node that drives {name} {silence}")
            run.statistics.robots[name].died = True
            run.tell(WORLD, say.RobotDead(name))
        elif run.restarts.is_allowed and event.is_alone:
            self._kill_hanging(name, silence)
        else:
            run.warn(f"{name} {silence}; nobody waits for it any longer")
            if run.restarts.is_allowed:  # most are late: is it the machine?
                self._suspects[name] = time.monotonic() + SUSPICION

    def check(self) -> None:
        """Kill those that were late with most others and have not been heard since."""
        super().check()
        now = time.monotonic()
        for name in [name for name, due in self._suspects.items() if now > due]:
            del self._suspects[name]
            if name not in self.down | self.lost:
                self._kill_hanging(name, "does not answer any more")

    def check_start(self, missing: Sequence[str]) -> None:
        """See to navigators that are not active yet, and say what may be wrong."""
        super().check_start(missing)
        if not self._run.is_stopping:
            self._server.kill_stragglers(missing)

    def _kill_hanging(self, name: str, silence: str) -> None:
        self._run.record_incident(f"{name} {silence}: it hangs and is killed")
        self._server.kill(name)

    def on_exit(self, exit_: Exit) -> None:
        """All navigators ended with the fork server."""
        if exit_.name != HOST or self._run.is_stopping:
            return
        for name in self._server.on_fork_server_end():
            self._run.statistics.apply(say.NavigatorDied(name, exit_.returncode))
            self._run.tell(WORLD, say.RobotDead(name))
            self._run.tell_of(say.RobotSilent(name))

    def on_restarts(self, due: Sequence[str]) -> None:
        """Restart who is due; kill who hangs."""
        self._server.restart_due(due)

    def obey(self, request: Request) -> None:
        """Restart a robot's navigator; the answer follows when it is active."""
        name = request.command.robot
        if self._run.is_stopping:
            request.answer("the swarm is about to end", is_done=False)
        elif name not in self._server.params:
            known = ", ".join(self._server.params)
            request.answer(f"no navigator of '{name}' runs; there are {known}", is_done=False)
        else:
            self._requests.setdefault(name, []).append(request)
            self._run.record_incident(f"{name} is restarted, as its user wants")
            self._server.restart(name)
