"""Occupancy grid in Nav2's sense: the one central thing that robots share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FREE, OCCUPIED, UNKNOWN = 0, 100, -1


@dataclass(frozen=True, slots=True)
class Grid:
    """Occupancy grid in the map frame, axes parallel to it.

    Attributes:
        cells: int8 (height, width): 0 free, 100 occupied, -1 unknown; row 0 is the lowest y.
        resolution: [m] per cell.
        origin_x: [m] x of the lower left corner of cell (0, 0).
        origin_y: [m] y of the lower left corner of cell (0, 0).
    """

    cells: NDArray[np.int8]
    resolution: float
    origin_x: float
    origin_y: float

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.cells.shape[0])

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self.cells.shape[1])

    def cell_of(self, x: float, y: float) -> tuple[int, int]:
        """Return (row, column) of a point; may lie outside the grid."""
        return (
            int(np.floor((y - self.origin_y) / self.resolution)),
            int(np.floor((x - self.origin_x) / self.resolution)),
        )

    def center_of(self, row: int, column: int) -> tuple[float, float]:
        """Return (x, y) of a cell's centre."""
        return (
            self.origin_x + (column + 0.5) * self.resolution,
            self.origin_y + (row + 0.5) * self.resolution,
        )

    def contains(self, x: float, y: float) -> bool:
        """Whether the point lies on the grid."""
        row, column = self.cell_of(x, y)
        return 0 <= row < self.height and 0 <= column < self.width
