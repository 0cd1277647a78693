"""Bare numba kernels of entry control."""

from __future__ import annotations

import numpy as np
from numba import njit

from swarm_nav.core.order_kernels import outranks
from swarm_nav.core.priority import SENIORITY

BLOCKED = 30  # ticks for which a robot on its way to the mouth has been blocked that no more counts


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
def count_ahead(region, frame, columns, robots, own):
    """Return (robots that count before `own` = (seniority, id), whether none ranks above it, id).

    These are inside, admitted (gate tick 1) or ask (a later gate tick) with a higher rank; of the
    last two only those that are not blocked on their way. The id is that of the highest of those
    who count, 0 without any. columns = (poses, gate ticks, blocked ticks), robots = (ids,
    priorities, gone).
    """
    poses, gate_ticks, blocked = columns
    ids, priorities, gone = robots
    seniority, own_id = own
    count = 0
    is_highest = True
    first = 0
    highest = np.int64(-1)
    for k in range(ids.shape[0]):
        inside = is_inside(region, frame, poses[k, 0], poses[k, 1])
        if not inside and gate_ticks[k] == 0:
            continue
        theirs = priorities[k] & SENIORITY
        ranks_above = outranks(theirs, ids[k], seniority, own_id)
        if ranks_above and not gone[k] and priorities[k] > SENIORITY:  # that has a goal
            is_highest = False
        if inside or (blocked[k] <= BLOCKED and (gate_ticks[k] == 1 or ranks_above)):
            count += 1
            if theirs > highest:
                first, highest = np.int64(ids[k]), theirs
    return count, is_highest, first


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
