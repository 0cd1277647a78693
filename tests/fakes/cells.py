"""Small maps of cells, all placements of robots on them, and runs of real navigators."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind, Outcome
from swarm_sim.scene.scene import Scene
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.navigation import room, waffle, without_lidar
from tests.fakes.traffic import WALL, hall_scene, smallest_gap

PITCH = 1.2  # [m] of a cell
LIMIT = 3000  # ticks
Cell = tuple[int, int]  # row from below, column
Placement = tuple[tuple[Cell, Cell], ...]  # (start, goal) of each robot


@dataclass(frozen=True)
class CellMap:
    """A map drawn with '.' for a free cell and '#' for a block; the first row is the upper one."""

    name: str
    drawing: tuple[str, ...]

    @functools.cached_property
    def size(self) -> tuple[float, float]:
        """Width and height [m], outer walls included."""
        return (
            len(self.drawing[0]) * PITCH + 2 * WALL,
            len(self.drawing) * PITCH + 2 * WALL,
        )

    @functools.cached_property
    def free(self) -> tuple[Cell, ...]:
        return tuple(self._cells("."))

    @functools.cached_property
    def boxes(self) -> tuple[tuple[float, float, float, float], ...]:
        low = [(WALL + PITCH * column, WALL + PITCH * row) for row, column in self._cells("#")]
        return tuple((x, y, x + PITCH, y + PITCH) for x, y in low)

    def _cells(self, kind: str) -> Iterator[Cell]:
        for row, line in enumerate(reversed(self.drawing)):
            for column, found in enumerate(line):
                if found == kind:
                    yield row, column

    def pose(self, cell: Cell) -> Pose:
        return Pose(WALL + (cell[1] + 0.5) * PITCH, WALL + (cell[0] + 0.5) * PITCH, 0.0)

    @functools.cached_property
    def grid(self) -> Grid:
        return room(*self.size, *self.boxes)

    @functools.cached_property
    def scene(self) -> Scene:
        return hall_scene(*self.size, self.boxes)

    @functools.cached_property
    def symmetries(self) -> tuple[dict[Cell, Cell], ...]:
        """The turns and mirrorings of the square that leave the map as it is."""
        height, width = len(self.drawing), len(self.drawing[0])
        block = np.zeros((height, width), bool)
        index = np.array([(r, c) for r in range(height) for c in range(width)])
        index = index.reshape(height, width, 2)
        for cell in self.free:
            block[cell] = True
        found = []
        for turns, mirrored in itertools.product(range(4), (False, True)):
            image = np.rot90(block, turns)
            source = np.rot90(index, turns)
            if mirrored:
                image, source = image[::-1], source[::-1]
            if image.shape == block.shape and (image == block).all():
                found.append({tuple(source[c].tolist()): c for c in self.free})
        return tuple(found)

    def placements(self, count: int) -> Iterator[Placement]:
        """Yield all ways to give `count` robots distinct starts and goals, one per symmetry.

        Placements that differ only by who is who are one; the lower start gets the smaller id.
        """
        for starts in itertools.combinations(self.free, count):
            for goals in itertools.permutations(self.free, count):
                placement = tuple(zip(starts, goals, strict=True))
                if placement == self._canonical(placement):
                    yield placement

    def _canonical(self, placement: Placement) -> Placement:
        return min(
            tuple(sorted((image[start], image[goal]) for start, goal in placement))
            for image in self.symmetries
        )


RING = CellMap("ring", ("...", ".#.", "..."))
AISLE = CellMap("aisle", ("....", "...."))
EIGHT = CellMap("eight", (".....", ".#.#.", "....."))
DOOR = CellMap("door", ("..#..", ".....", "..#.."))
ALCOVE = CellMap("alcove", ("......", "##.###"))
CORNER = CellMap("corner", ("..##", "..##", "....", "...."))
TREE = CellMap("tree", ("##.##", "##.##", ".....", "##.##"))
TWIGS = CellMap("twigs", (".#.#.", ".....", "#.#.#"))
MAPS = (RING, AISLE, EIGHT, DOOR, ALCOVE, CORNER, TREE, TWIGS)


@dataclass(frozen=True)
class Ending:
    """How a run ended; `gap` is the smallest distance [m] of two held tubes."""

    is_done: bool
    contacts: int
    gap: float
    ticks: int


def play(
    cells: CellMap, placement: Placement, parameters: NavConfig | None = None, limit: int = LIMIT
) -> Ending:
    """Let real navigators drive from their starts to their goals."""
    spec = waffle()
    starts = [cells.pose(start) for start, _ in placement]
    world = World(
        cells.scene, [spec] * len(starts), starts, WorldConfig(engine="planar", with_lidar=False)
    )
    config = without_lidar(parameters)
    robots = [
        Navigator(config, spec, cells.grid, Sites(), index + 1, start)
        for index, start in enumerate(starts)
    ]
    for robot, (_, goal) in zip(robots, placement, strict=True):
        robot.set_goal(Goal(kind=GoalKind.NAVIGATE, poses_map=(cells.pose(goal),)))
    reached: set[int] = set()
    gap = 9.0
    while world.tick < limit and len(reached) < len(robots):
        outputs = []
        for index, (robot, seen) in enumerate(zip(robots, world.observe(), strict=True)):
            robot.on_odom(seen.odom)
            robot.on_neighbors(seen.neighbors)
            output = robot.tick(world.tick)
            outputs.append(output)
            for event in output.events:
                if isinstance(event, GoalEnded) and event.outcome is Outcome.SUCCEEDED:
                    reached.add(index)
        gap = min(gap, smallest_gap([output.beacon for output in outputs]))
        world.step([output.twist for output in outputs], [output.beacon for output in outputs])
    contacts = len(world.collisions)
    world.close()
    return Ending(len(reached) == len(robots), contacts, gap, world.tick)
