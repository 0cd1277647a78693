"""Distances between the cells of a grid, and the parts of it that hang together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

EIGHT = np.ones((3, 3), np.bool_)  # neighbours across edges and corners


def distance_cells(occupied: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the exact distance [cells] from each cell centre to the nearest occupied one.

    Args:
        occupied: (h, w).

    Returns:
        (h, w), 0 on occupied cells, inf where no cell is occupied.
    """
    if not occupied.any():
        return np.full(occupied.shape, np.inf)
    return np.asarray(ndimage.distance_transform_edt(~occupied), np.float64)


def label(mask: NDArray[np.bool_]) -> NDArray[np.int16]:
    """Return (h, w) the numbers of a mask's parts, from 1 in the order of their first cells."""
    return np.asarray(ndimage.label(mask, EIGHT, output=np.int16)[0], np.int16)


def window_max(field: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Return (h, w) the largest value of a field within `reach` [cells] around each cell."""
    y, x = np.ogrid[-reach : reach + 1, -reach : reach + 1]
    disc = x * x + y * y <= reach * reach
    return np.asarray(ndimage.maximum_filter(field, footprint=disc, mode="constant", cval=-np.inf))
