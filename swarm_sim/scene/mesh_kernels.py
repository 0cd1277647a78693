"""Numba kernels on the cut through a mesh: which points are inside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, IntArray
from swarm_common.process.numba_compat import njit


@njit(cache=True)
def crossings(points: FloatArray, segments: FloatArray) -> tuple[IntArray, IntArray]:
    """Return how segments wind around points, and how many lie to the right of each.

    Args:
        points: (n, 2), on no segment.
        segments: (m, 2, 2), directed.

    Returns:
        Winding numbers (n,), where the segments make closed figures; crossings (n,) of the ray
        along x.
    """
    winding = np.zeros(len(points), np.int64)
    count = np.zeros(len(points), np.int64)
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        for k in range(len(segments)):
            x0, y0 = segments[k, 0, 0], segments[k, 0, 1]
            x1, y1 = segments[k, 1, 0], segments[k, 1, 1]
            if (y0 > y) == (y1 > y):
                continue
            if x0 + (y - y0) / (y1 - y0) * (x1 - x0) > x:
                winding[i] += 1 if y1 > y0 else -1
                count[i] += 1
    return winding, count


@njit(cache=True)
def roofed(
    points: FloatArray, level: float, corners: FloatArray, faces: IntArray
) -> NDArray[np.bool_]:
    """Return which points of a horizontal plane have a triangle below and one above.

    Args:
        points: (n, 2).
        level: Height of the plane.
        corners: (k, 3) of the triangles.
        faces: (m, 3) indices of corners.
    """
    found = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        below = above = False
        for k in range(len(faces)):
            a, b, c = corners[faces[k, 0]], corners[faces[k, 1]], corners[faces[k, 2]]
            if max(a[0], b[0], c[0]) < x or min(a[0], b[0], c[0]) > x:
                continue
            if max(a[1], b[1], c[1]) < y or min(a[1], b[1], c[1]) > y:
                continue
            area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            if area == 0.0:
                continue
            u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
            v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
            if u < -1e-9 or v < -1e-9 or u + v > 1.0 + 1e-9:
                continue
            if a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]) > level:
                above = True
            else:
                below = True
            if below and above:
                found[i] = True
                break
    return found
