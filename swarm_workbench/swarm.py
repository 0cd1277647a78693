"""A swarm, as processes with ROS or in this process on the bench: the same object."""

from __future__ import annotations

import sys
import threading
import webbrowser
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from rich.progress import Progress

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.methods import METHODS
from swarm_bench.runs.scenario import Scenario, check_size
from swarm_common.files.convert import convert
from swarm_common.model.breaches import Collision
from swarm_common.model.central import Coordination
from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose
from swarm_run.spec import DRIVES, RunSpec
from swarm_workbench import picture
from swarm_workbench.backend import Backend
from swarm_workbench.bench import BenchBackend
from swarm_workbench.history import RunTables
from swarm_workbench.place import Places
from swarm_workbench.report import Report
from swarm_workbench.robot import Robot
from swarm_workbench.trajectories import Trajectories
from swarm_workbench.world import World

CHUNK = 5  # ticks that pass at a time while somebody waits for a goal
COORDINATIONS = [name.value for name in Coordination if name is not Coordination.FLEET]


class Swarm:
    """Robots in a world; use it in a `with` block, or call `start` and `close`."""

    def __init__(
        self,
        robots: int | None = None,
        world: str | Path | World = "slim_blockage",
        *,
        bench: bool = False,
        robot: str = "turtlebot3_waffle",
        fleet: str | Path | None = None,
        mission: str | None = None,
        seed: int = 0,
        brain: str = "ours",
        drive: str | None = None,
        speed: float | None = None,
        realistic: bool = False,
        parameters: Mapping[str, Any] | None = None,
        run_dir: str | Path | None = None,
        viewer: bool = False,
        external: Sequence[str] = (),
        coordination: str = Coordination.DECENTRAL.value,
    ) -> None:
        """Describe a swarm; `start` or the `with` block starts it.

        Args:
            robots: Number of robots; None for that of the fleet, or 5.
            world: Name, file or folder of a world, or a `World`.
            bench: Whether all is in this process, without ROS.
            robot: Model of all robots, where there is no fleet.
            fleet: Name or file of a fleet of several models.
            mission: Name or file of a mission; None for robots that wait for goals.
            brain: What decides for each robot: ours, `module:Class`, or the file of a policy, like
                policy.onnx; on the bench dwa and orca, too.
            drive: wheels or planar; None for planar on the bench, else that of swarm-up.
            speed: Times real time, at most; None for as fast as possible. Not on the bench.
            realistic: Whether sensors err, and robots localise by AMCL.
            parameters: Navigators' parameters by dotted name, in place of the defaults.
            run_dir: Folder of the run; None for a new one in runs/. Not on the bench.
            viewer: Whether `show` is going to be used. Not on the bench.
            external: Names of robots that an `ExternalRobot` each drives. Not on the bench.
            coordination: Who decides: decentral, central or central-with-fallback.

        Raises:
            SwarmError: If options exclude each other.
        """
        if bench and (viewer or external or speed is not None or run_dir is not None):
            raise ConfigError(
                "viewer, speed, run_dir and external are for processes; leave out bench=True"
            )
        if not bench and brain in METHODS and brain != "ours":
            raise ConfigError(f"brain '{brain}' runs on the bench only: add bench=True")
        if coordination not in COORDINATIONS:
            raise UnknownNameError("coordination", coordination, COORDINATIONS)
        if coordination != Coordination.DECENTRAL and brain != "ours":
            raise ConfigError(f"a centre leads our own navigators, not brain '{brain}'")
        if drive is not None and drive not in DRIVES:
            raise UnknownNameError("drive", drive, DRIVES)
        self._brain, self._is_bench = brain, bench
        own = {} if bench or brain in METHODS else {"brain.plugin": brain}
        if robots is not None:
            check_size(robots, "robots")
        self._spec = RunSpec(
            swarm_size=robots,
            world=str(world.file if isinstance(world, World) else world),
            robot=None if fleet is not None else robot,
            fleet=None if fleet is None else str(fleet),
            mission=mission,
            seed=seed,
            drive=drive,
            speed="max" if speed is None else speed,
            realistic=realistic,
            parameters={**(parameters or {}), **own},
            run_dir=None if run_dir is None else str(run_dir),
            viewer=viewer,
            external=tuple(external),
            coordination=Coordination(coordination),
        )
        self._backend: Backend | None = None
        self._places: Places | None = None
        self._robots: dict[str, Robot] = {}
        self._lock = threading.RLock()  # one thread at a time lets time pass
        self._last_report: Report | None = None
        self._trajectories: Trajectories | None = None
        self._history: RunTables | None = None
        self._collisions: Sequence[Collision] = ()

    # From start to end

    def start(self) -> Swarm:
        """Start it and wait until every robot takes goals.

        Raises:
            SwarmError: If something is unusable, or does not start; nothing is left running.
        """
        if self._backend is not None or self._last_report is not None:
            raise SwarmError("a Swarm starts once; make another one")
        self._backend = backend = self._bench() if self._is_bench else self._graph()
        self._history = backend.history
        self._places = Places(backend.grid, backend.sites.stations)
        for index, name in enumerate(backend.names):
            self._robots[name] = Robot(name, index, self._running, self._known_places, self._chunk)
        return self

    def close(self) -> None:
        """End it; the report and the trajectories stay."""
        with self._lock:
            backend, self._backend = self._backend, None
            if backend is None:
                return
            try:
                backend.close()
            finally:
                self._last_report = backend.report()
                self._trajectories = backend.trajectories()
                self._collisions = backend.collisions()

    def __enter__(self) -> Swarm:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _bench(self) -> Backend:
        spec, fleet = self._spec, self._spec.loaded_fleet
        scenario = Scenario(
            name="swarm",
            world=spec.world,
            mission=spec.mission or "",
            robots=(spec.size,),
            robot=spec.model,
            fleet=tuple(member.model for member in fleet.members) if fleet else (),
            with_lidar=True,
            noise=0.0,
        )
        is_led = spec.coordination is not Coordination.DECENTRAL
        led = {"traffic.coordination": spec.coordination.value} if is_led else {}
        options = RunOptions(
            scenario=scenario,
            robots=spec.size,
            seed=spec.seed,
            method="central-reservation" if is_led else self._brain,
            engine=DRIVES[spec.drive or "planar"],
            parameters={**spec.parameters, **led},
            realistic=spec.realistic,
        )
        return BenchBackend(options)

    def _graph(self) -> Backend:
        from swarm_workbench.graph import GraphBackend

        return GraphBackend(self._spec)

    # Robots

    def __getitem__(self, name: str) -> Robot:
        self._running()
        if name not in self._robots:
            raise UnknownNameError("robot", str(name), self._robots)
        return self._robots[name]

    def __iter__(self) -> Iterator[Robot]:
        return iter(list(self._robots.values()))

    def __len__(self) -> int:
        return len(self._robots)

    @property
    def names(self) -> Sequence[str]:
        """Names of the robots, in order."""
        return tuple(self._robots)

    @property
    def stations(self) -> Mapping[str, Pose]:
        """Poses in map of the world's stations, by name."""
        return self._running().sites.stations

    # Time

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._running().tick * CONTROL_PERIOD

    def run(
        self, until: float | None = None, *, seconds: float | None = None, progress: bool = False
    ) -> None:
        """Let time pass.

        Args:
            until: [s] of simulated time since the start.
            seconds: [s] from now, in place of `until`.
            progress: Whether to show a bar, also in a notebook.

        Raises:
            SwarmError: If neither or both are given, `until` is over, or the swarm has ended.
        """
        if (until is None) == (seconds is None):
            raise ConfigError("run needs until=… or seconds=…, and not both")
        span = convert(until if seconds is None else seconds, float, "until or seconds")
        end = span if seconds is None else self.time + span
        if not np.isfinite(end) or end < self.time - 1e-6:
            raise ConfigError(f"it is t = {self.time:.1f} s already; run until a later time")
        last = round(end / CONTROL_PERIOD)
        total = last - self._running().tick
        with Progress(disable=not progress) as bar:
            task = bar.add_task("simulated time", total=total)
            while (left := last - self._running().tick) > 0:
                self._chunk(min(left, CHUNK))
                bar.update(task, completed=total - left)

    def _chunk(self, ticks: int = CHUNK) -> int:
        """Let a few ticks pass; return the tick that is reached."""
        with self._lock:
            backend = self._running()
            backend.advance(ticks)
            return backend.tick

    # Results

    @property
    def true_poses(self) -> FloatArray:
        """x, y [m], yaw [rad] in map of each robot (n, 3)."""
        return self._running().true_poses()

    @property
    def poses(self) -> FloatArray:
        """Likewise what the robots believe."""
        return self._running().estimated_poses()

    @property
    def report(self) -> Report:
        """Figures so far; after the end, of the whole run."""
        if self._backend is None and self._last_report is not None:
            return self._last_report
        return self._running().report()

    @property
    def domain(self) -> int | None:
        """ROS domain of the swarm; None on the bench."""
        return self._running().domain

    @property
    def folder(self) -> Path | None:
        """Folder of the run; None on the bench."""
        return self._running().folder

    @property
    def trajectories(self) -> Trajectories:
        """Where every robot was at each tick so far."""
        return self._trajectories or self._running().trajectories()

    @property
    def states(self) -> Any:
        """Table of each robot's changes of state: t, robot, state, detail."""
        return self._kept_history().states()

    @property
    def waits(self) -> Any:
        """Table of waits for other robots: t, robot, other, duration [s]."""
        return self._kept_history().waits()

    @property
    def events(self) -> Any:
        """Table of goals reached and failed, and of contacts: t, robot, event, detail.

        Processes tell contacts after the end.
        """
        backend = self._backend
        collisions = self._collisions if backend is None else backend.collisions()
        return self._kept_history().events(collisions)

    def plot(self, axes: Any = None) -> Any:
        """Draw map, paths and stations by matplotlib; return the axes."""
        backend = self._running()
        return picture.draw(backend.grid, backend.sites.stations, self.trajectories, axes)

    def film(self, path: str | Path = "run.gif", *, speed: float = 5.0) -> Any:
        """Write a film of the run so far; return its path, in a notebook the film.

        Args:
            path: A GIF; MP4 or WebM need ffmpeg.
            speed: Speed of the film, in multiples of real time.

        Raises:
            SwarmError: If it cannot be written.
        """
        file, radii = Path(path), [spec.circumscribed_radius for spec in self._running().specs]
        picture.film(self._running().grid, radii, self.trajectories, file, speed)
        if "ipykernel" not in sys.modules:
            return file
        from IPython.display import Image, Video

        return Image(file) if file.suffix == ".gif" else Video(file, embed=True)

    def show(self) -> Any:
        """Show the viewer: inline in a notebook, else in the browser; return what it shows.

        Raises:
            SwarmError: If the swarm was made without viewer=True.
        """
        url = self._running().url
        if not url:
            raise SwarmError("there is no viewer: make the Swarm with viewer=True, or use plot()")
        if "ipykernel" in sys.modules:
            from IPython.display import IFrame

            return IFrame(url, width="100%", height=500)
        webbrowser.open(url)
        return url

    def _running(self) -> Backend:
        if self._backend is None:
            raise SwarmError(
                "the swarm does not run: use it inside its with block, or between start() and"
                " close()"
            )
        return self._backend

    def _kept_history(self) -> RunTables:
        if self._history is None:
            self._running()
        assert self._history is not None
        return self._history

    def _known_places(self) -> Places:
        self._running()
        assert self._places is not None
        return self._places
