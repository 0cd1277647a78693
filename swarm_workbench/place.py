"""Goals: a station by name, a pose, or a pixel of the map."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Pose

TOLERANCE = 0.5  # [m] by which navigators move a goal that is in a wall, at most


class Pixel(NamedTuple):
    """A pixel of the map's image, from its upper left corner."""

    column: int
    row: int


Place = str | Pose | Pixel | Sequence[float]


class Places:
    """Turns what a user calls a place into a pose on one map."""

    def __init__(self, grid: Grid, stations: Mapping[str, Pose]) -> None:
        self._grid = grid
        self._stations = stations

    def pose(self, place: Place, radius: float) -> Pose:
        """Return the pose [map] of a place to which a robot can be sent.

        Args:
            radius: [m] of the robot's inscribed circle.

        Raises:
            ConfigError: If there is no such place, or it is in a wall.
        """
        pose = self._named(place)
        room = self._room_near(pose)
        if room < radius:
            raise ConfigError(
                f"({pose.x:g}, {pose.y:g}) is in a wall, off the map or too near to one: within"
                f" {TOLERANCE} m of it no place has {radius:.2f} m of room; choose another goal"
            )
        return pose

    def _named(self, place: Place) -> Pose:
        if isinstance(place, str):
            if place not in self._stations:
                raise UnknownNameError("station", place, self._stations)
            return self._stations[place]
        if isinstance(place, Pose):
            place = (place.x, place.y, place.yaw)
        if isinstance(place, Pixel):
            grid = self._grid
            return Pose(*grid.center_of(grid.height - 1 - place.row, place.column), 0.0)
        try:
            numbers = [float(value) for value in place]
        except (TypeError, ValueError):
            numbers = []
        if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)):
            raise ConfigError(
                f"the goal is {place!r}; expected the name of a station, (x, y), (x, y, yaw) or a"
                " Pixel"
            )
        return Pose(numbers[0], numbers[1], numbers[2] if len(numbers) == 3 else 0.0)

    @functools.cached_property
    def _room(self) -> FloatArray:
        """Distance [m] of each cell to the nearest one that is not free."""
        field: FloatArray = ndimage.distance_transform_edt(self._grid.cells == 0)
        return field * self._grid.resolution

    def _room_near(self, pose: Pose) -> float:
        row, column = self._grid.cell_of(pose.x, pose.y)
        reach = math.ceil(TOLERANCE / self._grid.resolution)
        rows = slice(max(row - reach, 0), max(row + reach + 1, 0))
        columns = slice(max(column - reach, 0), max(column + reach + 1, 0))
        near = self._room[rows, columns]
        return float(np.max(near, initial=0.0))
