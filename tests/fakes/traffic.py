"""A small swarm of real navigators in the kinematic world: random halls, goals and losses."""

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from swarm_common.model.beacon import reception_of
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_common.model.shapes import Box, Part, transform_from_xyz_rpy
from swarm_common.model.sites import Sites
from swarm_describe.worlds.scene import Body, Scene
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind, Outcome, Output
from swarm_sim.sensing.radio import RadioConfig
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.navigation import room, waffle, without_lidar

WALL = 0.05  # [m] thick, one cell of the map
COVERED = 1.3  # [m] from a dead robot within which its last request may cover a goal
Rectangle = tuple[float, float, float, float]


def hall_scene(width: float, height: float, boxes: tuple[Rectangle, ...]) -> Scene:
    """Return a walled hall from (0, 0) with boxes (x_min, y_min, x_max, y_max)."""
    outer = (
        (0.0, 0.0, width, WALL), (0.0, height - WALL, width, height),
        (0.0, 0.0, WALL, height), (width - WALL, 0.0, width, height),
    )  # fmt: skip
    bodies = []
    for index, (x0, y0, x1, y1) in enumerate((*outer, *boxes)):
        part = Part(Box((x1 - x0, y1 - y0, 1.0)), np.eye(4))
        place = transform_from_xyz_rpy((x0 + x1) / 2, (y0 + y1) / 2, 0.5, 0.0, 0.0, 0.0)
        bodies.append(Body(f"wall_{index}::link", place, (part,)))
    return Scene("hall", Path("."), tuple(bodies))


@dataclass
class Trial:
    """One random robot: a hall with a box and pillars, robots, two goals for each.

    Attributes:
        seed: Of the robot and of the losses.
        loss: Share of the beacons that are lost.
        delay: [s] that beacons are late.
        death: Tick from which the first robot does and says nothing more.
        restart: Tick at which a new navigator, which knows nothing, drives the first robot.
        deaf: Ticks in which the first robot gets no batch.
        mute: Tick from which nobody hears the first robot.
        numb: Tick from which the first robot hears nobody, without knowing why.
        pillars: Number of pillars 0.2 m wide.
        with_lidar: Whether robots see.
    """

    seed: int
    loss: float = 0.0
    death: int | None = None
    delay: float = 0.0
    restart: int = -1
    deaf: range = range(0)
    mute: int | None = None
    numb: int | None = None
    pillars: int = 0
    with_lidar: bool = False
    count: int = field(init=False)

    def __post_init__(self) -> None:
        rng = np.random.default_rng(self.seed)
        self.count = int(rng.integers(3, 7))
        self.size = tuple(np.round(rng.uniform(6.0, 8.5, 2), 1).tolist())
        self.boxes: tuple[Rectangle, ...] = ()
        if rng.random() < 0.7:
            half = rng.uniform(0.3, 1.2, 2)
            middle = np.array(self.size) / 2
            low, high = np.round(middle - half, 1), np.round(middle + half, 1)
            self.boxes = ((*low.tolist(), *high.tolist()),)
        for _ in range(self.pillars):
            x, y = np.round(rng.uniform((1.2, 1.2), np.array(self.size) - 1.4), 1).tolist()
            self.boxes = (*self.boxes, (x, y, x + 0.2, y + 0.2))
        self.starts = self._places(rng)
        self.goals = [self._places(rng) for _ in range(2)]

    def _places(self, rng: np.random.Generator) -> list[Pose]:
        """Return a free pose per robot, 0.9 m apart and 0.45 m from walls."""
        places: list[Pose] = []
        while len(places) < self.count:
            x, y = rng.uniform((0.45, 0.45), np.array(self.size) - 0.45)
            pose = Pose(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
            in_box = any(
                x0 - 0.45 < x < x1 + 0.45 and y0 - 0.45 < y < y1 + 0.45
                for x0, y0, x1, y1 in self.boxes
            )
            if not in_box and all(pose.distance(other) > 0.9 for other in places):
                places.append(pose)
        return places

    def grid(self) -> Grid:
        return room(*self.size, *self.boxes)


@dataclass
class Report:
    """What happened; `tube_gap` is the smallest distance [m] between two held tubes."""

    is_done: bool
    contacts: int
    tube_gap: float
    ticks: int


def run(trial: Trial, parameters: NavConfig | None = None, limit: int = 2500) -> Report:
    """Let each robot drive to its two goals."""
    spec = waffle()
    radio = RadioConfig(loss=trial.loss, delay=trial.delay)
    config = (parameters or NavConfig()) if trial.with_lidar else without_lidar(parameters)
    world = World(
        hall_scene(*trial.size, trial.boxes), [spec] * trial.count, trial.starts,
        WorldConfig(engine="planar", with_lidar=trial.with_lidar, radio=radio), trial.seed,
    )  # fmt: skip
    robots = [
        Navigator(config, spec, trial.grid(), Sites(), i + 1, start)
        for i, start in enumerate(trial.starts)
    ]
    reached = [0] * trial.count
    gap = math.inf
    send(robots, trial, reached, range(trial.count))
    while world.tick < limit and not is_done(trial, reached, world):
        if world.tick == trial.restart:
            here = world.ground_truth()[0][0]
            robots[0] = Navigator(config, spec, trial.grid(), Sites(), 1, here)
            send(robots, trial, reached, [0])
        outputs: list[Output | None] = []
        for index, (robot, seen) in enumerate(zip(robots, world.observe(), strict=True)):
            if is_dead(trial, index, world.tick):
                outputs.append(None)
                continue
            robot.on_odom(seen.odom)
            if index > 0 or world.tick not in trial.deaf:
                is_numb = index == 0 and has_begun(trial.numb, world.tick)
                robot.on_reception(reception_of(seen.neighbors[:0] if is_numb else seen.neighbors))
            if seen.scan is not None:
                robot.on_scan(seen.scan)
            outputs.append(robot.tick(world.tick))
        for index, output in enumerate(outputs):
            for event in output.events if output is not None else ():
                if isinstance(event, GoalEnded):
                    reached[index] += event.outcome is Outcome.SUCCEEDED
                    send(robots, trial, reached, [index])
        gap = min(gap, smallest_gap([output.beacon for output in outputs if output is not None]))
        beacons = [o.beacon if o else None for o in outputs]
        if has_begun(trial.mute, world.tick):
            beacons[0] = None
        world.step([o and o.twist for o in outputs], beacons)
    verdict = world.verdict
    contacts = verdict.robot_robot + verdict.robot_world
    return Report(is_done(trial, reached, world), contacts, gap, world.tick)


def has_begun(since: int | None, tick: int) -> bool:
    return since is not None and tick >= since


def is_dead(trial: Trial, index: int, tick: int) -> bool:
    return index == 0 and has_begun(trial.death, tick)


def is_done(trial: Trial, reached: list[int], world: World) -> bool:
    """Whether each living robot has reached its goals, except one that a dead robot covers."""
    fallen = world.ground_truth()[0][0] if is_dead(trial, 0, world.tick) else None

    def is_barred(index: int) -> bool:
        if fallen is None:
            return False
        return any(goals[index].distance(fallen) < COVERED for goals in trial.goals)

    return all(
        count == 2 or is_dead(trial, index, world.tick) or is_barred(index)
        for index, count in enumerate(reached)
    )


def send(robots: list[Navigator], trial: Trial, reached: list[int], who: Iterable[int]) -> None:
    for index in who:
        if reached[index] < 2:
            goal = trial.goals[reached[index]][index]
            robots[index].set_goal(Goal(kind=GoalKind.NAVIGATE, poses_map=(goal,)))


def smallest_gap(beacons: list[np.void]) -> float:
    """Return the smallest distance between the held tubes of two robots."""
    best = math.inf
    for a, b in itertools.combinations(beacons, 2):
        held_a, held_b = a["held"][: a["held_size"]], b["held"][: b["held_size"]]
        gaps = np.hypot(*(held_a[:, None] - held_b[None]).T)
        best = min(best, float(gaps.min()))
    return best
