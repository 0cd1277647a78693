"""Costmaps with Nav2's cost scale, composed on request.

Layers: static (the map), keepout zones, obstacles (LiDAR), neighbours (footprints and commitments),
inflation: 252 exp(-k (d - r_inscribed)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.grid import KEEPOUT, OCCUPIED, UNKNOWN
from swarm_common.process.libm import exp
from swarm_nav.interfaces import Costmap
from swarm_nav.planning import distance_kernels
from swarm_nav.planning.cells import distance_cells
from swarm_nav.traffic.robot_state import RobotView

FREE, LARGEST_FREE, INSCRIBED, LETHAL, NO_INFORMATION = 0, 252, 253, 254, 255


@dataclass(frozen=True, slots=True)
class Window:
    """A rectangle of cells."""

    rows: slice
    columns: slice


def changed_window(before: Costmap, now: Costmap) -> Window | None:
    """Return the smallest rectangle that holds every changed cell.

    Returns:
        The rectangle. None where nothing has changed, and where the costmaps cannot be compared:
        another size, resolution or origin.
    """
    geometry = (before.resolution, before.origin_x, before.origin_y, before.cells.shape)
    if geometry != (now.resolution, now.origin_x, now.origin_y, now.cells.shape):
        return None
    has_changed = before.cells != now.cells
    rows = np.flatnonzero(has_changed.any(axis=1))
    columns = np.flatnonzero(has_changed.any(axis=0))
    if len(rows) == 0:
        return None
    return Window(
        slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
    )


def inflate(
    lethal: NDArray[np.bool_],
    resolution: float,
    inscribed_radius: float,
    inflation_radius: float,
    scaling: float,
) -> NDArray[np.uint8]:
    """Return costs (h, w) of lethal cells and their inflation (Nav2's InflationLayer).

    Args:
        lethal: (h, w) cells that are occupied.
        resolution: [m] edge of a cell.
        inscribed_radius: [m] within which the robot touches for sure.
        inflation_radius: [m] beyond which there is no cost.
        scaling: [1/m] of the exponential decay between the two.
    """
    costs = np.zeros(lethal.shape, np.uint8)
    if not lethal.any():
        return costs
    distance = distance_cells(lethal) * resolution
    near = distance <= inflation_radius
    decay = exp(-scaling * (distance[near] - inscribed_radius))
    costs[near] = np.minimum(LARGEST_FREE, LARGEST_FREE * decay).astype(np.uint8)
    costs[distance <= inscribed_radius] = INSCRIBED
    costs[lethal] = LETHAL
    return costs


def compose(robot: RobotView, inscribed_radius: float, window: float | None) -> Costmap:
    """Return the global costmap, or with `window` [m] the rolling local one around the robot.

    Args:
        inscribed_radius: [m] of its footprint.
        window: [m] edge of the local costmap; None for the global one.
    """
    grid = robot.terrain.grid
    resolution = grid.resolution
    rows, columns = (0, grid.height), (0, grid.width)
    if window is not None:
        row, column = grid.cell_of(robot.pose.x, robot.pose.y)
        half = math.ceil(window / 2 / resolution)
        rows, columns = (row - half, row + half), (column - half, column + half)
    cells = _window(grid.cells, rows, columns)
    origin_x = grid.origin_x + columns[0] * resolution
    origin_y = grid.origin_y + rows[0] * resolution
    lethal = cells == OCCUPIED
    if grid.keepout is not None:
        lethal |= _window(grid.keepout, rows, columns, outside=0) == KEEPOUT
    _mark(lethal, robot.obstacle_points(), resolution, origin_x, origin_y, resolution / 2)
    neighbors = robot.neighbors
    for index in range(len(neighbors.beacons)):
        radius = float(neighbors.beacons[index]["radius"])
        _mark(lethal, neighbors.tubes(index), resolution, origin_x, origin_y, radius)
    costmap = robot.config.costmap
    costs = inflate(
        lethal, resolution, inscribed_radius, costmap.inflation_radius, costmap.cost_scaling_factor
    )
    costs[(cells == UNKNOWN) & (costs < INSCRIBED)] = NO_INFORMATION
    return Costmap(costs, resolution, origin_x, origin_y)


def _window(
    cells: NDArray[np.int8], rows: tuple[int, int], columns: tuple[int, int], outside: int = UNKNOWN
) -> NDArray[np.int8]:
    """Return a block that may hang over the grid's edge."""
    out = np.full((rows[1] - rows[0], columns[1] - columns[0]), outside, np.int8)
    r0, r1 = max(0, rows[0]), min(cells.shape[0], rows[1])
    c0, c1 = max(0, columns[0]), min(cells.shape[1], columns[1])
    if r0 < r1 and c0 < c1:
        out[r0 - rows[0] : r1 - rows[0], c0 - columns[0] : c1 - columns[0]] = cells[r0:r1, c0:c1]
    return out


def _mark(
    lethal: NDArray[np.bool_],
    points: object,
    resolution: float,
    origin_x: float,
    origin_y: float,
    radius: float,
) -> None:
    block = np.ascontiguousarray(points, np.float64).reshape(-1, 2)
    if len(block) == 0:
        return
    stamped = np.zeros(lethal.shape, np.float32)
    distance_kernels.stamp_discs(
        stamped, (origin_x, origin_y, resolution), block, len(block), max(radius, resolution), 1.0
    )
    lethal |= stamped > 0
