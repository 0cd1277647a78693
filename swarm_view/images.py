"""Grids as images: the map in grey, costs in colours that let the map shine through."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_view.decode import Raster

Image = NDArray[np.uint8]
FREE, UNKNOWN, WALL = (244, 244, 240), (205, 205, 205), (70, 74, 80)
LOW, HIGH = np.array([86, 180, 233]), np.array([213, 94, 0])
INSCRIBED, LETHAL = (204, 121, 167, 200), (60, 20, 60, 220)


def map_image(raster: Raster) -> Image:
    """Return the map as RGB (height, width, 3), the highest y on top."""
    cells = raster.cells[::-1]
    image = np.empty((*cells.shape, 3), np.uint8)
    image[:] = FREE
    image[cells < 0] = UNKNOWN
    image[cells >= 50] = WALL
    return image


def _cost_table() -> Image:
    table = np.zeros((256, 4), np.uint8)
    share = np.linspace(0.0, 1.0, 98)[:, None]
    table[1:99, :3] = (1.0 - share) * LOW + share * HIGH
    table[1:99, 3] = 60 + 100 * share[:, 0]
    table[99], table[100] = INSCRIBED, LETHAL
    return table


COSTS = _cost_table()


def cost_image(raster: Raster) -> Image:
    """Return a costmap (0 to 100, -1 unknown) as RGBA (height, width, 4), highest y on top."""
    image: Image = COSTS[raster.cells[::-1].view(np.uint8)]
    return image
