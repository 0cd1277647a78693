"""Grids as images: the map in grey, costs in colours over it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.palette import RGB
from swarm_view.state.decode import Raster

Image = NDArray[np.uint8]
SPACINGS, MOST_LINES = (1, 2, 5, 10, 20, 50, 100), 10  # [m] between lines of the floor's grid


@dataclass(frozen=True, slots=True)
class Shades:
    """Colours of everything but robots."""

    free: RGB
    grid: RGB
    unknown: RGB
    wall: RGB
    background: RGB


# Robots of every colour stand out from the floor, and the floor from what is around the hall.
LIGHT = Shades((247, 247, 244), (228, 230, 230), (205, 209, 214), (62, 66, 72), (192, 197, 203))
DARK = Shades((62, 67, 74), (74, 80, 88), (34, 38, 43), (148, 154, 162), (20, 23, 27))
FREE = LIGHT.free
LOW, HIGH = np.array([86, 180, 233]), np.array([213, 94, 0])
INSCRIBED, LETHAL = (204, 121, 167, 200), (60, 20, 60, 220)


def map_image(raster: Raster, shades: Shades = LIGHT) -> Image:
    """Return the map as RGB (height, width, 3), the highest y on top."""
    cells = raster.cells[::-1]
    image = np.empty((*cells.shape, 3), np.uint8)
    image[:] = shades.free
    _draw_grid(image, raster, shades.grid)
    image[cells < 0] = shades.unknown
    image[cells >= 50] = shades.wall
    return image


def grid_lines(low: float, high: float) -> range:
    """Return where the lines of the grid are [m] within an extent, so that some numbers fit."""
    spacing = next((step for step in SPACINGS if high - low <= MOST_LINES * step), SPACINGS[-1])
    return range(math.ceil(low / spacing) * spacing, math.floor(high) + 1, spacing)


def _draw_grid(image: Image, raster: Raster, color: RGB) -> None:
    (left, low), (width, depth) = raster.origin, raster.size
    rows, columns = raster.cells.shape
    for x in grid_lines(left, left + width):
        image[:, min(columns - 1, int((x - left) / raster.resolution))] = color
    for y in grid_lines(low, low + depth):
        image[max(0, rows - 1 - int((y - low) / raster.resolution))] = color


def _cost_table() -> Image:
    table = np.zeros((256, 4), np.uint8)
    share = np.linspace(0.0, 1.0, 98)[:, None]
    table[1:99, :3] = (1.0 - share) * LOW + share * HIGH
    table[1:99, 3] = 60 + 100 * share[:, 0]
    table[99], table[100] = INSCRIBED, LETHAL
    return table


COSTS = _cost_table()


def cost_image(raster: Raster, floor: Raster | None = None) -> Image:
    """Return a costmap (0 to 100, -1 unknown) over the map, or over white, highest y on top.

    It is opaque, (height, width, 3): where pictures lie upon each other, browsers do not draw
    through the upper one reliably.
    """
    below = np.full((*raster.cells.shape, 3), FREE, np.float32)
    if floor is not None:
        below[:] = map_image(Raster(_sampled(floor, raster), raster.resolution, raster.origin))
    colors = COSTS[raster.cells[::-1].view(np.uint8)]
    share = colors[..., 3:] / np.float32(255.0)
    image: Image = (colors[..., :3] * share + below * (1.0 - share)).astype(np.uint8)
    return image


def _sampled(source: Raster, target: Raster) -> NDArray[np.int8]:
    """Return the cells of a grid at the centres of another one's cells; unknown outside."""
    cells = np.full(target.cells.shape, -1, np.int8)
    height, width = target.cells.shape
    columns, rows = (
        np.floor((origin - base + (np.arange(count) + 0.5) * target.resolution) / source.resolution)
        for origin, base, count in zip(target.origin, source.origin, (width, height), strict=True)
    )
    inside_x = (columns >= 0) & (columns < source.cells.shape[1])
    inside_y = (rows >= 0) & (rows < source.cells.shape[0])
    picked = source.cells[np.ix_(rows[inside_y].astype(int), columns[inside_x].astype(int))]
    cells[np.ix_(inside_y, inside_x)] = picked
    return cells
