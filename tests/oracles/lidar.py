"""Slow twin of the LiDAR kernels: every ray against every obstacle, in plain Python."""

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def ranges(
    sensor: tuple[float, float, float],
    segments: FloatArray,
    discs: FloatArray,
    angle_min: float,
    angle_increment: float,
    rays: int,
    range_max: float,
) -> FloatArray:
    """Return the true range of each ray by solving origin + t d = point on the obstacle."""
    result = np.full(rays, np.inf)
    x, y, yaw = sensor
    for k in range(rays):
        angle = yaw + angle_min + k * angle_increment
        d = np.array([math.cos(angle), math.sin(angle)])
        hits = [np.inf]
        for x0, y0, x1, y1 in segments:
            matrix = np.array([[d[0], x0 - x1], [d[1], y0 - y1]])
            if abs(np.linalg.det(matrix)) < 1e-15:
                continue
            t, u = np.linalg.solve(matrix, [x0 - x, y0 - y])
            if t >= 0.0 and -1e-12 <= u <= 1.0 + 1e-12:
                hits.append(t)
        for cx, cy, radius in discs:
            b = d @ [x - cx, y - cy]
            c = (x - cx) ** 2 + (y - cy) ** 2 - radius**2
            if b * b >= c:
                root = math.sqrt(b * b - c)
                hits.extend(t for t in (-b - root, -b + root) if t >= 0.0)
        nearest = min(hits)
        if nearest <= range_max:
            result[k] = nearest
    return result
