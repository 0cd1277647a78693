"""Occupancy grid in Nav2's sense: the one central thing that robots share."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import MapError

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
KEEPOUT = 100  # of a keepout zone: no robot may be there
COARSEST = 0.05  # [m] per cell with which navigators find their way
MOST_CELLS = 30_000_000  # of a map


@dataclass(frozen=True, slots=True)
class Grid:
    """Occupancy grid in the map frame; its axes are parallel to it unless `origin_yaw` says else.

    Conversions between places and cells need an upright grid.
    """

    # int8 (height, width): 0 free, 100 occupied, -1 unknown; row 0 is the lowest y
    cells: NDArray[np.int8]
    resolution: float  # [m] per cell
    origin_x: float  # [m] x of the lower left corner of cell (0, 0)
    origin_y: float  # [m] y of the lower left corner of cell (0, 0)
    origin_yaw: float = 0.0  # [rad] by which the grid is turned about that corner
    # int8 (height, width): KEEPOUT where robots may not be although nothing stands there, 1 to 99
    # where driving costs more, 0 elsewhere; None without any. Only on upright grids.
    keepout: NDArray[np.int8] | None = None

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
        """Return (x, y) [m] in map of a cell's centre.

        Args:
            row: From the lowest y on; may lie outside the grid.
            column: From the lowest x on; may lie outside the grid.
        """
        return (
            self.origin_x + (column + 0.5) * self.resolution,
            self.origin_y + (row + 0.5) * self.resolution,
        )

    def contains(self, x: float, y: float) -> bool:
        """Whether the point lies on the grid."""
        row, column = (y - self.origin_y) / self.resolution, (x - self.origin_x) / self.resolution
        return bool(0.0 <= row < self.height and 0.0 <= column < self.width)

    def upright(self) -> Grid:
        """Return the grid with axes parallel to the map frame: itself, or a resampled one.

        Each new cell takes the value of the old one that its centre lies in; cells that the old
        grid does not cover are unknown.
        """
        if self.origin_yaw == 0.0:
            return self
        cos, sin = np.cos(self.origin_yaw), np.sin(self.origin_yaw)
        size = self.resolution
        corners = np.array(
            [(c * size, r * size) for c in (0, self.width) for r in (0, self.height)]
        )
        x = self.origin_x + cos * corners[:, 0] - sin * corners[:, 1]
        y = self.origin_y + sin * corners[:, 0] + cos * corners[:, 1]
        width, height = (max(1, round(float(np.ptp(v)) / size + 0.499)) for v in (x, y))
        left, low = float(x.min()), float(y.min())
        dx = left + (np.arange(width) + 0.5)[None, :] * size - self.origin_x
        dy = low + (np.arange(height) + 0.5)[:, None] * size - self.origin_y
        columns = np.floor((cos * dx + sin * dy) / size).astype(np.int64)
        rows = np.floor((cos * dy - sin * dx) / size).astype(np.int64)
        covered = (columns >= 0) & (columns < self.width) & (rows >= 0) & (rows < self.height)
        cells = np.full((height, width), UNKNOWN, np.int8)
        cells[covered] = self.cells[rows[covered], columns[covered]]
        return Grid(cells, size, left, low)

    def refined(self) -> Grid:
        """Return the grid with cells small enough to navigate on: itself, or each cell as several.

        Raises:
            MapError: If it would have too many cells.
        """
        parts = int(np.ceil(self.resolution / COARSEST - 1e-6))
        if parts <= 1:
            return self
        if self.cells.size * parts * parts > MOST_CELLS:
            raise MapError(
                f"a map of {self.width} x {self.height} cells of {self.resolution:g} m has more "
                f"than {MOST_CELLS:.0e} cells of {COARSEST:g} m, which navigation needs; cut it"
            )
        cells, keepout = self.cells.repeat(parts, axis=0).repeat(parts, axis=1), self.keepout
        if keepout is not None:
            keepout = keepout.repeat(parts, axis=0).repeat(parts, axis=1)
        size = self.resolution / parts
        return replace(self, cells=cells, resolution=size, keepout=keepout)
