"""Points and meshes for viser, from arrays in the plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray

CORNERS = 24  # of a disc
NOSE = 1.6  # of a pointer's radius, from its middle to its tip
Mesh = tuple[NDArray[np.float32], NDArray[np.uint32]]  # vertices (n, 3), faces (m, 3)


def lifted(points: FloatArray, height: float) -> FloatArray:
    """Return points (n, 2) as (n, 3) at a height [m]."""
    return np.column_stack([points, np.full(len(points), height)])


def raised(segments: FloatArray, height: float) -> FloatArray:
    """Return segments (n, 2, 2) as (n, 2, 3) at a height [m]."""
    result = np.full((len(segments), 2, 3), height)
    result[:, :, :2] = segments
    return result


def polyline(points: FloatArray, height: float) -> FloatArray:
    """Return the segments (n - 1, 2, 3) of a polyline (n, 2)."""
    raised = lifted(points, height)
    return np.stack([raised[:-1], raised[1:]], axis=1)


def loop(points: FloatArray, height: float) -> FloatArray:
    """Return the segments of a closed polyline."""
    return polyline(np.vstack([points, points[:1]]), height)


def quaternions(yaws: FloatArray) -> FloatArray:
    """Return (n, 4) w, x, y, z of turns about z."""
    turns = np.zeros((len(yaws), 4))
    turns[:, 0], turns[:, 3] = np.cos(0.5 * yaws), np.sin(0.5 * yaws)
    return turns


def pointer(radius: float) -> Mesh:
    """Return a flat disc around the origin with a nose towards x."""
    angles = np.linspace(0.25 * np.pi, 1.75 * np.pi, CORNERS)
    rim = radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(CORNERS)])
    tip = np.array([[NOSE * radius, 0.0, 0.0]])
    vertices = np.vstack([np.zeros((1, 3)), tip, rim]).astype(np.float32)
    here = np.arange(1, CORNERS + 2, dtype=np.uint32)
    there = np.roll(here, -1)
    return vertices, np.column_stack([np.zeros_like(here), here, there])


def floor(x_min: float, y_min: float, x_max: float, y_max: float) -> Mesh:
    """Return a rectangle at height zero, seen from above."""
    vertices = np.array(
        [[x_min, y_min, 0], [x_max, y_min, 0], [x_max, y_max, 0], [x_min, y_max, 0]], np.float32
    )
    return vertices, np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


def on_floor(origin: FloatArray, direction: FloatArray) -> FloatArray | None:
    """Return where a ray meets the floor (2,); None if it does not."""
    if direction[2] > -1e-6:
        return None
    point: FloatArray = origin[:2] - direction[:2] * (origin[2] / direction[2])
    return point


def nearest_to_ray(
    centers: FloatArray, radius: float, origin: FloatArray, direction: FloatArray
) -> int | None:
    """Return the first of the balls (n, 3) of a radius that a ray meets; None if it meets none."""
    along = direction / np.linalg.norm(direction)
    offsets = centers - origin
    depths = offsets @ along
    gaps = np.linalg.norm(offsets - depths[:, None] * along, axis=1)
    hit = np.flatnonzero((gaps < radius) & (depths > 0.0))
    return int(hit[np.argmin(depths[hit])]) if len(hit) else None
