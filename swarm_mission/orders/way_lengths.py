"""How far it is from anywhere to a station: around walls where the map is known, else straight."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.grid import FREE, Grid
from swarm_common.model.records import FloatArray, Pose

CELL = 0.25  # [m] with which ways are measured
NEAR = 4  # cells around a place in which the nearest one with a way is taken


class WayLengths:
    """Lengths of the shortest ways to stations, to half a cell or so."""

    def __init__(
        self, stations: Mapping[str, Pose], grid: Grid | None, radius: float = 0.0
    ) -> None:
        """Measure all ways.

        Args:
            grid: Upright map; None where it is not known.
            radius: [m] that a robot's centre keeps from walls.
        """
        self._stations = dict(stations)
        self._fields: dict[str, FloatArray] = {}
        self._grid = grid
        if grid is not None:
            self._measure(grid, radius)

    def length(self, x: float, y: float, station: str) -> float:
        """Return the way [m] from a place in map to a station; inf if there is none."""
        pose = self._stations[station]
        straight = math.hypot(pose.x - x, pose.y - y)
        field = self._fields.get(station)
        if field is None or self._grid is None:
            return straight
        row, column = self._cell(self._grid, x, y)
        rows, columns = (slice(max(0, at - NEAR), at + NEAR + 1) for at in (row, column))
        inside = 0 <= row < field.shape[0] and 0 <= column < field.shape[1]
        if inside and math.isfinite(field[row, column]):
            return max(straight, float(field[row, column]))
        return max(straight, float(field[rows, columns].min(initial=math.inf)))

    def between(self, first: str, second: str) -> float:
        """Return the way [m] from a station to another."""
        pose = self._stations[first]
        return self.length(pose.x, pose.y, second)

    @staticmethod
    def _cell(grid: Grid, x: float, y: float) -> tuple[int, int]:
        return int((y - grid.origin_y) // CELL), int((x - grid.origin_x) // CELL)

    def _measure(self, grid: Grid, radius: float) -> None:
        from scipy.ndimage import distance_transform_edt
        from scipy.sparse.csgraph import dijkstra

        from swarm_mission.way_table import way_graph

        is_free = grid.cells == FREE
        if grid.keepout is not None:
            is_free &= grid.keepout < 100
        padded = np.pad(is_free, 1)
        clear = distance_transform_edt(padded)[1:-1, 1:-1] * grid.resolution
        step = CELL / grid.resolution
        rows = ((np.arange(math.ceil(grid.height / step)) + 0.5) * step).astype(int)
        columns = ((np.arange(math.ceil(grid.width / step)) + 0.5) * step).astype(int)
        rows, columns = rows.clip(0, grid.height - 1), columns.clip(0, grid.width - 1)
        room = clear[np.ix_(rows, columns)] > radius
        graph = way_graph(room, CELL)
        for name, pose in self._stations.items():
            row, column = self._cell(grid, pose.x, pose.y)
            start = self._nearest(room, row, column)
            if start is not None:
                field = dijkstra(graph, directed=False, indices=start[0] * room.shape[1] + start[1])
                self._fields[name] = field.reshape(room.shape)

    @staticmethod
    def _nearest(room: NDArray[np.bool_], row: int, column: int) -> tuple[int, int] | None:
        """Return the free cell nearest to one, None if there is none near."""
        found = np.argwhere(room)
        if not len(found):
            return None
        distances = np.hypot(*(found - (row, column)).T)
        best = int(distances.argmin())
        if distances[best] > NEAR:
            return None
        return int(found[best, 0]), int(found[best, 1])
