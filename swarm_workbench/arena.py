"""Worlds to learn in: twists in, poses, scans and contacts out; with or without a shield."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from swarm_bench.runs.episode import RunOptions, nav_config, robot_named, setup_of
from swarm_bench.runs.scenario import Scenario
from swarm_common.model.errors import SwarmError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Mask, Pose, Twist
from swarm_describe.worlds.actors import WalkerSpec
from swarm_run.loop import Loop
from swarm_sim.world.setup import WorldSetup
from swarm_sim.world.world import World
from swarm_workbench.steered import SteeredNavigator
from swarm_workbench.world import load_world


class Arena(Protocol):
    """Robots that obey twists.

    Attributes:
        ranges: (n, rays) [m] of the latest scans; inf where nothing was hit.
        can_place: Whether a robot can be put elsewhere while the others drive on.
    """

    ranges: NDArray[np.float32]
    can_place: bool

    @property
    def world(self) -> World:
        """Where the robots are, with their true poses and clearances."""

    @property
    def twists(self) -> FloatArray:
        """True vx, wz, vy (n, 3) [m/s, rad/s, m/s]."""

    def reset(self, starts: FloatArray, people: Sequence[WalkerSpec], seed: int) -> None:
        """Put n robots at poses (n, 3), standing, at tick 0, among people."""

    def place(self, poses: Mapping[int, FloatArray]) -> None:
        """Put robots at poses (3,), standing, with a scan of what is around them."""

    def step(self, twists: FloatArray, looks: bool = True) -> Mask:
        """Drive towards twists (n, 3) for a tick; return who touches something.

        Args:
            looks: Whether the scans of this tick, if any, are going to be read.
        """


class _OpenWorld(World):
    """A world that takes twists and can begin anew; it has no radio, odometry or verdict."""

    def begin(self, starts: FloatArray) -> None:
        """Put the robots at poses (n, 3), standing, at tick 0."""
        self._tick = 0
        for robot, pose in enumerate(starts):
            self._engine.place(robot, pose)

    def place(self, robot: int, pose: FloatArray) -> None:
        """Put a robot at a pose (3,), standing."""
        self._engine.place(robot, pose)

    def drive(self, targets: FloatArray) -> Mask:
        """Advance one tick towards twists (n, 3); return who touches something."""
        contacts = np.zeros(len(self.specs), np.bool_)
        for touch in self._engine.advance(targets):
            contacts[touch.robot] = True
            if touch.other >= 0:
                contacts[touch.other] = True
        self._tick += 1
        return contacts

    def take_scans(self, ranges: NDArray[np.float32], only: Collection[int] = ()) -> None:
        """Write the scans that are due at this tick; or those of some robots, as if they were."""
        assert self._lidars is not None
        tick, everywhere = (0, ranges.copy()) if only else (self._tick, ranges)
        place = self._engine.poses, self._walkers.discs
        for group, measured in self._lidars.measured(tick, *place):
            everywhere[group.members] = measured
        for robot in only:
            ranges[robot] = everywhere[robot]

    @property
    def twists(self) -> FloatArray:
        """True vx, wz, vy (n, 3)."""
        return self._engine.twists

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy needs: without the judge, whose digest cannot be copied."""
        return {name: value for name, value in vars(self).items() if name != "_judge"}


class OpenArena:
    """Nobody holds a robot back from hitting something."""

    can_place = True

    def __init__(self, world: str, robot: str) -> None:
        self._names = world, robot
        self._world: _OpenWorld | None = None
        self._has_people = False
        self._rays = robot_named(robot).lidar.rays

    @property
    def world(self) -> World:
        """The world."""
        assert self._world is not None
        return self._world

    @property
    def twists(self) -> FloatArray:
        """True vx, wz, vy (n, 3)."""
        assert self._world is not None
        return self._world.twists

    def reset(self, starts: FloatArray, people: Sequence[WalkerSpec], seed: int) -> None:
        """Put the robots at poses (n, 3), standing, at tick 0."""
        count, world = len(starts), self._world
        if world is None or people or self._has_people or len(world.specs) != count:
            options = options_of(*self._names, count, seed)
            world = self._world = _setup(options, starts, people).start(_OpenWorld)
            self.ranges = np.full((count, self._rays), np.inf, np.float32)
        self._has_people = bool(people)
        world.begin(starts)
        world.take_scans(self.ranges)

    def place(self, poses: Mapping[int, FloatArray]) -> None:
        """Put robots at poses (3,), standing, with a scan of what is around them."""
        assert self._world is not None
        for robot, pose in poses.items():
            self._world.place(robot, pose)
        self._world.take_scans(self.ranges, only=poses)

    def step(self, twists: FloatArray, looks: bool = True) -> Mask:
        """Drive towards twists (n, 3) for a tick; return who touches something."""
        assert self._world is not None
        contacts = self._world.drive(twists)
        if looks:
            self._world.take_scans(self.ranges)
        return contacts


class ShieldedArena:
    """Each robot drives inside space that it has reserved, through its navigator's stop filter."""

    can_place = False  # its navigator would not know why

    def __init__(self, world: str, robot: str) -> None:
        self._names = world, robot
        self._rays = robot_named(robot).lidar.rays
        self._world: World | None = None

    @property
    def world(self) -> World:
        """The world."""
        assert self._world is not None
        return self._world

    def reset(self, starts: FloatArray, people: Sequence[WalkerSpec], seed: int) -> None:
        """Put the robots at poses (n, 3), standing, at tick 0, with new navigators."""
        options = options_of(*self._names, len(starts), seed)
        setup = _setup(options, starts, people)
        self._world = setup.start(World)
        config = nav_config(options, setup.specs[0])
        self._robots = [
            SteeredNavigator(config, spec, setup.grid, setup.scene.sites, number, home)
            for number, (spec, home) in enumerate(zip(setup.specs, setup.starts, strict=True), 1)
        ]
        self._loop = Loop(self._world, [robot.navigator for robot in self._robots])
        self.ranges = np.full((len(starts), self._rays), np.inf, np.float32)
        self._observe()

    def place(self, poses: Mapping[int, FloatArray]) -> None:
        """Refuse."""
        raise SwarmError("robots that have reserved space cannot be put elsewhere")

    def step(self, twists: FloatArray, looks: bool = True) -> Mask:
        """Steer with twists (n, 3) for a tick; return who began to touch something."""
        for robot, (vx, wz, vy) in zip(self._robots, twists.tolist(), strict=True):
            robot.wish = Twist(vx, vy, wz)
        self._loop.decide()
        contacts = np.zeros(len(self._robots), np.bool_)
        for collision in self._loop.act():
            names = self.world.names
            contacts[[names.index(name) for name in collision.robots if name in names]] = True
        self._observe()
        return contacts

    def _observe(self) -> None:
        self._loop.sense()
        for robot, seen in enumerate(self._loop.observed):
            if seen.scan is not None:
                self.ranges[robot] = seen.scan.ranges
        self.twists = np.array([(t.vx, t.wz, t.vy) for _, t in self.world.ground_truth()])

    def __getstate__(self) -> dict[str, Any]:
        """Refuse to be copied once navigators drive.

        Raises:
            SwarmError: Then.
        """
        if self._world is not None:
            raise SwarmError(
                "an environment with shield=True can be copied or pickled before its first reset"
                " only: its navigators hold space; make another one, and reset it with the seed"
            )
        return vars(self)


def options_of(world: str, robot: str, count: int, seed: int = 0) -> RunOptions:
    """Return the options of a run of robots without a mission."""
    scenario = Scenario(
        name="arena",
        world=world,
        mission="",
        robots=(count,),
        robot=robot,
        with_lidar=True,
        noise=0.0,
    )
    return RunOptions(scenario=scenario, robots=count, seed=seed)


def _setup(options: RunOptions, starts: FloatArray, people: Sequence[WalkerSpec]) -> WorldSetup:
    world = options.scenario.world
    homes = [Pose(*pose) for pose in starts.tolist()]
    scene = load_world(world).scene
    scene = dataclasses.replace(scene, walkers=(*scene.walkers, *people))
    return setup_of(options, scene, homes, grid_of(world))


@functools.lru_cache(maxsize=4)
def grid_of(world: str) -> Grid:
    """Return the map of a world, with its zones."""
    found = load_world(world)
    return found.scene.sites.zones.mark(found.map)
