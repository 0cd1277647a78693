"""Worlds to learn in: twists in, poses, scans and contacts out; with or without a shield."""

from __future__ import annotations

import functools
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarm_bench.runs.episode import RunOptions, nav_config, robot_named, setup_of
from swarm_bench.runs.scenario import Scenario
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Mask, Pose, Twist
from swarm_run.loop import Loop
from swarm_sim.world.setup import WorldSetup
from swarm_sim.world.world import World
from swarm_workbench.steered import SteeredNavigator
from swarm_workbench.world import load_world

GAP = 0.2  # [m] between robots, and half of it to walls, at random places
TRIES = 200  # for each robot


class Arena(Protocol):
    """Robots that obey twists.

    Attributes:
        poses: (n, 3) true x, y, yaw in map.
        twists: (n, 3) vx, wz, vy [m/s, rad/s, m/s].
        ranges: (n, rays) [m] of the latest scans; inf where nothing was hit.
    """

    poses: FloatArray
    twists: FloatArray
    ranges: NDArray[np.float32]

    def reset(self, starts: FloatArray, seed: int) -> None:
        """Put the robots at poses (n, 3), standing, at tick 0."""

    def step(self, twists: FloatArray) -> Mask:
        """Drive towards twists (n, 3) for a tick; return who touches something."""


class _OpenWorld(World):
    """A world that takes twists and can begin anew; it has no radio, odometry or verdict."""

    def begin(self, starts: FloatArray) -> None:
        """Put the robots at poses (n, 3), standing, at tick 0."""
        self._tick = 0
        for robot, pose in enumerate(starts):
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

    def take_scans(self, ranges: NDArray[np.float32]) -> None:
        """Write the scans that are due at this tick."""
        assert self._lidars is not None
        for robot, scan in self._lidars.due(self._tick, self._engine.poses).items():
            ranges[robot] = scan.ranges

    @property
    def twists(self) -> FloatArray:
        """True vx, wz, vy (n, 3)."""
        return self._engine.twists


class OpenArena:
    """Nobody holds a robot back from hitting something."""

    def __init__(self, world: str, robot: str, count: int) -> None:
        self._options = options_of(world, robot, count)
        self._world: _OpenWorld | None = None
        self.ranges = np.full((count, robot_named(robot).lidar.rays), np.inf, np.float32)
        self.poses = self.twists = np.zeros((count, 3))

    def reset(self, starts: FloatArray, seed: int) -> None:
        """Put the robots at poses (n, 3), standing, at tick 0."""
        if self._world is None:
            self._world = _setup(self._options, starts).start(_OpenWorld)
        self._world.begin(starts)
        self._look(self._world)

    def step(self, twists: FloatArray) -> Mask:
        """Drive towards twists (n, 3) for a tick; return who touches something."""
        assert self._world is not None
        contacts = self._world.drive(twists)
        self._look(self._world)
        return contacts

    def _look(self, world: _OpenWorld) -> None:
        world.take_scans(self.ranges)
        self.poses, self.twists = world.poses, world.twists


class ShieldedArena:
    """Each robot drives inside space that it has reserved, through its navigator's stop filter."""

    def __init__(self, world: str, robot: str, count: int) -> None:
        self._world_name, self._robot, self._count = world, robot, count
        self.ranges = np.full((count, robot_named(robot).lidar.rays), np.inf, np.float32)
        self.poses = self.twists = np.zeros((count, 3))

    def reset(self, starts: FloatArray, seed: int) -> None:
        """Put the robots at poses (n, 3), standing, at tick 0, with new navigators."""
        options = options_of(self._world_name, self._robot, self._count, seed)
        setup = _setup(options, starts)
        self._world = setup.start(World)
        config = nav_config(options, setup.specs[0])
        self._robots = [
            SteeredNavigator(config, spec, setup.grid, setup.scene.sites, number, home)
            for number, (spec, home) in enumerate(zip(setup.specs, setup.starts, strict=True), 1)
        ]
        self._loop = Loop(self._world, [robot.navigator for robot in self._robots])
        self._observe()

    def step(self, twists: FloatArray) -> Mask:
        """Steer with twists (n, 3) for a tick; return who began to touch something."""
        for robot, (vx, wz, vy) in zip(self._robots, twists.tolist(), strict=True):
            robot.wish = Twist(vx, vy, wz)
        self._loop.decide()
        contacts = np.zeros(self._count, np.bool_)
        for collision in self._loop.act():
            contacts[[self._world.names.index(name) for name in collision.robots]] = True
        self._observe()
        return contacts

    def _observe(self) -> None:
        self._loop.sense()
        for robot, seen in enumerate(self._loop.observed):
            if seen.scan is not None:
                self.ranges[robot] = seen.scan.ranges
        self.poses = self._world.poses
        self.twists = np.array([(t.vx, t.wz, t.vy) for _, t in self._world.ground_truth()])


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


def _setup(options: RunOptions, starts: FloatArray) -> WorldSetup:
    world = options.scenario.world
    homes = [Pose(*pose) for pose in starts.tolist()]
    return setup_of(options, load_world(world).scene, homes, grid_of(world))


@functools.lru_cache(maxsize=4)
def grid_of(world: str) -> Grid:
    """Return the map of a world, with its zones."""
    found = load_world(world)
    return found.scene.sites.zones.mark(found.map)


def spread(
    places: FloatArray, radius: float, count: int, random: np.random.Generator
) -> FloatArray:
    """Return poses (count, 3) at random places where robots stand apart from each other.

    Args:
        places: Centres (m, 2) [m] to choose from.
        radius: [m] of a robot.

    Raises:
        ConfigError: If no room is found for so many.
    """
    apart = 2.0 * radius + GAP
    poses = np.empty((count, 3))
    found = 0
    for chosen in random.integers(len(places), size=TRIES * count).tolist():
        near = np.hypot(*(poses[:found, :2] - places[chosen]).T)
        if np.all(near > apart):
            poses[found] = *places[chosen], random.uniform(-np.pi, np.pi)
            found += 1
            if found == count:
                return poses
    raise ConfigError(f"the world has room for {found} robots at random places, not for {count}")


def places_on(grid: Grid, radius: float) -> FloatArray:
    """Return the centres (m, 2) [m] of a map's cells where a robot stands clear of walls.

    Only cells of the largest connected free region count, so that there is a way between any two.

    Raises:
        ConfigError: If there is none.
    """
    regions, _ = ndimage.label(grid.cells == 0)
    sizes = np.bincount(regions.ravel())
    sizes[0] = 0
    room = ndimage.distance_transform_edt(regions == np.argmax(sizes)) * grid.resolution
    rows, columns = np.nonzero(room > radius + GAP / 2.0)
    if not len(rows) or not sizes.any():
        raise ConfigError(f"the map has no place where a robot of radius {radius:.2f} m stands")
    x = grid.origin_x + (columns + 0.5) * grid.resolution
    y = grid.origin_y + (rows + 0.5) * grid.resolution
    return np.column_stack([x, y])
