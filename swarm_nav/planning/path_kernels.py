"""Bare numba kernels on paths: resampling, smoothing, corners; checked faces are in planner.py.

Args of more than one kernel:
    points: (n, 2) [m].
    spacing: [m] along the polyline.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Field, Floats, Frame, sample

CHORD_POINTS = 2  # path points on either side over which a bend is measured


class Smoothing(NamedTuple):
    """Parameters by which a path is smoothed, see `smooth_path` and `lift_off_walls`."""

    passes: int  # of the moving average
    reach: int  # points on either side that are averaged
    rounds: int  # of lifting, a centimetre each


class WallClearance(NamedTuple):
    """Walls and the distance that a smoothed path keeps from them."""

    field: Field
    floor: float  # [m] from a wall below which a point may not come nearer to it


class Blocked(NamedTuple):
    """Costs that other robots add per metre; a point may not move to a dearer cell."""

    extra: NDArray[np.float32]  # (h, w)
    frame: Frame


@njit(cache=True)
def smooth_path(
    points: Floats, passes: int, reach: int, walls: WallClearance, others: Blocked, out: Floats
) -> None:
    """Fill `out` (n, 2) with the moving average of +-`reach` points (n, 2), where that is clear.

    A point stays where it is if the average is below the floor and nearer to a wall, or in a
    cell with a larger value of `others`. The ends stay.

    Args:
        points: (n, 2) [m] in map.
        passes: Times that it is averaged.
        reach: Points on either side that are averaged.
        out: (n, 2) receives the path.
    """
    field, frame = walls.field.distance, walls.field.frame
    floor = walls.floor
    blocked, blocked_frame = others.extra, others.frame
    n = points.shape[0]
    for k in range(n):
        out[k, 0] = points[k, 0]
        out[k, 1] = points[k, 1]
    previous = points.copy()
    for _ in range(passes):
        for k in range(1, n - 1):
            half = min(reach, k, n - 1 - k)
            x = 0.0
            y = 0.0
            for j in range(k - half, k + half + 1):
                x += previous[j, 0]
                y += previous[j, 1]
            x /= 2 * half + 1
            y /= 2 * half + 1
            now = sample(field, frame, x, y)
            if now < floor and now < sample(field, frame, previous[k, 0], previous[k, 1]):
                x, y = previous[k, 0], previous[k, 1]
            elif cell_value(blocked, blocked_frame, x, y) > cell_value(
                blocked, blocked_frame, previous[k, 0], previous[k, 1]
            ):
                x, y = previous[k, 0], previous[k, 1]
            out[k, 0] = x
            out[k, 1] = y
        for k in range(n):
            previous[k, 0] = out[k, 0]
            previous[k, 1] = out[k, 1]


@njit(cache=True)
def cell_value(grid: NDArray[np.float32], frame: Frame, x: float, y: float) -> float:
    """Return the value of the cell that holds (x, y) [m] in map; 1e9 outside of the grid.

    Args:
        grid: (h, w).
        x: [m] in map.
        y: [m] in map.
    """
    r = math.floor((y - frame.origin_y) / frame.step)
    c = math.floor((x - frame.origin_x) / frame.step)
    if r < 0 or c < 0 or r >= grid.shape[0] or c >= grid.shape[1]:
        return grid[0, 0] * 0 + np.float32(1e9)
    return grid[r, c]


@njit(cache=True)
def lift_off_walls(points: Floats, walls: WallClearance, rounds: int) -> None:
    """Move inner points (n, 2) up the distance field to the floor, a centimetre a round.

    Args:
        points: (n, 2) [m] in map; changed.
        rounds: A centimetre each.
    """
    field, frame = walls.field.distance, walls.field.frame
    wanted = walls.floor
    eps = frame.step
    for k in range(1, points.shape[0] - 1):
        for _ in range(rounds):
            x = points[k, 0]
            y = points[k, 1]
            here = sample(field, frame, x, y)
            if here >= wanted:
                break
            gx = sample(field, frame, x + eps, y) - sample(field, frame, x - eps, y)
            gy = sample(field, frame, x, y + eps) - sample(field, frame, x, y - eps)
            norm = math.hypot(gx, gy)
            if norm < 1e-6:
                break
            step = min(0.01, wanted - here)
            x += step * gx / norm
            y += step * gy / norm
            if sample(field, frame, x, y) <= here:
                break
            points[k, 0] = x
            points[k, 1] = y


@njit(cache=True)
def resample(points: Floats, spacing: float, out: Floats) -> int:
    """Write points at equal spacing along a polyline; its last point is kept exactly.

    Args:
        points: (n, 2) [m], n at least 1.
        out: (m, 2) receives the points; `capacity_for` says how many there may be.

    Returns:
        The number of points written.
    """
    n = points.shape[0]
    out[0, 0] = points[0, 0]
    out[0, 1] = points[0, 1]
    count = 1
    carried = 0.0
    for k in range(1, n):
        dx = points[k, 0] - points[k - 1, 0]
        dy = points[k, 1] - points[k - 1, 1]
        length = math.hypot(dx, dy)
        if length < 1e-12:
            continue
        along = spacing - carried
        while along <= length and count < out.shape[0] - 1:
            out[count, 0] = points[k - 1, 0] + dx * along / length
            out[count, 1] = points[k - 1, 1] + dy * along / length
            count += 1
            along += spacing
        carried = length - (along - spacing)
    last = math.hypot(points[n - 1, 0] - out[count - 1, 0], points[n - 1, 1] - out[count - 1, 1])
    if last > 0.2 * spacing or count == 1:
        if last > 1e-6:
            out[count, 0] = points[n - 1, 0]
            out[count, 1] = points[n - 1, 1]
            count += 1
    else:
        out[count - 1, 0] = points[n - 1, 0]
        out[count - 1, 1] = points[n - 1, 1]
    return count


@njit(cache=True)
def capacity_for(points: Floats, spacing: float) -> int:
    """Largest number of points that `resample` may write.

    Args:
        spacing: [m].
    """
    length = 0.0
    for k in range(points.shape[0] - 1):
        length += math.hypot(points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1])
    return int(length / spacing) + points.shape[0] + 4


@njit(cache=True)
def resampled(points: Floats, spacing: float) -> NDArray[np.float64]:
    """Return new points at equal spacing along a polyline; the last one is kept exactly.

    Args:
        points: (n, 2) [m], n at least 1.

    Returns:
        (m, 2) [m].
    """
    out = np.empty((capacity_for(points, spacing), 2))
    return out[: resample(points, spacing, out)].copy()


@njit(cache=True)
def with_ends(
    points: Floats, ends: Floats, gap: float, walls: WallClearance
) -> NDArray[np.float64]:
    """Put new ends to a path, and leave out its points that are too near to them.

    The path's own ends are left out, too, but for one that a straight way past it would lead
    below the floor: an end may lie away from the path's, where the nodes beside it are taken.

    Args:
        ends: (2, 2) [m].
        gap: [m] that the points keep from both ends.

    Returns:
        (m, 2) [m], from the first end to the last.
    """
    last = points.shape[0] - 1
    out = np.empty((points.shape[0] + 2, 2))
    out[0] = ends[0]
    count = 1
    for k in range(1, last):
        if _is_apart(points[k], ends, gap):
            out[count] = points[k]
            count += 1
    out[count] = ends[1]
    starts_at_wall = _nears_wall(out[0], out[1], walls)
    ends_at_wall = _nears_wall(out[count - 1], out[count], walls)
    if ends_at_wall and last > 0 and _is_apart(points[last], ends, gap):
        out[count] = points[last]
        count += 1
        out[count] = ends[1]
    if starts_at_wall and _is_apart(points[0], ends, gap):
        for k in range(count, 0, -1):
            out[k + 1] = out[k]
        out[1] = points[0]
        count += 1
    return out[: count + 1]


@njit(cache=True)
def _is_apart(point: Floats, ends: Floats, gap: float) -> bool:
    first = math.hypot(point[0] - ends[0, 0], point[1] - ends[0, 1])
    last = math.hypot(point[0] - ends[1, 0], point[1] - ends[1, 1])
    return min(first, last) > gap


@njit(cache=True)
def _nears_wall(a: Floats, b: Floats, walls: WallClearance) -> bool:
    """Whether a leg leads below the floor, and nearer to a wall than both of its ends are."""
    field, frame = walls.field.distance, walls.field.frame
    floor = min(walls.floor, sample(field, frame, a[0], a[1]), sample(field, frame, b[0], b[1]))
    steps = math.ceil(math.hypot(b[0] - a[0], b[1] - a[1]) / (frame.step / 2))
    for k in range(1, steps):
        x = a[0] + (b[0] - a[0]) * k / steps
        y = a[1] + (b[1] - a[1]) * k / steps
        if sample(field, frame, x, y) < floor:
            return True
    return False


@njit(cache=True)
def drivable(
    points: Floats, spacing: float, smoothing: Smoothing, walls: WallClearance, others: Blocked
) -> NDArray[np.float64]:
    """Return points (m, 2) every `spacing` [m] along a smoothed polyline (n, 2) in map.

    Args:
        points: (n, 2) [m] in map.
        spacing: [m] of the result.
    """
    path = resampled(points, spacing)
    if path.shape[0] < 3:
        return path
    smoothed = np.empty_like(path)
    smooth_path(path, smoothing.passes, smoothing.reach, walls, others, smoothed)
    lift_off_walls(smoothed, walls, smoothing.rounds)
    return resampled(smoothed, spacing)


@njit(cache=True)
def thinned(points: Floats, gap: float) -> NDArray[np.float64]:
    """Leave out points nearer than a gap to the one before them, but for the first and the last.

    Points at equal distances along a polyline are that near only where it turns back.

    Args:
        gap: [m]

    Returns:
        (m, 2) [m].
    """
    out = np.empty_like(points)
    count = 0
    last = points.shape[0] - 1
    for k in range(last + 1):
        if 0 < k < last:
            x, y = points[k, 0] - out[count - 1, 0], points[k, 1] - out[count - 1, 1]
            if math.hypot(x, y) < gap:
                continue
        out[count] = points[k]
        count += 1
    return out[:count].copy()


@njit(cache=True)
def corners(points: Floats, angle: float) -> NDArray[np.int64]:
    """Find the sharp bends of a path. Of bends that overlap the sharpest counts.

    Where the path turns back by more than a right angle is always a corner, also beside another
    one: progress along a path is measured between corners, where it must not lead back.

    Args:
        angle: [rad] by which the path must bend within two chords of `CHORD_POINTS` points.

    Returns:
        (k,) indices of points, in rising order.
    """
    found = np.empty(points.shape[0], np.int64)
    count = 0
    sharpest = 0.0
    for k in range(1, points.shape[0] - 1):
        bend = _bend(points, k, 1)
        turns_back = bend > 0.5 * math.pi
        if turns_back:
            bend = 2.0 * math.pi  # sharper than all that only bend
        else:
            bend = _bend(points, k, min(CHORD_POINTS, k, points.shape[0] - 1 - k))
            if bend <= angle:
                continue
        if count > 0 and k - found[count - 1] <= CHORD_POINTS:
            if bend < sharpest or (bend == sharpest and not turns_back):
                continue
            if bend > sharpest:
                count -= 1
        found[count] = k
        sharpest = bend
        count += 1
    return found[:count].copy()


@njit(cache=True)
def _bend(points: Floats, k: int, arm: int) -> float:
    """Return the angle [rad] between the chords of `arm` points before and after point `k`."""
    ax = points[k, 0] - points[k - arm, 0]
    ay = points[k, 1] - points[k - arm, 1]
    bx = points[k + arm, 0] - points[k, 0]
    by = points[k + arm, 1] - points[k, 1]
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
