"""Drawing of a section onto an occupancy grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import MapError
from swarm_common.model.grid import FREE, OCCUPIED, UNKNOWN, Grid
from swarm_common.model.records import FloatArray
from swarm_sim.scene.section import Section

MARGIN = 0.5  # [m] of map beyond the outermost obstacle
MAX_CELLS = 30_000_000
NOWHERE: FloatArray = np.zeros((0, 2))
SPILL = 0.005  # [m] by which an obstacle may reach into a cell without occupying it
THIN_STEP = 0.25  # of a cell, between the points of an outline that are looked at
INWARD = 1e-6  # share of the way to the middle by which these lie inside


def draw_grid(
    section: Section,
    seeds: FloatArray,
    resolution: float = 0.05,
    margin: float = MARGIN,
    covered: FloatArray = NOWHERE,
) -> Grid:
    """Return the map of a section.

    A cell is occupied if an obstacle reaches more than `SPILL` into it, and wherever else it must
    be for every point of an obstacle to lie within `SPILL` of an occupied cell: no sheet is too
    thin, wherever it lies. The lower left corner of the obstacles lies on a cell corner, so that
    walls on the lattice are drawn without excess.

    Args:
        seeds: Points (n, 2) known to be accessible; what cannot be reached from them becomes
            unknown. With n = 0 everything that is not occupied is free.
        margin: [m] of map around the obstacles, seeds and covered points.
        covered: More points (k, 2) that the map covers.
    """
    x_min, y_min, x_max, y_max = section.bounds()
    points = np.vstack((seeds, covered))
    columns_before = _cells_before(x_min, points[:, 0], margin, resolution)
    rows_before = _cells_before(y_min, points[:, 1], margin, resolution)
    x_max = max(x_max, *points[:, 0], x_min) + margin
    y_max = max(y_max, *points[:, 1], y_min) + margin
    origin_x = round(x_min - columns_before * resolution, 9)
    origin_y = round(y_min - rows_before * resolution, 9)
    width = int(np.ceil((x_max - origin_x) / resolution - 1e-6))
    height = int(np.ceil((y_max - origin_y) / resolution - 1e-6))
    if width * height > MAX_CELLS:
        raise MapError(
            f"a map of {x_max - origin_x:.0f} x {y_max - origin_y:.0f} m at {resolution:g} m "
            f"per cell has {width * height:.1e} cells; expected at most {MAX_CELLS:.0e}: take a "
            "coarser resolution, or look for objects that lie far away or are in another unit"
        )
    grid = draw_on((height, width), resolution, origin_x, origin_y, section)
    if len(seeds):
        cells = np.array([grid.cell_of(x, y) for x, y in seeds], dtype=np.int64)
        grid.cells[(grid.cells == FREE) & ~connected(grid.cells, cells)] = UNKNOWN
    return grid


def connected(cells: NDArray[np.int8], seeds: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which free cells are connected with a seed through free cells (four neighbours).

    Args:
        cells: (height, width).
        seeds: Rows and columns (n, 2); those outside or not free are ignored.
    """
    from scipy.ndimage import label  # slow to import

    labels, count = label(cells == FREE)
    is_reached = np.zeros(count + 1, np.bool_)
    is_inside = ((seeds >= 0) & (seeds < cells.shape)).all(axis=1)
    is_reached[labels[tuple(seeds[is_inside].T)]] = True
    is_reached[0] = False  # the label of all cells that are not free
    reached: NDArray[np.bool_] = is_reached[labels]
    return reached


def draw_on(
    shape: tuple[int, int], resolution: float, origin_x: float, origin_y: float, section: Section
) -> Grid:
    """Return a grid of a given shape and place on which a section is occupied, all else free.

    Args:
        section: Obstacles; those beyond the grid do not count.
    """
    grid = Grid(np.full(shape, FREE, np.int8), resolution, origin_x, origin_y)
    outlines = section.outlines()
    for outline in outlines:
        _draw_polygon(grid, outline)
    for outline in outlines:
        _draw_thin(grid, outline)
    return grid


def _cells_before(low: float, points: FloatArray, margin: float, resolution: float) -> int:
    return int(np.ceil((low - min(low, *points, low) + margin) / resolution - 1e-6))


def _draw_polygon(grid: Grid, outline: FloatArray) -> None:
    """Mark each cell whose square, shrunk by SPILL, meets a convex polygon (separating axes)."""
    low = outline.min(axis=0)
    high = outline.max(axis=0)
    row0, column0 = (max(0, index - 1) for index in grid.cell_of(low[0], low[1]))
    row1, column1 = (index + 2 for index in grid.cell_of(high[0], high[1]))
    rows = np.arange(row0, min(row1, grid.height))
    columns = np.arange(column0, min(column1, grid.width))
    if not len(rows) or not len(columns):
        return
    x = grid.origin_x + (columns[None, :] + 0.5) * grid.resolution
    y = grid.origin_y + (rows[:, None] + 0.5) * grid.resolution
    half = grid.resolution / 2 - SPILL
    meets = (x + half > low[0]) & (x - half < high[0]) & (y + half > low[1]) & (y - half < high[1])
    edges = np.roll(outline, -1, axis=0) - outline
    for (x0, y0), (dx, dy) in zip(outline, edges, strict=True):
        outward = (x - x0) * dy - (y - y0) * dx  # times the edge's length
        meets = meets & (outward - half * (abs(dx) + abs(dy)) < 0.0)
    grid.cells[row0 : row0 + len(rows), column0 : column0 + len(columns)][meets] = OCCUPIED


def _draw_thin(grid: Grid, outline: FloatArray) -> None:
    """Mark the cells of an outline's points that have no occupied cell within SPILL."""
    edges = np.roll(outline, -1, axis=0) - outline
    counts = np.ceil(np.hypot(*edges.T) / (THIN_STEP * grid.resolution)).astype(np.int64) + 1
    share = np.concatenate([(np.arange(count) + 0.5) / count for count in counts])
    points = np.repeat(outline, counts, axis=0) + share[:, None] * np.repeat(edges, counts, axis=0)
    points += INWARD * (outline.mean(axis=0) - points)
    corner = np.array([grid.origin_x, grid.origin_y])
    size = np.array([grid.width, grid.height])
    is_seen = np.zeros(len(points), np.bool_)
    for shift in ((-SPILL, -SPILL), (-SPILL, SPILL), (SPILL, -SPILL), (SPILL, SPILL)):
        cells = np.floor((points + shift - corner) / grid.resolution).astype(np.int64)
        on_grid = ((cells >= 0) & (cells < size)).all(axis=1)
        is_seen[on_grid] |= grid.cells[cells[on_grid, 1], cells[on_grid, 0]] == OCCUPIED
    cells = np.floor((points[~is_seen] - corner) / grid.resolution).astype(np.int64)
    cells = cells[((cells >= 0) & (cells < size)).all(axis=1)]
    grid.cells[cells[:, 1], cells[:, 0]] = OCCUPIED
