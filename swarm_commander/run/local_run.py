"""A run from the first process to the report: what `swarm-up` does after its input is checked."""

from __future__ import annotations

from typing import Any

from swarm_commander.run.own_navigators import Navigators
from swarm_commander.run.process_table import (
    CENTRAL,
    COURIER,
    HOST,
    MEETING,
    RECORDER,
    RUNNER,
    VIEWER,
    WORLD,
    Start,
    kind_of,
)
from swarm_commander.run.processes.supervisor import Exit
from swarm_commander.run.supervision import RunPart, Supervision
from swarm_common.files.map_io import MAP_FILE
from swarm_common.middleware import ros_env
from swarm_common.model.records import Pose
from swarm_common.model.run_words import lost_text
from swarm_common.process import messages as say
from swarm_common.process.start import open_page
from swarm_mission.orders.order_book import OrderBook
from swarm_run.plan import RunPlan

WORLD_SILENCE = 20.0  # [s] of wall time without a word after which the world hangs,
WORLD_START_SILENCE = 60.0  # [s] before its first step, when it may have to compile
MISSION_LIMIT = 60.0  # [s] from all robots being active to the mission's first goal, or to time,
MISSION_LIMIT_PER_ROBOT = 1.0  # [s] and this much more for each robot to connect to


class LocalRun(RunPart):
    """World, mission and onlookers of this host; the navigators may be on others."""

    def __init__(self, plan: RunPlan, run: Supervision, navigators: Navigators) -> None:
        run.awaits_activity = plan.spec.autostart
        self._plan = plan
        self._run = run
        self._navigators = navigators
        self._start: Start | None = None  # known when the world is built
        self._has_ticked = False
        self._recorded: say.RecordingEnded | None = None
        self._judged: say.FleetJudged | None = None
        self._is_released = False  # whether the navigators were told to start
        self._has_sent = False  # whether a mission process has, be it one that died since
        spec = plan.spec
        onlookers = {  # without whom time does not begin: they are to see all of it
            RECORDER: spec.record,
            RUNNER: plan.mission is None and not spec.driven_by_users,
        }
        self._onlookers = {name for name, is_awaited in onlookers.items() if is_awaited}
        self._unmet = set(MEETING) if ros_env.is_large(plan.spec.size) else set()
        if plan.spec.coordination.has_centre:
            self._unmet.add(CENTRAL)
        if plan.mission is not None and (orders := plan.mission.orders) is not None:
            run.statistics.orders = OrderBook(orders.dispatch, plan.remarks)
            run.statistics.stations_left = set(orders.stations)

    # Processes

    def begin(self) -> None:
        """Start the world."""
        for remark in self._plan.remarks:
            self._run.progress.note(remark, "yellow")
        for name in self._plan.spec.driven_by_users:
            self._run.progress.note(f"time begins when a node drives {name}; missions leave it out")
        folder = self._run.folder
        more = {"trace_dir": str(folder.trace), "held": bool(self._onlookers)}
        self._run.start(WORLD, self._plan.world_config(folder.verdict) | more)

    def _on_world_built(self, event: say.WorldBuilt) -> None:
        run, homes = self._run, [Pose(*pose) for pose in event.poses]
        run.progress.phase("starting navigators")
        self._start = start = Start(self._plan, run.folder, homes, run.progress.note)
        self._navigators.prepare(homes, event.map_sha256)
        for row in run.table:
            if row.wanted is not None:
                run.start_all(row.wanted(start))
        self._meet()

    def _meet(self, party: str = "") -> None:
        """Start the navigators, unless they wait for other parties, too."""
        self._unmet.discard(party)
        is_due = not self._unmet and not self._is_released and not self._run.is_stopping
        if self._start is not None and is_due:
            self._is_released = True
            self._navigators.release(str(self._start.map_file))

    def _see(self, onlooker: str) -> None:
        """Let time begin once all are there that are to see it."""
        self._onlookers.discard(onlooker)
        if not self._onlookers:
            self._run.tell(WORLD, say.BeginTime())

    def on_exit(self, exit_: Exit) -> None:
        """Go on without a centre or a recorder that ended."""
        if exit_.name == CENTRAL:
            self._meet(CENTRAL)
        elif exit_.name == RECORDER:
            self._see(RECORDER)

    def on_stop(self, phase: str) -> None:
        """Let no tick follow while processes end."""
        self._run.tell(WORLD, say.EndTime())

    def restart(self, name: str, config: dict[str, Any]) -> None:
        """Restart a process; its map is the run's own, as the user may have changed the other."""
        if "map" in config:
            config = config | {"map": str(self._run.folder.trace / MAP_FILE)}
        if name == HOST:
            self._navigators.restart_server(config)
        elif name == RUNNER:
            self._restart_mission(config)
        elif kind_of(name) == COURIER:
            self._restart_courier(name, config)
        else:
            self._run.start(name, config)

    def _restart_courier(self, name: str, config: dict[str, Any]) -> None:
        """Restart a courier: the stations take back the orders that its robots held."""
        for robot in config["robots"]:
            self._run.statistics.robots[robot].drop_goal()
        self._run.start(name, config)
        for robot in self._navigators.down | self._navigators.lost:
            if robot in config["robots"]:
                self._run.tell(name, say.RobotSilent(robot))

    def _restart_mission(self, config: dict[str, Any]) -> None:
        """Restart the mission process: it continues with the goals that are not settled."""
        run, statistics = self._run, self._run.statistics
        if not self._plan.has_orders:  # whose couriers go on
            statistics.on_mission_restart()
        robots = statistics.robots.items()
        settled = {name: robot.reached + robot.failed for name, robot in robots}
        run.start(RUNNER, config | {"settled": settled, "resumed_at": statistics.sim_time})
        known = {robot["name"] for robot in config["robots"]}
        commands = [
            *(say.WatchRobot(name) for name, _ in robots if name not in known),
            *(say.RobotGone(name) for name, robot in robots if robot.left),
            *(say.RobotDead(name) for name in self._navigators.lost),
            *(say.RobotSilent(name) for name in self._navigators.down),
        ]
        for command in commands:
            run.tell_of(command)

    # What they say

    def on_event(self, event: say.Event) -> bool:
        """Handle what world, mission and onlookers report; others are navigators' events."""
        run = self._run
        match event:
            case say.WorldBuilt():
                if not run.is_stopping:
                    self._on_world_built(event)
            case say.MeetingPorts(party=party, ports=ports):
                self._navigators.meet(ports)
                self._meet(party)
            case say.WorldProgress():
                self._has_ticked = True
            case say.RobotRemoved(robot=name, sim_time=sim_time):
                if not run.is_stopping:
                    run.tell_of(say.RobotGone(name))
                    run.progress.note(f"{name} was taken out at t = {sim_time:.1f} s")
            case say.CollisionBegan(collision=collision):
                run.progress.breach("collisions", str(collision))
            case say.TimeOver():
                self._on_time_over()
            case say.Compiling(ready=ready, known=known):
                run.tell(VIEWER, say.KernelsCompiled(ready, known))
            case say.CentreReported():
                self._meet(CENTRAL)
            case say.GoalsRestored(robot=name):
                run.progress.note(f"{name} is heard again: its goals count again")
            case say.GoalMissed(missed=missed):
                run.progress.breach("missed goals", str(missed))
            case say.MissionDone():
                self._on_mission_done()
            case say.StationDone():
                spec = self._plan.spec
                in_step = spec.until_done and not spec.free_run  # then couriers say when
                if run.statistics.is_done and not in_step:
                    self._on_mission_done()
            case say.GoalSent():
                self._has_sent = True
            case say.MissionLoaded() | say.GoalReached() | say.GoalWithdrawn():
                pass  # the statistics counts them
            case say.StatusReported() | say.OrdersReported() | say.FloorReported():
                pass
            case say.SwarmHeard():
                self._see(RUNNER)
            case say.RecordingBegun():
                self._see(RECORDER)
            case say.RecordingEnded():
                self._on_recording_ended(event)
            case say.FleetJudged(text=text, file=file):
                self._judged = event
                run.progress.note(f"{text} ({file})")
            case say.ViewerOpened(url=url):
                run.progress.pin(f"viewer: {url}")
                if self._plan.spec.opens_viewer:
                    open_page(url)
            case _:
                return False
        return True

    def _on_mission_done(self) -> None:
        if self._plan.spec.until_done:
            self._run.stop("mission done, stopping")
        else:
            self._run.progress.phase("mission done")

    def _on_recording_ended(self, event: say.RecordingEnded) -> None:
        self._recorded = event
        self._run.progress.note(f"recorded {event.messages} messages in {event.path}")
        if words := lost_text(event.lost):
            self._run.record_incident(
                f"{words}; the {RECORDER} process or the machine could not keep up, or was stopped"
                " for a while"
            )

    def _on_time_over(self) -> None:
        """End the run; one in which the robots never were active together has failed."""
        missing = self._navigators.missing()
        if self._run.never_active and not self._run.is_stopping and missing:
            self._run.fail(f"time was up before these were active: {', '.join(missing)}")
        self._run.stop("time is up, stopping")

    # Time

    def check(self) -> None:
        """Look for what should have happened by now."""
        self._check_mission()
        self._check_world()

    def _check_world(self) -> None:
        """End a run whose world hangs: it speaks twice a second, also while it is paused."""
        run = self._run
        limit = WORLD_SILENCE if run.statistics.sim_time > 0.0 else WORLD_START_SILENCE
        if self._has_ticked and not run.is_stopping and (silence := run.silence(WORLD)) > limit:
            run.fail(
                f"the {WORLD} process hangs: nothing was heard of it for {silence:.0f} s"
                f" (see {run.folder.log(WORLD)})"
            )
            run.stop("stopping")
            run.kill(WORLD)

    def _check_mission(self) -> None:
        """Notice who should have begun by now: onlookers, and a mission that has no orders."""
        run, mission = self._run, self._plan.mission
        if run.active_after_wall is None or run.is_stopping:
            return
        waited = run.elapsed - run.active_after_wall
        if waited <= MISSION_LIMIT + MISSION_LIMIT_PER_ROBOT * len(run.statistics.robots):
            return
        for name in sorted(self._onlookers):
            run.fail(
                f"the {name} process does not hear the robots {waited:.0f} s after all were"
                f" active: time begins without it (see {run.folder.log(name)})"
            )
            self._see(name)
        is_idle = not (self._has_sent or run.statistics.is_done)
        # The first order may come late.
        if mission is not None and mission.orders is None and is_idle:
            run.fail(
                f"the {RUNNER} process has sent no goal {waited:.0f} s after all robots were"
                f" active (see {run.folder.log(RUNNER)})"
            )
            run.stop("stopping")

    def complete(self, report: dict[str, Any]) -> None:
        """Put what the recording has and lacks into the report, and the robots' hosts."""
        if (told := self._recorded) is not None:
            lost = {"lost": told.lost, "missing": told.missing}
            report["recording"] = {"messages": told.messages, **lost}
        if (judged := self._judged) is not None:
            report["fleet_control"] = {"verdict": judged.text, "is_failed": judged.is_failed}
        self._navigators.complete(report)

    def located(self, message: str) -> str:
        """Return a refusal that names the user's own file."""
        return self._plan.overrides.source.located(message, self._run.folder.params)
