"""A run from the first process to the report: what `swarm-up` does after its input is checked."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import psutil

from swarm_commander.breach import Crash, Miss
from swarm_commander.foxglove import write_foxglove
from swarm_commander.params import write_parameter_file
from swarm_commander.plan import RunPlan
from swarm_commander.process_run import ProcessRun
from swarm_commander.progress import Progress
from swarm_commander.recording import recorder_config
from swarm_commander.rundir import RunFolder
from swarm_commander.rviz import find_rviz, rviz_command, write_rviz
from swarm_commander.supervisor import Exit, describe_exit
from swarm_commander.tally import Tally
from swarm_commander.usage import process_tree
from swarm_common import ros_env
from swarm_common.map_io import MAP_FILE
from swarm_common.records import Pose

WORLD, HOST, RUNNER, RECORDER = "world", "navigators", "mission", "recorder"
RVIZ, VIEWER = "rviz", "viewer"
MODULES = {
    WORLD: "swarm_sim.node",
    HOST: "swarm_nav.host",
    RUNNER: "swarm_commander.runner",
    RECORDER: "swarm_recording.recorder",
    RVIZ: "swarm_commander.window",
    VIEWER: "swarm_view.process",
}
MEETING = (WORLD, RUNNER)  # who the navigators of a large swarm are told of, see `participants`
STOP_ORDER = (WORLD, RUNNER, RECORDER, HOST)  # the world first, so that nobody is late for it
ONLOOKERS = (RECORDER, RVIZ, VIEWER)  # the run goes on without them
START_LIMIT = 600.0  # [s] for all to be active; the first start compiles the kernels
MISSION_LIMIT = 60.0  # [s] from then to the mission's first goal,
MISSION_LIMIT_PER_ROBOT = 1.0  # [s] and this much more for each robot to connect to


class Run(ProcessRun):
    """A run on one host: world, navigators, mission."""

    stop_order: Sequence[str] = STOP_ORDER
    onlookers: Sequence[str] = ONLOOKERS

    def __init__(
        self,
        plan: RunPlan,
        folder: RunFolder,
        progress: Progress,
        tally: Tally,
        modules: Mapping[str, str] = MODULES,
    ) -> None:
        super().__init__(folder, progress, tally, modules)
        self._plan = plan
        self._navigated = set(plan.alive)  # robots that have a navigator, or had one that died
        self._unmet = set(MEETING) if ros_env.is_large(plan.options.swarm_size) else set()
        self.map_sha256 = ""  # of the map that the world will send
        self._robots: list[dict[str, Any]] = []  # what the nursery is to start

    def _check(self) -> None:
        self._check_start()
        self._check_mission()

    def _begin(self) -> None:
        trace = {"trace_dir": str(self._folder.trace)}
        self._start(WORLD, self._plan.world_config(self._folder.verdict) | trace)
        self._start(HOST, {}, "--wait")  # imports and compiles meanwhile

    # Processes

    def _start_robots(self, poses: list[list[float]]) -> None:
        homes = [Pose(*pose) for pose in poses]
        self._prepare_navigators(homes)
        if self._plan.options.record:
            self._start(RECORDER, recorder_config(self._plan, self._folder.recording))
        self._open_windows()
        if self._plan.options.viewer:
            self._start(VIEWER, self._plan.viewer_config())
        if not self._unmet:
            self._release_navigators()
        trace = {"trace_dir": str(self._folder.trace)}
        self._start(RUNNER, self._plan.runner_config(homes) | trace)

    def _prepare_navigators(self, homes: Sequence[Pose]) -> None:
        """Write their parameters and what the nursery is to read."""
        for number, (name, home) in enumerate(
            zip(self._plan.options.robot_names, homes, strict=True), 1
        ):
            if name not in self._plan.alive:
                continue
            path = self._folder.params / f"{name}.yaml"
            tree = self._plan.parameter_file(number, home, self.map_sha256)
            write_parameter_file(path, tree)
            self._robots.append({"name": name, "params": str(path), "peers": []})

    def _release_navigators(self) -> None:
        config = {
            "robots": self._robots,
            "pack": self._plan.options.pack,
            "map": str(self._plan.map or self._folder.trace / MAP_FILE),
            "log_dir": str(self._folder.logs),
        }
        self._configure(HOST, config)
        self._children[HOST].tell({"cmd": "go"})

    def _open_windows(self) -> None:
        wanted = self._plan.options.rviz
        program = find_rviz(self._progress.note) if wanted else None
        for name in wanted if program else ():
            command = rviz_command(str(program), self._folder.rviz / f"{name}.rviz", name)
            self._start(f"{RVIZ}_{name}", {"command": command})

    # What they say

    def _on_spawn_event(self, event: dict[str, Any]) -> None:
        if not self._is_stopping:
            self._progress.phase("starting navigators")
            self.map_sha256 = str(event.get("map_sha256", ""))
            self._start_robots(event["poses"])

    def _on_meeting_event(self, event: dict[str, Any]) -> None:
        """Start the navigators when they can be told where to meet world and mission."""
        for robot in self._robots:
            robot["peers"] += event["ports"].get(robot["name"], [])
        self._unmet.discard(event["party"])
        if not self._unmet and not self._is_stopping:
            self._release_navigators()

    def _on_spawned_event(self, event: dict[str, Any]) -> None:
        """Start the navigator of a robot that came while the run goes on."""
        if self._is_stopping:
            return
        name, home = event["robot"], Pose(*event["pose"])
        self._navigated.add(name)
        path = self._folder.params / f"{name}.yaml"
        tree = self._plan.parameter_file_of_newcomer(
            name, int(event["number"]), event["model"], home, self.map_sha256
        )
        write_parameter_file(path, tree)
        present = sorted(self._navigated, key=lambda robot: (len(robot), robot))
        write_rviz(self._folder.rviz, present, {name})
        write_foxglove(self._folder.foxglove, present, {name})
        self._children[HOST].tell({"cmd": "start", "robot": name, "params": str(path)})
        self._children[RUNNER].tell({"cmd": "watch", "robot": name})
        self._progress.note(f"{name} ({event['model']}) came at {_seconds(event)}")

    def _on_removed_event(self, event: dict[str, Any]) -> None:
        """End the navigator of a robot that was taken out."""
        name = event["robot"]
        self._navigated.discard(name)
        if self._is_stopping:
            return
        self._children[HOST].tell({"cmd": "end", "robot": name})
        self._children[RUNNER].tell({"cmd": "removed", "robot": name})
        self._progress.note(f"{name} was taken out at {_seconds(event)}")

    def _on_active_event(self, _: dict[str, Any]) -> None:
        if self.tally.active == len(self._plan.alive) and self.active_after_wall is None:
            self.active_after_wall = time.time() - self._started
            self._sample(now=True)
            self.usage.mark()
            self._progress.phase("running")
            if self._plan.mission is None:
                self._progress.note(
                    "all robots are active; drive one from another terminal, for example with\n"
                    f"  source {self._folder.path / 'env.sh'}; swarm-commander Srobot1"
                )

    def _on_died_event(self, event: dict[str, Any]) -> None:
        if self._is_stopping:
            return
        message = f"{event['robot']} died: {describe_exit(int(event['returncode']))}"
        self._fail(f"{message}; its log is in {self._folder.logs}")
        self._children[WORLD].tell({"cmd": "dead", "robot": event["robot"]})
        if RUNNER in self._children:
            self._children[RUNNER].tell({"cmd": "dead", "robot": event["robot"]})
        if all(self.tally.robots[name].died for name in self._navigated):
            self._stop("no robot is left")

    def _on_collision_event(self, event: dict[str, Any]) -> None:
        self._progress.breach("collisions", str(Crash.of(event)))

    def _on_goal_event(self, event: dict[str, Any]) -> None:
        if event["outcome"] != "reached":
            self._progress.breach("missed goals", str(Miss.of(event)))

    def _on_recorded_event(self, event: dict[str, Any]) -> None:
        self._progress.note(f"recorded {event['messages']} messages in {event['path']}")

    def _on_viewer_event(self, event: dict[str, Any]) -> None:
        self._progress.note(f"viewer: {event['url']}")

    def _on_done_event(self, _: dict[str, Any]) -> None:
        if self._plan.options.until_done:
            self._stop("mission done, stopping")
        else:
            self._progress.phase("mission done")

    def _on_over_event(self, _: dict[str, Any]) -> None:
        self._stop("time is up, stopping")

    def _is_fine(self, exit_: Exit) -> bool:
        if exit_.returncode != 0:
            return False
        if exit_.name == WORLD:  # --duration is over
            self._stop("time is up, stopping")
            return True
        return exit_.name.split("_")[0] == RVIZ  # somebody closed the window

    # Time

    def _check_start(self) -> None:
        waited = time.time() - self._started
        awaited = self._plan.options.autostart and self.active_after_wall is None
        if not awaited or self._is_stopping:
            return
        missing = [name for name in self._plan.alive if not self.tally.robots[name].active]
        if waited > START_LIMIT:
            self._fail(f"after {waited:.0f} s not active: {', '.join(missing)}")
            self._stop("stopping")
        else:
            self._renew_laggards(HOST, waited, missing)

    def _check_mission(self) -> None:
        if self._plan.mission is None or self.active_after_wall is None or self._is_stopping:
            return
        waited = time.time() - self._started - self.active_after_wall
        limit = MISSION_LIMIT + MISSION_LIMIT_PER_ROBOT * len(self.tally.robots)
        if waited > limit and not self.tally.sent and not self.tally.is_done:
            log = self._folder.log(RUNNER)
            self._fail(
                f"the {RUNNER} process has sent no goal {waited:.0f} s after all robots were"
                f" active (see {log})"
            )
            self._stop("stopping")

    def _measure(self) -> None:
        self.usage.sample("world", process_tree(self._supervisor.pid(WORLD)))
        self.usage.sample("navigators", process_tree(self._supervisor.pid(HOST)))
        own = [psutil.Process(), *process_tree(self._supervisor.pid(RUNNER))]
        self.usage.sample("operator", own)
        for name in (RECORDER, VIEWER):
            if name in self._children:
                self.usage.sample(name, process_tree(self._supervisor.pid(name)))

    def _measure_last(self) -> None:
        for group, name in (("world", WORLD), ("navigators", HOST)):
            self.usage.sample_private(group, process_tree(self._supervisor.pid(name)))


def _seconds(event: Mapping[str, Any]) -> str:
    return f"t = {float(event['sim_time']):.1f} s"
