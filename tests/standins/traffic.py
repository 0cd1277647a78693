"""A small swarm of real navigators in the kinematic world: random halls, goals and losses."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from swarm_common.grid import Grid
from swarm_common.records import Pose
from swarm_common.sites import Sites
from swarm_nav.config import NavConfig
from swarm_nav.goals import Goal, GoalEnded, GoalKind, Outcome, Output
from swarm_nav.navigator import Navigator
from swarm_sim.radio import RadioConfig
from swarm_sim.scene import Body, Box, Part, Scene, transform_from_xyz_rpy
from swarm_sim.world import World, WorldConfig
from tests.standins.navigation import room, waffle, without_lidar

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
    """One random situation: a hall with a box in it, robots, two goals for each.

    Attributes:
        seed: Of the situation and of the losses.
        loss: Share of the beacons that are lost.
        death: Tick from which the first robot does and says nothing more.
    """

    seed: int
    loss: float = 0.0
    death: int | None = None
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
    radio = RadioConfig(loss=trial.loss)
    world = World(
        hall_scene(*trial.size, trial.boxes), [spec] * trial.count, trial.starts,
        WorldConfig(engine="planar", with_lidar=False, radio=radio), trial.seed,
    )  # fmt: skip
    robots = [
        Navigator(without_lidar(parameters), spec, trial.grid(), Sites(), i + 1, start)
        for i, start in enumerate(trial.starts)
    ]
    reached = [0] * trial.count
    gap = math.inf
    send(robots, trial, reached, range(trial.count))
    while world.tick < limit and not is_done(trial, reached, world):
        outputs: list[Output | None] = []
        for index, (robot, seen) in enumerate(zip(robots, world.observe(), strict=True)):
            if is_dead(trial, index, world.tick):
                outputs.append(None)
                continue
            robot.on_odom(seen.odom)
            robot.on_neighbors(seen.neighbors)
            outputs.append(robot.tick(world.tick))
        for index, output in enumerate(outputs):
            for event in output.events if output is not None else ():
                if isinstance(event, GoalEnded):
                    reached[index] += event.outcome is Outcome.SUCCEEDED
                    send(robots, trial, reached, [index])
        gap = min(gap, smallest_gap([output.beacon for output in outputs if output is not None]))
        world.step([o and o.twist for o in outputs], [o.beacon if o else None for o in outputs])
    verdict = world.verdict
    contacts = verdict.robot_robot + verdict.robot_world
    return Report(is_done(trial, reached, world), contacts, gap, world.tick)


def is_dead(trial: Trial, index: int, tick: int) -> bool:
    """Whether a robot has stopped to do anything."""
    return index == 0 and trial.death is not None and tick >= trial.death


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
    """Give robots their next goal."""
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
