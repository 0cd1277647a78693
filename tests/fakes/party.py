"""Real navigators with goals of their own in a hall made of boxes, run by the bench."""

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarm_bench.runs.episode import Episode, RunOptions
from swarm_bench.runs.harness import Harness, Watcher
from swarm_bench.runs.methods import load_method
from swarm_bench.runs.scenario import Scenario
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import Pose
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.shapes import Box, Part, transform_from_xyz_rpy
from swarm_common.model.sites import Sites
from swarm_describe.worlds.scene import Body, Scene
from swarm_mission.itinerary import Itinerary
from swarm_mission.leg import Stop
from swarm_run.loop import InjectedFaults
from swarm_run.record.run_record import RunRecord
from swarm_sim.maps.draw_map import draw_world
from swarm_sim.sensing.radio import RadioConfig
from swarm_sim.world.setup import WorldSetup
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.navigation import config, waffle, without_lidar

THICKNESS = 0.1  # [m] of walls
PASSABLE = 0.33  # [m] of a robot's centre from everything on its way
PLACE = 0.5  # [m] of a start or goal from everything
APART = 0.9  # [m] of starts and of goals from each other

Bar = tuple[float, float, float, float, float]  # centre x, y, length, width [m], yaw [rad]


def bars_of_room(width: float, height: float) -> list[Bar]:
    """Return the outer walls of a hall from (0, 0)."""
    half = THICKNESS / 2
    return [
        (width / 2, -half, width + 2 * THICKNESS, THICKNESS, 0.0),
        (width / 2, height + half, width + 2 * THICKNESS, THICKNESS, 0.0),
        (-half, height / 2, THICKNESS, height, 0.0),
        (width + half, height / 2, THICKNESS, height, 0.0),
    ]


def scene_of(bars: Sequence[Bar]) -> Scene:
    """Return a world of boxes 1 m high."""
    bodies = []
    for index, (x, y, length, width, yaw) in enumerate(bars):
        part = Part(Box((length, width, 1.0)), np.eye(4))
        place = transform_from_xyz_rpy(x, y, 0.5, 0.0, 0.0, yaw)
        bodies.append(Body(f"bar_{index}::link", place, (part,)))
    return Scene("party", Path("."), tuple(bodies))


@dataclass(kw_only=True)
class Party:
    """Robots in a hall, each with goals of its own.

    Attributes:
        bars: Walls and blocks.
        homes: Where the robots start.
        goals: Of each robot, in order.
        sites: Stations among the goals.
        seed: Of noise and losses.
        loss: Share of the beacons that are lost.
        delay: [s] that beacons are late.
        limit: [s] of simulated time.
        changes: Parameters that differ from the defaults, as of `config`.
        method: What drives the robots.
    """

    bars: Sequence[Bar]
    homes: Sequence[Pose]
    goals: Sequence[Sequence[Pose]]
    sites: Sites = field(default_factory=Sites)
    seed: int = 0
    loss: float = 0.0
    delay: float = 0.0
    limit: float = 400.0
    changes: dict[str, Any] = field(default_factory=dict)
    method: str = "ours"

    def harness(
        self, on_tick: Watcher | None = None, faults: InjectedFaults | None = None
    ) -> Harness:
        """Return the run, ready to start."""
        count = len(self.homes)
        scenario = Scenario(
            name="party", world="-", mission="-", robots=(count,), loss=self.loss,
            delay=self.delay, time_limit={count: self.limit}, stall_limit=self.limit,
        )  # fmt: skip
        options = RunOptions(scenario=scenario, robots=count, seed=self.seed)
        return Harness(options, on_tick=on_tick, faults=faults, episode=self._episode())

    def run(
        self, on_tick: Watcher | None = None, faults: InjectedFaults | None = None
    ) -> RunRecord:
        return self.harness(on_tick, faults).run()

    def _episode(self) -> Episode:
        spec, parameters = waffle(), without_lidar(config(**self.changes))
        scene = scene_of(self.bars)
        grid = draw_world(scene)
        setup = WorldSetup(
            config=WorldConfig(
                engine="planar", with_lidar=False, actuation_noise=0.02,
                radio=RadioConfig(loss=self.loss, delay=self.delay),
            ),
            seed=self.seed,
            scene=dataclasses.replace(scene, sites=self.sites),
            names=RobotNames().first(len(self.homes)),
            specs=[spec] * len(self.homes),
            starts=list(self.homes),
            grid=grid,
            robots={},
        )  # fmt: skip
        method = load_method(self.method)
        robots = [
            method(parameters, spec, grid, self.sites, number, home)
            for number, home in enumerate(self.homes, 1)
        ]
        routes = [
            [Stop(f"goal {k}", pose, 2) for k, pose in enumerate(poses, 1)] for poses in self.goals
        ]
        itineraries = [Itinerary(route, 0) for route in routes]
        return Episode(setup, setup.start(World), robots, itineraries, routes)


def inside(grid: Grid, left: float, right: float, top: float) -> NDArray[np.bool_]:
    """Return the cells with left < x < right and 0 < y < top [m]."""
    rows, columns = np.indices(grid.cells.shape)
    x = grid.origin_x + (columns + 0.5) * grid.resolution
    y = grid.origin_y + (rows + 0.5) * grid.resolution
    return (left < x) & (x < right) & (y > 0.0) & (y < top)


def draw_places(
    grid: Grid,
    size: tuple[float, float],
    rng: np.random.Generator,
    count: int,
    span: tuple[float, float] | None = None,
) -> list[Pose]:
    """Return free places of a hall, apart from each other and all within reach of each other.

    Args:
        grid: The map.
        size: Width and height [m] of the hall from (0, 0).
        rng: Draws them.
        count: How many.
        span: x [m] between which they lie; everywhere if None.
    """
    distance = ndimage.distance_transform_edt(grid.cells < OCCUPIED / 2) * grid.resolution
    span = span or (0.0, size[0])
    regions, _ = ndimage.label((distance >= PASSABLE) & inside(grid, 0.0, size[0], size[1]))
    sizes = np.bincount(regions.ravel())
    sizes[0] = 0
    is_free = (regions == sizes.argmax()) & (distance >= PLACE) & inside(grid, *span, size[1])
    cells = rng.permutation(np.argwhere(is_free))
    places: list[Pose] = []
    for row, column in cells:
        x = grid.origin_x + (column + 0.5) * grid.resolution
        y = grid.origin_y + (row + 0.5) * grid.resolution
        pose = Pose(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
        if all(pose.distance(other) >= APART for other in places):
            places.append(pose)
        if len(places) == count:
            return places
    raise ValueError(f"there is no room for {count} places")
