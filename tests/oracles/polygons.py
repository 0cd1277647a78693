"""Slow twin of the polygon kernels: shapely."""

import numpy as np
from numpy.typing import NDArray
from shapely.geometry import Polygon


def distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Return the distance between two convex polygons; 0 if they meet."""
    return float(Polygon(a).distance(Polygon(b)))
