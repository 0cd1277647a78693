"""The smallest gap between robots and what they hold: the safety invariant of every tick."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit


@njit(cache=True)
def smallest_gap(
    places: NDArray[np.float32],
    held: NDArray[np.float32],
    sizes: NDArray[np.uint32],
    radii: NDArray[np.float32],
    bounds: NDArray[np.float64],
    far: float,
    best: NDArray[np.float64],
) -> None:
    """Find the pair of robots whose bodies or tubes have the smallest distance.

    Args:
        places: (n, 2) [m] of the robots.
        held: Points (n, p, 2) [m] of each tube.
        sizes: (n,) points in use; 0 for a robot that is left out.
        radii: (n,) [m] of each tube.
        bounds: (n, 4) scratch.
        far: [m] distances from here on are of no interest.
        best: (4,) out: smallest distance, smallest distance less the radii, and the pair's
            indices; left as it is where nothing is nearer.
    """
    count = len(sizes)
    for i in range(count):
        bounds[i, 0] = bounds[i, 1] = np.inf
        bounds[i, 2] = bounds[i, 3] = -np.inf
        if sizes[i] > 0:
            bounds[i, 0] = bounds[i, 2] = places[i, 0]
            bounds[i, 1] = bounds[i, 3] = places[i, 1]
        for k in range(sizes[i]):
            x, y = held[i, k, 0], held[i, k, 1]
            bounds[i, 0] = min(bounds[i, 0], x)
            bounds[i, 1] = min(bounds[i, 1], y)
            bounds[i, 2] = max(bounds[i, 2], x)
            bounds[i, 3] = max(bounds[i, 3], y)
    for i in range(count):
        for j in range(i):
            if (
                bounds[i, 0] - bounds[j, 2] > far
                or bounds[j, 0] - bounds[i, 2] > far
                or bounds[i, 1] - bounds[j, 3] > far
                or bounds[j, 1] - bounds[i, 3] > far
            ):
                continue
            nearest = far * far
            for k in range(-1, sizes[i]):
                at = places[i] if k < 0 else held[i, k]
                for m in range(-1, sizes[j]):
                    other = places[j] if m < 0 else held[j, m]
                    dx, dy = at[0] - other[0], at[1] - other[1]
                    nearest = min(nearest, dx * dx + dy * dy)
            gap = np.sqrt(nearest)
            if gap < far:
                best[0] = min(best[0], gap)
                slack = gap - radii[i] - radii[j]
                if slack < best[1]:
                    best[1] = slack
                    best[2] = i
                    best[3] = j
