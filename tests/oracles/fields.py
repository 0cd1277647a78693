"""Slow twins of the distance-field kernels: every cell against every other, in plain Python."""

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Frame = tuple[float, float, float]  # origin_x, origin_y, resolution


def face_distance(occupied: NDArray[np.bool_]) -> FloatArray:
    """Return the distance [cells] of each centre to the nearest occupied square; inf without."""
    result = np.full(occupied.shape, np.inf)
    rows, columns = np.indices(occupied.shape)
    for row, column in np.argwhere(occupied):
        beyond_row = np.maximum(np.abs(rows - row) - 0.5, 0.0)
        beyond_column = np.maximum(np.abs(columns - column) - 0.5, 0.0)
        result = np.minimum(result, np.hypot(beyond_row, beyond_column))
    return result


def sample(field: FloatArray, frame: Frame, x: float, y: float) -> float:
    """Return the bilinear value between cell centres, the border's value outside."""
    origin_x, origin_y, resolution = frame
    height, width = field.shape
    u = (x - origin_x) / resolution - 0.5
    v = (y - origin_y) / resolution - 0.5
    rows = [np.interp(u, np.arange(width), field[row]) for row in range(height)]
    return float(np.interp(v, np.arange(height), rows))


def stamp_discs(
    grid: NDArray[np.float32], frame: Frame, points: FloatArray, radius: float, value: float
) -> NDArray[np.float32]:
    """Return the grid with the cells whose centres lie in a disc raised to at least `value`."""
    origin_x, origin_y, step = frame
    result = grid.copy()
    for row, column in np.ndindex(grid.shape):
        x, y = origin_x + (column + 0.5) * step, origin_y + (row + 0.5) * step
        if any(math.hypot(x - px, y - py) < radius for px, py in points):
            result[row, column] = max(result[row, column], value)
    return result


def resample(points: FloatArray, spacing: float) -> FloatArray:
    """Return points every `spacing` of arc length; the end replaces a point too near to it."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    along = np.concatenate(([0.0], np.cumsum(lengths)))
    stations = np.arange(0.0, along[-1] + 1e-9, spacing)
    inner = np.column_stack([np.interp(stations, along, points[:, axis]) for axis in (0, 1)])
    gap = math.hypot(*(points[-1] - inner[-1]))
    if len(inner) > 1 and gap <= 0.2 * spacing:
        inner = inner[:-1]
    elif gap <= 1e-6:
        return inner
    return np.vstack((inner, points[-1]))


def corners(points: FloatArray, angle: float) -> list[int]:
    """Return where a path bends by more than `angle`; of bends within two points the sharpest.

    All places where it turns back count, too.
    """
    found: list[tuple[int, float]] = []
    for k in range(1, len(points) - 1):
        turns_back = _bend(points, k, 1) > 0.5 * math.pi
        bend = math.inf if turns_back else _bend(points, k, min(2, k, len(points) - 1 - k))
        if bend <= angle:
            continue
        is_beside = bool(found) and k - found[-1][0] <= 2
        if is_beside and bend > found[-1][1]:
            found[-1] = (k, bend)
        elif not is_beside or turns_back:
            found.append((k, bend))
    return [k for k, _ in found]


def _bend(points: FloatArray, k: int, arm: int) -> float:
    (ax, ay), (bx, by) = points[k] - points[k - arm], points[k + arm] - points[k]
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
