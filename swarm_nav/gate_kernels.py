"""Bare numba kernels of entry control."""

from __future__ import annotations

from numba import njit


@njit(cache=True)
def is_inside(region, frame, x, y):
    """Whether (x, y) lies in a cell of the region; frame = (origin_x, origin_y, step)."""
    origin_x, origin_y, step = frame
    i = int((y - origin_y) / step)
    j = int((x - origin_x) / step)
    return 0 <= i < region.shape[0] and 0 <= j < region.shape[1] and region[i, j]


@njit(cache=True)
def enters(region, frame, way):
    """Whether any of the points (n, 2) lies in the region."""
    for k in range(way.shape[0]):
        if is_inside(region, frame, way[k, 0], way[k, 1]):
            return True
    return False


@njit(cache=True)
def count_ahead(region, frame, poses, gate_ticks, ids, own):
    """Robots inside, admitted (gate tick 1), or waiting since an earlier (tick, id) than `own`."""
    tick, own_id = own
    count = 0
    for k in range(ids.shape[0]):
        asked = gate_ticks[k]
        if (
            is_inside(region, frame, poses[k, 0], poses[k, 1])
            or asked == 1
            or (asked > 1 and (asked < tick or (asked == tick and ids[k] < own_id)))
        ):
            count += 1
    return count


@njit(cache=True)
def cells_within(region, frame, centre, reach):
    """Number of the region's cells within `reach` of a point."""
    origin_x, origin_y, step = frame
    x, y = centre
    height, width = region.shape
    span = int(reach / step) + 1
    row = int((y - origin_y) / step)
    column = int((x - origin_x) / step)
    count = 0
    for i in range(max(0, row - span), min(height, row + span + 1)):
        for j in range(max(0, column - span), min(width, column + span + 1)):
            if region[i, j]:
                dx = origin_x + (j + 0.5) * step - x
                dy = origin_y + (i + 0.5) * step - y
                if dx * dx + dy * dy <= reach * reach:
                    count += 1
    return count
