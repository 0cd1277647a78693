"""Which places a robot can get to among walls, crates and dead robots: the truth about a goal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import FloatArray
from swarm_nav.planning.cells import distance_cells, label

Disc = tuple[float, float, float]  # x, y, radius [m] that the robot's centre keeps


class Floor:
    """The map's free ground."""

    def __init__(self, grid: Grid) -> None:
        """Measure how far each cell is from the walls; unknown cells are neither walls nor free."""
        self._grid = grid
        self._distance = distance_cells(grid.cells >= OCCUPIED) * grid.resolution
        rows, columns = np.nonzero(grid.cells == 0)
        origin = grid.origin_x, grid.origin_y
        self._centres = (np.column_stack((columns, rows)) + 0.5) * grid.resolution + origin
        self._x = (np.arange(grid.width) + 0.5) * grid.resolution + grid.origin_x
        self._y = (np.arange(grid.height) + 0.5) * grid.resolution + grid.origin_y

    def clearance(self, points: FloatArray) -> FloatArray:
        """Return the distances (n,) [m] of points (n, 2) in map from walls; 0 outside the map."""
        cells = self._cells(points)
        inside = ((cells >= 0) & (cells < self._distance.shape)).all(axis=1)
        found = np.zeros(len(points))
        found[inside] = self._distance[tuple(cells[inside].T)]
        return found

    def _cells(self, points: FloatArray) -> NDArray[np.int64]:
        grid = self._grid
        offsets = (np.asarray(points) - (grid.origin_x, grid.origin_y)) / grid.resolution
        return np.floor(offsets[:, ::-1]).astype(np.int64)

    def draw(self, rng: np.random.Generator, clearance: float) -> tuple[float, float]:
        """Return a random free cell (x, y) [m] in map, at least `clearance` [m] from walls.

        Raises ValueError if 10,000 cells are closer.
        """
        for _ in range(10_000):
            x, y = self._centres[int(rng.integers(len(self._centres)))].tolist()
            if self.clearance(np.array([[x, y]]))[0] >= clearance:
                return x, y
        raise ValueError(f"the map has no place {clearance} m from its walls")

    def components(self, clearance: float, discs: Sequence[Disc]) -> NDArray[np.int16]:
        """Return the number of the connected region of each cell, 0 where a robot cannot be.

        The robot's centre keeps `clearance` [m] from walls.
        """
        free = self._distance >= clearance
        for x, y, radius in discs:
            gaps = (self._x - x) ** 2 + (self._y[:, None] - y) ** 2
            free &= gaps >= radius * radius
        return label(free)

    def connected(
        self, labels: NDArray[np.int16], start: tuple[float, float], end: tuple[float, float]
    ) -> bool:
        """True if a region of `components` reaches from near one place to another, both (x, y) [m].

        Up to six cells beside `start` count as well.
        """
        (row, column), (goal_row, goal_column) = self._cells(np.array((start, end))).tolist()
        goal = labels[goal_row, goal_column]
        near = labels[max(0, row - 6) : row + 7, max(0, column - 6) : column + 7]
        return bool(goal > 0 and (near == goal).any())
