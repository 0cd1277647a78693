"""A run from the first process to the report: what `swarm-up` does after its input is checked."""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, assert_never

import psutil

from swarm_commander.run.process_run import ProcessRun
from swarm_commander.run.processes.supervisor import Exit, describe_exit
from swarm_commander.run.processes.usage import process_tree
from swarm_commander.run.recording import recorder_config
from swarm_commander.run.results.progress import Progress
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.rundir import RunFolder
from swarm_commander.viewers.foxglove import write_foxglove
from swarm_commander.viewers.rviz import find_rviz, relay_command, rviz_command, write_rviz
from swarm_common.files.map_io import MAP_FILE
from swarm_common.middleware import ros_env
from swarm_common.model.records import Pose
from swarm_common.model.run_words import lost_text
from swarm_common.process.browser import open_page
from swarm_common.process.messages import (
    BeginTime,
    CentreReported,
    CollisionBegan,
    CommandBase,
    Compiling,
    EndNavigator,
    FloorReported,
    Go,
    GoalMissed,
    GoalReached,
    GoalSent,
    GoalsRestored,
    GoalWithdrawn,
    KernelsCompiled,
    MeetingPorts,
    MissionDone,
    MissionEvent,
    MissionLoaded,
    NavigatorActive,
    NavigatorDied,
    OnlookerEvent,
    OrdersReported,
    OwnEvent,
    ProcessEvent,
    RecordingBegun,
    RecordingEnded,
    RobotDead,
    RobotGone,
    RobotHeard,
    RobotLate,
    RobotRemoved,
    RobotSilent,
    RobotSpawned,
    StartNavigator,
    StationDone,
    StatusReported,
    TimeOver,
    ViewerOpened,
    WatchRobot,
    WorldBuilt,
    WorldEvent,
    WorldProgress,
)
from swarm_mission.orders.order_book import OrderBook
from swarm_mission.routes import goals
from swarm_run.domain import Request
from swarm_run.params import write_parameter_file
from swarm_run.plan import RunPlan
from swarm_run.spec import MERGED

WORLD, HOST, RUNNER, RECORDER = "world", "navigators", "mission", "recorder"
RVIZ, VIEWER, VDA5050 = "rviz", "viewer", "vda5050"
CENTRAL = "central"  # decides for all robots, where it does
STATION = "station"  # a process each, and one of a dispatcher
COURIER = "courier"  # a process for each robot with orders
MODULES = {
    WORLD: "swarm_sim.ros.node",
    HOST: "swarm_nav.launch.fork_server_main",
    RUNNER: "swarm_commander.mission.runner",
    STATION: "swarm_commander.mission.station",
    COURIER: "swarm_commander.mission.courier",
    CENTRAL: "swarm_central.process",
    RECORDER: "swarm_recording.recorder",
    RVIZ: "swarm_commander.viewers.window",
    VIEWER: "swarm_view.process",
    VDA5050: "swarm_vda5050.process",
}
MEETING = (
    WORLD,
    RUNNER,
)  # processes whose ports the navigators of a large swarm are told, see `participants`
OPERATOR = (RUNNER, STATION, COURIER)  # with swarm-up itself
STOP_ORDER = (WORLD, RUNNER, RECORDER, HOST)  # the world first, so that no navigator is late for it
# The run goes on without them; without a centre robots stand, or decide alone.
ONLOOKERS = (RECORDER, RVIZ, VIEWER, VDA5050, CENTRAL)
WORLD_SILENCE = 20.0  # [s] of wall time without a word after which the world hangs,
WORLD_START_SILENCE = 60.0  # [s] before its first step, when it may have to compile
SUSPICION = 60.0  # [s] of wall time for robots to be heard again that were late with most others
RUNNER_SILENCE = 30.0  # [s] the same of mission process and centre, which speak every 2 s
START_LIMIT = 600.0  # [s] for all to be active; the first start compiles the kernels
SLOW_START = 60.0  # [s] after which to say what may keep all of them from being heard
MISSION_LIMIT = 60.0  # [s] from then to the mission's first goal,
MISSION_LIMIT_PER_ROBOT = 1.0  # [s] and this much more for each robot to connect to


class LocalRun(ProcessRun):
    """A run on one host: world, navigators, mission."""

    fork_server = HOST
    stop_order: Sequence[str] = STOP_ORDER
    onlookers: Sequence[str] = ONLOOKERS

    def __init__(
        self,
        plan: RunPlan,
        folder: RunFolder,
        progress: Progress,
        statistics: RunStatistics,
        modules: Mapping[str, str] = MODULES,
    ) -> None:
        """Prepare a run; `run` starts the processes.

        Args:
            modules: Python module of each process by its name; tests put others there.
        """
        super().__init__(folder, progress, statistics, modules, restarts=plan.spec.restart)
        self._plan = plan
        self._awaits_activity = plan.spec.autostart
        self._runner: dict[str, Any] = {}  # what the mission process is started with
        self._couriers: dict[str, dict[str, Any]] = {}  # likewise those of robots with orders
        self._has_hinted = False
        self._is_released = False  # whether the fork server was told to start the navigators
        self._has_ticked = False
        self._has_sent = False  # whether a mission process has, be it one that died since
        self._suspects: dict[str, float] = {}  # that may hang: until when they may be silent
        self._requests: dict[str, list[Request]] = {}  # answered when a robot is active again
        self._navigated = set(plan.alive)  # robots that have a navigator, or had one that died
        self._unmet = set(MEETING) if ros_env.is_large(plan.spec.size) else set()
        if plan.spec.coordination.has_centre:
            self._unmet.add(CENTRAL)
        self.map_sha256 = ""  # of the map that the world will send
        if plan.mission is not None and (orders := plan.mission.orders) is not None:
            statistics.orders = OrderBook(orders.dispatch, plan.remarks)
            statistics.stations_left = set(orders.stations)
        self._recorded: RecordingEnded | None = None
        self._robots: list[dict[str, Any]] = []  # what the fork server is to start

    @property
    def never_active(self) -> bool:
        """True if the robots never were active together, so that none has driven."""
        return self._awaits_activity and self.active_after_wall is None

    def complete(self, report: dict[str, Any]) -> None:
        """Put what the recording has and lacks into the report."""
        if (told := self._recorded) is not None:
            lost = {"lost": told.lost, "missing": told.missing}
            report["recording"] = {"messages": told.messages, **lost}

    def _check(self) -> None:
        self._check_start()
        self._check_mission()
        self._check_world()
        self._check_runner()
        self._check_suspects()

    def _begin(self) -> None:
        for remark in self._plan.remarks:
            self._progress.note(remark, "yellow")
        for name in self._plan.spec.driven_by_users:
            self._progress.note(f"time begins when a node drives {name}; missions leave it out")
        self._start_world()
        self._start(HOST, {}, "--wait")  # imports and compiles meanwhile

    # Processes

    def _start_world(self) -> None:
        held = {"held": self._plan.spec.record}  # until nothing is missed any more
        trace = {"trace_dir": str(self._folder.trace)}
        self._start(WORLD, self._plan.world_config(self._folder.verdict) | trace | held)

    def _start_robots(self, poses: Sequence[tuple[float, float, float]]) -> None:
        homes = [Pose(*pose) for pose in poses]
        trace = {"trace_dir": str(self._folder.trace)}
        drawn = self._folder.trace / MAP_FILE
        self._runner = self._plan.runner_config(homes) | trace
        for config in self._plan.station_configs():
            self._start(f"{STATION}_{config['number']}", config)
        for config in self._plan.courier_configs(homes, self._plan.map or drawn):
            self._couriers[f"{COURIER}_{config['number']}"] = config | trace
        self._prepare_navigators(homes)
        if self._plan.spec.coordination.has_centre:
            self._start_centre(self._plan.map or drawn)
        if self._plan.spec.record:
            self._start(RECORDER, recorder_config(self._plan, self._folder.recording))
        self._open_windows()
        if self._plan.spec.has_viewer:
            spec = self._plan.spec
            self._start(VIEWER, {"host": spec.viewer_host, "port": spec.port})
        if self._plan.spec.fleet_control is not None:
            drawn = self._plan.map or self._folder.trace / MAP_FILE
            self._start(VDA5050, self._plan.vda5050_config(drawn))
        if not self._unmet:
            self._release_navigators()
        self._start(RUNNER, self._runner)
        for name, config in self._couriers.items():
            self._start(name, config)

    def _prepare_navigators(self, homes: Sequence[Pose]) -> None:
        """Write their parameters and what the fork server is to read."""
        leads_to = goals(self._runner)
        for number, (name, home) in enumerate(
            zip(self._plan.spec.robot_names, homes, strict=True), 1
        ):
            if name not in self._plan.alive:
                continue
            path = self._folder.params / f"{name}.yaml"
            tree = self._plan.parameter_file(number, home, self.map_sha256)
            write_parameter_file(path, tree)
            self._robots.append(
                {"name": name, "params": str(path), "goals": leads_to.get(name, []), "peers": []}
            )
            self._navigators.params[name] = str(path)

    def _release_navigators(self) -> None:
        self._is_released = True
        drawn = self._folder.trace / MAP_FILE
        self._configure(HOST, self._host_config(self._robots, self._plan.map or drawn))
        self._tell(HOST, Go())

    def _host_config(self, robots: Sequence[Mapping[str, Any]], map_file: Path) -> dict[str, Any]:
        return {
            "robots": robots,
            "pack": self._plan.spec.pack,
            "map": str(map_file),
            "log_dir": str(self._folder.logs),
        }

    def _open_windows(self) -> None:
        wanted = self._plan.spec.rviz_windows
        program = find_rviz(self._progress.note) if wanted else None
        for name in wanted if program else ():
            command = rviz_command(str(program), self._folder.rviz / f"{name}.rviz", name)
            self._start(f"{RVIZ}_{name}", {"command": command})
        if program and MERGED in wanted:
            self._start(f"{RVIZ}_frames", {"command": relay_command()})

    def _tell(self, name: str, command: CommandBase) -> None:
        """Send a command to a process; who drives robots for others gets the mission's, too."""
        super()._tell(name, command)
        if name == RUNNER:
            super()._tell(VDA5050, command)
            for courier, config in self._couriers.items():
                if getattr(command, "robot", "") in config["robots"]:
                    super()._tell(courier, command)
            super()._tell(CENTRAL, command)

    # What they say

    def _on_own_event(self, event: OwnEvent) -> None:
        if isinstance(event, WorldEvent):
            self._on_world_event(event)
        elif isinstance(event, NavigatorActive):
            self._on_active(event.robot)
        elif isinstance(event, NavigatorDied):
            self._on_died(event)
        elif isinstance(event, MissionEvent):
            self._on_mission_event(event)
        elif isinstance(event, OnlookerEvent):
            self._on_onlooker_event(event)
        else:
            super()._on_own_event(event)

    def _on_world_event(self, event: WorldEvent) -> None:
        match event:
            case WorldBuilt():
                self._on_world_built(event)
            case MeetingPorts():
                self._on_meeting_ports(event)
            case RobotSpawned():
                self._on_spawned(event)
            case RobotRemoved():
                self._on_removed(event)
            case RobotLate():
                self._on_late(event)
            case CollisionBegan(collision=collision):
                self._progress.breach("collisions", str(collision))
            case TimeOver():
                self._on_time_over()
            case _:
                assert_never(event)

    def _on_process_event(self, event: ProcessEvent) -> None:
        super()._on_process_event(event)
        if isinstance(event, Compiling):
            self._tell(VIEWER, KernelsCompiled(event.ready, event.known))
        elif isinstance(event, CentreReported) and CENTRAL in self._unmet:
            self._meet(CENTRAL)
        elif isinstance(event, RecordingBegun):
            self._tell(WORLD, BeginTime())

    def _on_mission_event(self, event: MissionEvent) -> None:
        match event:
            case StatusReported(robot=name):
                self._suspects.pop(name, None)
            case GoalsRestored(robot=name):
                self._progress.note(f"{name} is heard again: its goals count again")
            case GoalMissed(missed=missed):
                self._progress.breach("missed goals", str(missed))
            case MissionDone():
                self._on_mission_done()
            case StationDone():
                spec = self._plan.spec
                in_step = spec.until_done and not spec.free_run  # then couriers say when
                if self.statistics.is_done and not in_step:
                    self._on_mission_done()
            case GoalSent():
                self._has_sent = True
            case (
                MissionLoaded() | GoalReached() | GoalWithdrawn() | OrdersReported()
                | FloorReported()
            ):  # fmt: skip
                pass  # the statistics counts them
            case _:
                assert_never(event)

    def _on_mission_done(self) -> None:
        if self._plan.spec.until_done:
            self._stop("mission done, stopping")
        else:
            self._progress.phase("mission done")

    def _on_onlooker_event(self, event: OnlookerEvent) -> None:
        match event:
            case RecordingEnded(path=path, messages=messages, lost=lost):
                self._recorded = event
                self._progress.note(f"recorded {messages} messages in {path}")
                if words := lost_text(lost):
                    self._record_incident(
                        f"{words}; the {RECORDER} process or the"
                        " machine could not keep up, or was stopped for a while"
                    )
            case ViewerOpened(url=url):
                self._progress.pin(f"viewer: {url}")
                if self._plan.spec.opens_viewer:
                    open_page(url)
            case _:
                assert_never(event)

    def _on_progress(self, event: WorldProgress) -> None:
        self._has_ticked = True

    def _on_world_built(self, event: WorldBuilt) -> None:
        if not self._is_stopping:
            self._progress.phase("starting navigators")
            self.map_sha256 = event.map_sha256
            self._start_robots(event.poses)

    def _on_meeting_ports(self, event: MeetingPorts) -> None:
        """Start the navigators when they can be told where to meet world and mission."""
        for robot in self._robots:
            robot["peers"] += event.ports.get(robot["name"], [])
        self._meet(event.party)

    def _meet(self, party: str) -> None:
        """Start the navigators, unless they wait for other parties, too."""
        self._unmet.discard(party)
        if not self._unmet and not self._is_stopping and not self._is_released:
            self._release_navigators()

    def _on_spawned(self, event: RobotSpawned) -> None:
        """Start the navigator of a robot that came while the run goes on."""
        if self._is_stopping:
            return
        name, home = event.robot, Pose(*event.pose)
        self._navigated.add(name)
        path = self._folder.params / f"{name}.yaml"
        tree = self._plan.parameter_file_of_newcomer(
            name, event.number, event.model, home, self.map_sha256
        )
        write_parameter_file(path, tree)
        present = [robot for robot in self.statistics.robots if robot in self._navigated]
        write_rviz(self._folder.rviz, present, {name})
        write_foxglove(self._folder.foxglove, present, {name})
        self._navigators.params[name] = str(path)
        self._tell(HOST, StartNavigator(name, str(path)))
        self._tell(RUNNER, WatchRobot(name))
        self._progress.note(f"{name} ({event.model}) came at t = {event.sim_time:.1f} s")

    def _on_removed(self, event: RobotRemoved) -> None:
        """End the navigator of a robot that was taken out."""
        name = event.robot
        self._navigated.discard(name)
        self._navigators.remove(name)
        if self._is_stopping:
            return
        self._tell(HOST, EndNavigator(name))
        self._tell(RUNNER, RobotGone(name))
        self._progress.note(f"{name} was taken out at t = {event.sim_time:.1f} s")

    def _on_active(self, name: str) -> None:
        if self._navigators.on_active(name):
            self._tell(RUNNER, RobotHeard(name))
            self._progress.note(f"{name} is active again")
        for request in self._requests.pop(name, []):
            request.answer(f"the navigator of {name} is active again", is_done=True)
        self._record_start()

    def _record_start(self) -> None:
        """Notice that all navigators are active that are not given up."""
        awaited = set(self._plan.alive) - self._navigators.given_up
        if self.active_after_wall is None and self.statistics.active >= len(awaited):
            self._record_all_active()
            if self._plan.mission is None:
                sites = self._plan.sites
                has_goals = bool(sites.stations or sites.places)
                command = "swarm-commander" if has_goals else "swarm-teleop"
                script = shlex.quote(str(self._folder.path / "env.sh"))
                self._progress.note(
                    "all robots are active; drive one from another terminal, for example with\n"
                    f"  source {script}; {command} {self._plan.alive[0]}"
                )

    def _on_died(self, event: NavigatorDied) -> None:
        if self._is_stopping:
            return
        name = event.robot
        self._tell(WORLD, RobotDead(name))
        if self._receive_death(event):
            self._tell(RUNNER, RobotSilent(name))
        else:
            self._lose_for_good(name)

    def _lose_for_good(self, name: str) -> None:
        self._tell(RUNNER, RobotDead(name))
        for request in self._requests.pop(name, []):
            request.answer(f"the navigator of {name} died", is_done=False)
        if self._navigated <= self._navigators.given_up:
            self._stop("no robot is left")
        else:
            self._record_start()

    def _on_late(self, event: RobotLate) -> None:
        """A navigator hangs: the world waits for it no longer."""
        name, silence = event.robot, f"has not answered for {event.seconds:.0f} s"
        if self._is_stopping or name in self._navigators.down | self._navigators.given_up:
            return
        if name in self._plan.spec.driven_by_users:
            self._lose_external(name, silence)
            return
        if self._restarts.is_allowed and event.is_alone:
            self._kill_hanging(name, silence)
            return
        self._progress.note(f"{name} {silence}; nobody waits for it any longer", "yellow")
        if self._restarts.is_allowed:  # most are late: is it the machine?
            self._suspects[name] = time.monotonic() + SUSPICION

    def _lose_external(self, name: str, silence: str) -> None:
        """Count the death of a robot that a node of the user drove; a new node may go on."""
        self._fail(f"the node that drives {name} {silence}")
        self.statistics.robots[name].died = True
        self._tell(WORLD, RobotDead(name))

    def _check_suspects(self) -> None:
        now = time.monotonic()
        for name in [name for name, due in self._suspects.items() if now > due]:
            del self._suspects[name]
            if (
                not self._is_stopping
                and name not in self._navigators.down | self._navigators.given_up
            ):
                self._kill_hanging(name, "does not answer any more")

    def _kill_hanging(self, name: str, silence: str) -> None:
        self._record_incident(f"{name} {silence}: it hangs and is killed")
        self._navigators.kill(name)

    def _is_fine(self, exit_: Exit) -> bool:
        return exit_.returncode == 0 and exit_.name.split("_")[0] == RVIZ  # its window was closed

    def _on_exit(self, exit_: Exit) -> None:
        if exit_.name == HOST and not self._is_stopping:
            for name in self._navigators.on_fork_server_end():
                self.statistics.apply(NavigatorDied(name, exit_.returncode))
                self._tell(WORLD, RobotDead(name))
                self._tell(RUNNER, RobotSilent(name))
        super()._on_exit(exit_)
        if exit_.name == CENTRAL and CENTRAL in self._unmet:
            self._meet(CENTRAL)
        elif exit_.name == RECORDER:
            self._tell(WORLD, BeginTime())

    def _may_resign(self, name: str) -> bool:
        """The run is to be led by its centre: it ends if that refuses its input."""
        return name != CENTRAL and super()._may_resign(name)

    def _revives(self, exit_: Exit) -> bool:
        known = (HOST, RUNNER, CENTRAL, *self._couriers)
        if exit_.name not in known or self._refusal is not None:
            return False
        pause = self._restarts.on_death(exit_.name, time.monotonic())
        if pause is None:
            return False
        self._record_incident(
            f"the {exit_.name} process ended: {describe_exit(exit_.returncode)};"
            f" it is restarted in {pause:g} s (see {self._folder.log(exit_.name)})"
        )
        return True

    def _revive(self, name: str) -> None:
        if name == HOST and self._is_released:
            known = {robot["name"]: robot for robot in self._robots}
            robots = [
                {**known.get(robot, {}), "name": robot, "params": params}
                for robot, params in self._navigators.params.items()
                if robot not in self._navigators.given_up
            ]
            kept = self._folder.trace / MAP_FILE  # the user may have changed the other since
            self._start(HOST, self._host_config(robots, kept))
        elif name == HOST:
            self._start(HOST, {}, "--wait")
        elif name == RUNNER:
            self._revive_mission()
        elif name == CENTRAL:
            self._start_centre(self._folder.trace / MAP_FILE)
        elif name in self._couriers:
            self._revive_courier(name)

    def _start_centre(self, map_file: Path) -> None:
        params = self._folder.params / f"{self._plan.alive[0]}.yaml"
        self._start(CENTRAL, self._plan.central_config(map_file, params))

    def _revive_courier(self, name: str) -> None:
        """Restart a courier: the stations take back the orders that its robots held."""
        config = self._couriers[name]
        for robot in config["robots"]:
            self.statistics.robots[robot].drop_goal()
        self._start(name, config)
        for robot in self._navigators.down | self._navigators.given_up:
            if robot in config["robots"]:
                self._tell(name, RobotSilent(robot))

    def _revive_mission(self) -> None:
        """Restart the mission process: it continues with the goals that are not settled."""
        if not self._couriers:  # which go on
            self.statistics.on_mission_restart()
        robots = self.statistics.robots.items()
        settled = {name: robot.reached + robot.failed for name, robot in robots}
        now = {"settled": settled, "resumed_at": self.statistics.sim_time}
        self._start(RUNNER, self._runner | now)
        known = {robot["name"] for robot in self._runner["robots"]}
        for name in self.statistics.robots:
            if name not in known:
                self._tell(RUNNER, WatchRobot(name))
        for name, robot in robots:
            if robot.left:
                self._tell(RUNNER, RobotGone(name))
        for name in self._navigators.given_up:
            self._tell(RUNNER, RobotDead(name))
        for name in self._navigators.down:
            self._tell(RUNNER, RobotSilent(name))

    def _refuse(self, message: str) -> None:
        super()._refuse(self._plan.overrides.source.located(message, self._folder.params))

    def _obey(self, request: Request) -> None:
        """Restart a robot's navigator; the answer follows when it is active."""
        name = request.command.robot
        if self._is_stopping:
            request.answer("the swarm is about to end", is_done=False)
        elif name not in self._navigators.params:
            known = ", ".join(self._navigators.params) or "none on this host"
            request.answer(f"no navigator of '{name}' runs; there are {known}", is_done=False)
        else:
            self._requests.setdefault(name, []).append(request)
            self._record_incident(f"{name} is restarted, as its user wants")
            self._navigators.restart(name)

    # Time

    def _inactive(self) -> list[str]:
        """Return the robots that are not active and are not given up either."""
        return [
            name
            for name in self._plan.alive
            if not self.statistics.robots[name].active and name not in self._navigators.given_up
        ]

    def _on_time_over(self) -> None:
        """End the run; one in which the robots never were active together has failed."""
        awaited = self._plan.spec.autostart and self.active_after_wall is None
        if awaited and not self._is_stopping and (missing := self._inactive()):
            self._fail(f"time was up before these were active: {', '.join(missing)}")
        self._stop("time is up, stopping")

    def _check_start(self) -> None:
        waited = time.monotonic() - self._started
        awaited = self._plan.spec.autostart and self.active_after_wall is None
        if not awaited or self._is_stopping:
            return
        missing = self._inactive()
        if waited > START_LIMIT:
            self._fail(f"after {waited:.0f} s not active: {', '.join(missing)}")
            self._stop("stopping")
            return
        self._kill_stragglers(missing)
        settings = sorted(ros_env.FOREIGN & os.environ.keys())
        is_slow = waited > SLOW_START and len(missing) == len(self._plan.alive)
        if is_slow and settings and not ros_env.bound_address() and not self._has_hinted:
            self._has_hinted = True
            self._progress.note(
                f"no navigator is heard after {waited:.0f} s; {' and '.join(settings)} of this"
                " terminal decides who finds whom: check it, or unset it",
                "yellow",
            )

    def _check_world(self) -> None:
        """End a run whose world hangs: it speaks twice a second, also while it is paused."""
        limit = WORLD_SILENCE if self.statistics.sim_time > 0.0 else WORLD_START_SILENCE
        if self._is_stopping or WORLD not in self._children:
            return
        silence = self._heartbeats.silence(WORLD) if self._has_ticked else 0.0
        if silence > limit:
            self._fail(
                f"the {WORLD} process hangs: nothing was heard of it for {silence:.0f} s"
                f" (see {self._folder.log(WORLD)})"
            )
            self._stop("stopping")
            self._supervisor.kill_one(WORLD)

    def _check_runner(self) -> None:
        for name in (RUNNER, CENTRAL):
            if not self._is_stopping and self._heartbeats.silence(name) > RUNNER_SILENCE:
                self._heartbeats.forget(name)
                self._record_incident(f"the {name} process hangs and is killed")
                self._supervisor.kill_one(name)

    def _check_mission(self) -> None:
        if self._plan.mission is None or self.active_after_wall is None or self._is_stopping:
            return
        if self._plan.mission.orders is not None:  # whose first one may come late
            return
        waited = time.monotonic() - self._started - self.active_after_wall
        limit = MISSION_LIMIT + MISSION_LIMIT_PER_ROBOT * len(self.statistics.robots)
        if waited > limit and not self._has_sent and not self.statistics.is_done:
            log = self._folder.log(RUNNER)
            self._fail(
                f"the {RUNNER} process has sent no goal {waited:.0f} s after all robots were"
                f" active (see {log})"
            )
            self._stop("stopping")

    def _measure(self) -> None:
        self.usage.sample("world", process_tree(self._supervisor.pid(WORLD)))
        self.usage.sample("navigators", process_tree(self._supervisor.pid(HOST)))
        names = [name for name in self._children if name.split("_")[0] in OPERATOR]
        own = [one for name in names for one in process_tree(self._supervisor.pid(name))]
        self.usage.sample("operator", [psutil.Process(), *own])
        for name in (RECORDER, VIEWER, VDA5050, CENTRAL):
            if name in self._children:
                self.usage.sample(name, process_tree(self._supervisor.pid(name)))

    def _measure_last(self) -> None:
        for group, name in (("world", WORLD), ("navigators", HOST)):
            self.usage.sample_memory(group, process_tree(self._supervisor.pid(name)))
