"""Small maps of cells, all placements of robots on them, runs of real navigators, and pictures."""

import functools
import itertools
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from swarm_common.model.beacon import reception_of
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_describe.worlds.scene import Scene
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind, Outcome
from swarm_nav.traffic.conditions import Conditions, conditions
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.navigation import room, waffle, without_lidar
from tests.fakes.traffic import WALL, hall_scene, smallest_gap

PITCH = 1.2  # [m] of a cell
LIMIT = 3000  # ticks
Cell = tuple[int, int]  # row from below, column
Spot = tuple[float, float]  # the same, also between the centres of cells
Placement = tuple[tuple[Cell, Spot], ...]  # (start, goal) of each robot


@dataclass(frozen=True)
class CellMap:
    """A map drawn with '.' for a free cell and '#' for a block; the first row is the upper one.

    Goals are distinct cells or, where a map has stations, any of these for each robot.
    """

    name: str
    drawing: tuple[str, ...]
    stations: tuple[Spot, ...] = ()

    @functools.cached_property
    def size(self) -> tuple[float, float]:
        """Width and height [m], outer walls included."""
        return (len(self.drawing[0]) * PITCH + 2 * WALL, len(self.drawing) * PITCH + 2 * WALL)

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

    def pose(self, cell: Spot) -> Pose:
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
        if self.stations:
            return ({cell: cell for cell in self.free},)
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
        """Yield all ways to give `count` robots distinct starts, and goals, one per symmetry.

        Placements that differ only by who is who are one; the lower start gets the smaller id.
        """
        for starts in itertools.combinations(self.free, count):
            if self.stations:
                for stations in itertools.product(self.stations, repeat=count):
                    yield tuple(zip(starts, stations, strict=True))
                continue
            for goals in itertools.permutations(self.free, count):
                placement = tuple(zip(starts, goals, strict=True))
                if placement == self._canonical(placement):
                    yield placement

    def _canonical(self, placement: Sequence[tuple[Cell, Cell]]) -> Placement:
        return min(
            tuple(sorted((image[start], image[goal]) for start, goal in placement))
            for image in self.symmetries
        )

    def sample(self, count: int, number: int, seed: int) -> Iterator[Placement]:
        """Yield so many placements at random."""
        rng = random.Random(seed)
        for _ in range(number):
            starts = sorted(rng.sample(self.free, count))
            goals: Sequence[Spot] = (
                rng.choices(self.stations, k=count)
                if self.stations
                else rng.sample(self.free, count)
            )
            yield tuple(zip(starts, goals, strict=True))

    def conditions(self, placement: Placement) -> Conditions:
        """Return what the theorem of liveness says of a placement."""
        starts, goals = (
            [self.pose(spot) for spot in spots] for spots in zip(*placement, strict=True)
        )
        return conditions(
            [(waffle(), without_lidar())] * len(placement),
            self.grid,
            [(pose.x, pose.y) for pose in starts],
            [[(pose.x, pose.y)] for pose in goals],
        )

    def picture(self, placement: Placement, poses: Sequence[Pose]) -> str:
        """Draw robots as digits and their goals as letters, a cell four by two characters."""
        height, width = 2 * len(self.drawing), 4 * len(self.drawing[0])
        rows = [[" "] * width for _ in range(height)]
        for row, column in self._cells("#"):
            for y, x in itertools.product(range(2), range(4)):
                rows[2 * row + y][4 * column + x] = "#"
        goals = [self.pose(goal) for _, goal in placement]
        for marks, spots in (("abcdefgh", goals), ("12345678", poses)):
            for mark, spot in zip(marks, spots, strict=False):
                x, y = ((at - WALL) / PITCH for at in (spot.x, spot.y))
                rows[min(int(2 * y), height - 1)][min(int(4 * x), width - 1)] = mark
        edge = f"+{'-' * width}+"
        return "\n".join([edge, *(f"|{''.join(row)}|" for row in reversed(rows)), edge])


RING = CellMap("ring", ("...", ".#.", "..."))
AISLE = CellMap("aisle", ("....", "...."))
EIGHT = CellMap("eight", (".....", ".#.#.", "....."))
DOOR = CellMap("door", ("..#..", ".....", "..#.."))
ALCOVE = CellMap("alcove", ("......", "##.###"))
CORNER = CellMap("corner", ("..##", "..##", "....", "...."))
TREE = CellMap("tree", ("##.##", "##.##", ".....", "##.##"))
TWIGS = CellMap("twigs", (".#.#.", ".....", "#.#.#"))
SMALL_DOOR = CellMap("small_door", ("..#.", "...."))
SMALL_CORNER = CellMap("small_corner", ("..#", "...", "..."))
SMALL_TREE = CellMap("small_tree", (".#.", "...", ".#."))
# Two stations 0.72 m apart: in the open, and one in an alcove before whose mouth the other lies.
PAIR = CellMap("pair", ("....", "....", "...."), ((1.0, 1.2), (1.0, 1.8)))
PAIR_IN_ALCOVE = CellMap("pair_in_alcove", ("....", "....", "#.##"), ((0.0, 1.0), (0.6, 1.0)))
MAPS = (
    RING, AISLE, EIGHT, DOOR, ALCOVE, CORNER, TREE, TWIGS,
    SMALL_DOOR, SMALL_CORNER, SMALL_TREE, PAIR, PAIR_IN_ALCOVE,
)  # fmt: skip


@dataclass(frozen=True)
class Ending:
    """How a run ended; `gap` is the smallest distance [m] of two held tubes."""

    is_done: bool
    contacts: int
    gap: float
    ticks: int


def play(
    cells: CellMap,
    placement: Placement,
    parameters: NavConfig | None = None,
    limit: int = LIMIT,
    watch: Callable[[int, Sequence[Pose]], None] = lambda tick, poses: None,
) -> Ending:
    """Let real navigators drive from their starts to their goals; `watch` sees each tick."""
    spec = waffle()
    starts = [cells.pose(start) for start, _ in placement]
    world = World(
        cells.scene, [spec] * len(starts), starts, WorldConfig(engine="planar", with_lidar=False)
    )
    config = without_lidar(parameters)
    sites = Sites({f"station_{k}": cells.pose(spot) for k, spot in enumerate(cells.stations, 1)})
    robots = [
        Navigator(config, spec, cells.grid, sites, index + 1, start)
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
            robot.on_reception(reception_of(seen.neighbors))
            output = robot.tick(world.tick)
            outputs.append(output)
            for event in output.events:
                if isinstance(event, GoalEnded) and event.outcome is Outcome.SUCCEEDED:
                    reached.add(index)
        gap = min(gap, smallest_gap([output.beacon for output in outputs]))
        watch(world.tick, [Pose(*pose) for pose in world.poses.tolist()])
        world.step([output.twist for output in outputs], [output.beacon for output in outputs])
    contacts = len(world.collisions)
    world.close()
    return Ending(len(reached) == len(robots), contacts, gap, world.tick)
