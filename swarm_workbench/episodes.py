"""Episodes to learn in: how many robots and people there are, where they start and are to go."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
from msgspec import Meta
from scipy import ndimage

from swarm_common.files.convert import convert
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray
from swarm_common.model.schema import Count, Schema, shown
from swarm_describe.worlds.actors import WalkerSpec
from swarm_workbench.observation import REACHED

GAP = 0.2  # [m] between robots, and half of it to walls, at random places
TRIES = 200  # for each robot
STROLL = 6.0  # [m] at most, that a person walks to and fro
STEP = 0.1  # [m] between points of a stroll that are compared with the map
Rows = FloatArray | Sequence[Sequence[float]]
Curriculum = Callable[[int, np.random.Generator], Mapping[str, Any] | None]


class _Wishes(Schema):
    """What a curriculum or the options of `reset` say of an episode."""

    starts: tuple[tuple[float, float, float], ...] | None = None  # x, y [m], yaw in map of each
    goals: tuple[tuple[float, float], ...] | None = None  # x, y [m] in map of each
    # [m] from start to goal: at most, or at least and at most
    distance: float | tuple[float, ...] | None = None
    robots: Count | None = None  # that take part: the first ones
    people: Annotated[int, Meta(ge=0, le=100)] = 0  # who walk to and fro


class EpisodeStart(NamedTuple):
    """An episode before it begins; m robots take part in it."""

    starts: FloatArray  # (m, 3) x, y, yaw in map
    goals: FloatArray  # (m, 2) [m] in map
    people: tuple[WalkerSpec, ...]


class Episodes:
    """Draws episodes: at random, as a curriculum says, or as a caller does."""

    def __init__(
        self, grid: Grid, radius: float, robots: int, curriculum: Curriculum | None
    ) -> None:
        """Find the places where a robot can stand.

        Args:
            grid: Map of the world.
            radius: [m] of the robots.
            robots: Number of robots that take part at most.
            curriculum: Callable of the number of the episode, from 0, and a random generator; it
                returns what else would be options of `reset`.

        Raises:
            ConfigError: If there is no such place.
        """
        self._grid, self._radius, self._robots = grid, radius, robots
        self._curriculum = curriculum
        self._places = places_on(grid, radius)
        self._count = 0

    def draw(self, random: np.random.Generator, options: Mapping[str, Any] | None) -> EpisodeStart:
        """Return the next episode.

        Args:
            options: Keys of `_Wishes`; they count more than those of the curriculum.

        Raises:
            ConfigError: If something is unknown, of a wrong shape, in a wall, or has no room.
        """
        wishes = self._wishes(random, options)
        self._count += 1
        count = self._robots if wishes.robots is None else wishes.robots
        if count > self._robots:
            raise ConfigError(f"robots is {count}; the environment has {self._robots}")
        for name, rows in (("starts", wishes.starts), ("goals", wishes.goals)):
            if rows is not None and len(rows) != count:
                raise ConfigError(
                    f"{name} has {len(rows)} rows; expected one for each of {count} robots"
                )
        places, radius = self._places, self._radius
        if wishes.starts is None:
            starts = spread(places, radius, count, random)
        else:
            starts = np.array(wishes.starts)
        if wishes.goals is not None:
            goals = np.array(wishes.goals)
            self._check_goals(goals)
        elif wishes.distance is None:
            goals = spread(places, radius, count, random)[:, :2]
        else:
            goals = self._goals_within(wishes.distance, starts, random)
        people = tuple(self._person(index, starts, random) for index in range(wishes.people))
        return EpisodeStart(starts, goals, people)

    def _wishes(self, random: np.random.Generator, options: Mapping[str, Any] | None) -> _Wishes:
        chosen: dict[str, Any] = {}
        by_curriculum = self._curriculum(self._count, random) if self._curriculum else None
        for where, given in (("curriculum", by_curriculum), ("options", options)):
            if given is None:
                continue
            if not isinstance(given, Mapping):
                raise ConfigError(
                    f"{where}: {shown(given)} is no mapping; expected some of"
                    f" {', '.join(_Wishes.__struct_fields__)}"
                )
            plain = {key: _listed(value) for key, value in given.items()}
            convert(plain, _Wishes, where)
            chosen |= plain
        return convert(chosen, _Wishes, "options")

    def _check_goals(self, goals: FloatArray) -> None:
        for index, goal in enumerate(goals):
            away = np.hypot(*(self._places - goal).T).min()
            if away > REACHED + self._radius or not self._is_free(goal[None]):
                raise ConfigError(
                    f"goals[{index}] is {_point(goal)}: no robot can stand within {REACHED} m of"
                    " it; choose a place away from walls"
                )

    def _goals_within(
        self, distance: float | tuple[float, ...], starts: FloatArray, random: np.random.Generator
    ) -> FloatArray:
        """Return goals (m, 2) some way from the starts, apart from each other."""
        limits = distance if isinstance(distance, tuple) else (0.0, distance)
        if len(limits) != 2 or not 0.0 <= limits[0] <= limits[1]:
            raise ConfigError(
                f"distance is {shown(distance)}; expected [m] at most, or at least and at most"
            )
        least, most = limits
        goals = np.empty((len(starts), 2))
        for index, start in enumerate(starts):
            away = np.hypot(*(self._places - start[:2]).T)
            fits = self._places[(away >= least) & (away <= most)]
            chosen = apart(fits, goals[:index], 2.0 * self._radius + GAP, random)
            if chosen is None:
                raise ConfigError(
                    f"distance is {distance} m: no goal is that far from {_point(start)}"
                )
            goals[index] = chosen
        return goals

    def _person(self, index: int, starts: FloatArray, random: np.random.Generator) -> WalkerSpec:
        """Return somebody who walks to and fro where nothing is in the way, away from starts."""
        places = self._places
        for _ in range(TRIES):
            ends = places[random.integers(len(places), size=2)]
            length = math.dist(*ends)
            if not 1.0 <= length <= STROLL:
                continue
            line = np.linspace(ends[0], ends[1], math.ceil(length / STEP) + 1)
            gaps = np.hypot(*(line[:, None] - starts[:, :2]).T)
            if gaps.min(initial=math.inf) > self._radius + 0.7 and self._is_free(line):
                path = (tuple(ends[0].tolist()), tuple(ends[1].tolist()))
                return WalkerSpec(
                    name=f"person_{index + 1}", path=path, speed=float(random.uniform(0.3, 0.8))
                )
        raise ConfigError(f"the world has no room for person {index + 1} beside the robots")

    def _is_free(self, points: FloatArray) -> bool:
        grid = self._grid
        columns = np.floor((points[:, 0] - grid.origin_x) / grid.resolution).astype(int)
        rows = np.floor((points[:, 1] - grid.origin_y) / grid.resolution).astype(int)
        height, width = grid.cells.shape
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        return bool(inside.all() and (grid.cells[rows, columns] == 0).all())


def _listed(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else (
        [_listed(each) for each in value] if isinstance(value, list | tuple) else value
    )  # fmt: skip


def _point(point: FloatArray) -> str:
    return f"({point[0]:g}, {point[1]:g})"


def apart(
    places: FloatArray, others: FloatArray, gap: float, random: np.random.Generator
) -> FloatArray | None:
    """Return one of some places (m, 2) that is away from others (n, 2) [m]; None if none is."""
    for chosen in random.integers(len(places), size=TRIES).tolist() if len(places) else ():
        place: FloatArray = places[chosen]
        if np.all(np.hypot(*(others[:, :2] - place).T) > gap):
            return place
    return None


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
    poses = np.empty((count, 3))
    for found in range(count):
        place = apart(places, poses[:found], 2.0 * radius + GAP, random)
        if place is None:
            raise ConfigError(
                f"the world has room for {found} robots at random places, not for {count}"
            )
        poses[found] = *place, random.uniform(-np.pi, np.pi)
    return poses


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
