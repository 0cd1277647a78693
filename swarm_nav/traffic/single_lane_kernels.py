"""Bare numba kernels of single-lane passages: where they are, whose turn it is, blind ends.

Args of more than one kernel:
    clearance: (height, width) [m] from the nearest wall.
    labels: (height, width).
    step: [m] between two cells.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, Mask
from swarm_common.process.numba_compat import njit
from swarm_nav.core.rank import TOP_DEPTH, Rank, may_hold_up, passed_on
from swarm_nav.perception.neighbor_table_kernels import Columns
from swarm_nav.planning.distance_kernels import Floats, Frame
from swarm_nav.reservation.tube_kernels import INTENT_SPACING, PRIORITY_LENGTH

CLIMB = 1.5  # [m] within which the wall on the other side of a passage is looked for
FORESIGHT = 2.0 * PRIORITY_LENGTH  # [m] of a neighbour's path that counts

Labels = NDArray[np.int16]


@njit(cache=True)
def half_width(clearance: FloatArray, step: float, out: FloatArray) -> None:
    """Compute half the distance between the walls on either side of each cell.

    The way across is that of the distance field's gradient, away from the nearest wall. Where the
    gradient vanishes, the narrowest of four directions counts.

    Args:
        out: (height, width) [m], written; inf where a wall is farther than `CLIMB` away.
    """
    height, width = clearance.shape
    for i in range(height):
        for j in range(width):
            out[i, j] = np.inf
            if clearance[i, j] <= 0.0:
                continue
            gy = clearance[min(i + 1, height - 1), j] - clearance[max(i - 1, 0), j]
            gx = clearance[i, min(j + 1, width - 1)] - clearance[i, max(j - 1, 0)]
            norm = math.hypot(gx, gy)
            if norm > 0.6 * step:
                across = free_length(clearance, step, i, j, gy / norm, gx / norm)
                out[i, j] = 0.5 * (clearance[i, j] + across)
                continue
            for dy, dx in ((0.0, 1.0), (1.0, 0.0), (0.7071, 0.7071), (0.7071, -0.7071)):
                across = free_length(clearance, step, i, j, dy, dx)
                across += free_length(clearance, step, i, j, -dy, -dx)
                out[i, j] = min(out[i, j], 0.5 * across)


@njit(cache=True)
def free_length(clearance: FloatArray, step: float, i: int, j: int, dy: float, dx: float) -> float:
    """Return the distance [m] from cell (i, j) to a wall in one direction; inf beyond `CLIMB`.

    It ends with the clearance of the last free cell, so that walls between cells count as they
    are, and all cells of a cross-section measure the same width.

    Args:
        i: Row of the cell.
        j: Column of the cell.
        dy: Direction, a unit vector with dx.
        dx: Direction.
    """
    last_r, last_c = i, j
    for k in range(1, int(2.0 * CLIMB / step)):
        r = round(i + 0.5 * k * dy)
        c = round(j + 0.5 * k * dx)
        if r < 0 or c < 0 or r >= clearance.shape[0] or c >= clearance.shape[1]:
            break
        if clearance[r, c] < 0.5 * step:
            return math.hypot(last_r - i, last_c - j) * step + clearance[last_r, last_c]
        last_r, last_c = r, c
    return np.inf


@njit(cache=True)
def flood(mask: Mask, values: NDArray[np.signedinteger[Any]], unknown: int, step: int) -> None:
    """Give each unknown cell of a mask the value of the nearest known one, by the way, plus steps.

    Breadth-first, with eight neighbours.

    Args:
        mask: (height, width) cells that can be passed.
        values: (height, width); changed.
        unknown: Their value where nothing is known.
        step: Growth of a value with each cell.
    """
    height, width = mask.shape
    queue = np.empty((height * width, 2), np.int64)
    first = last = 0
    for i in range(height):
        for j in range(width):
            if values[i, j] != unknown:
                queue[last, 0], queue[last, 1] = i, j
                last += 1
    while first < last:
        i, j = queue[first]
        first += 1
        for r in range(max(0, i - 1), min(height, i + 2)):
            for c in range(max(0, j - 1), min(width, j + 2)):
                if mask[r, c] and values[r, c] == unknown:
                    values[r, c] = values[i, j] + step
                    queue[last, 0], queue[last, 1] = r, c
                    last += 1


@njit(cache=True)
def places(mask: Mask, gap: float, most: int) -> int:
    """Return how many cells of a mask can be taken, row by row, that keep a distance.

    Args:
        mask: (height, width).
        gap: [cells] that two of them keep.
        most: Number at which the count ends.
    """
    height, width = mask.shape
    taken = np.zeros(mask.shape, np.bool_)
    span = int(gap) + 1
    count = 0
    for i in range(height):
        for j in range(width):
            if not mask[i, j] or taken[i, j]:
                continue
            count += 1
            if count >= most:
                return count
            for r in range(i, min(height, i + span + 1)):
                for c in range(max(0, j - span), min(width, j + span + 1)):
                    if (r - i) * (r - i) + (c - j) * (c - j) < gap * gap:
                        taken[r, c] = True
    return count


@njit(cache=True)
def label_at(labels: Labels, frame: Frame, x: float, y: float) -> int:
    """Return the label of the cell that holds a point, 0 outside of the map.

    Args:
        x: [m] in map.
        y: [m] in map.
    """
    i = int((y - frame.origin_y) / frame.step)
    j = int((x - frame.origin_x) / frame.step)
    if i < 0 or j < 0 or i >= labels.shape[0] or j >= labels.shape[1]:
        return 0
    return int(labels[i, j])


@njit(cache=True)
def ends_within(
    labels: Labels, frame: Frame, points: Floats, size: int, wanted: int
) -> tuple[bool, float, float]:
    """Return the direction in which a path crosses a passage the first time.

    Args:
        points: (n, 2) [m] in map.
        size: Number of the points that count.
        wanted: Label of the passage.

    Returns:
        Whether any point is in the passage, and dx, dy [m] from the first such point to the last.
    """
    first = -1
    last = -1
    for k in range(size):
        if label_at(labels, frame, points[k, 0], points[k, 1]) == wanted:
            if first < 0:
                first = k
            last = k
        elif first >= 0:
            break
    if first < 0:
        return False, 0.0, 0.0
    dx = float(points[last, 0]) - float(points[first, 0])
    dy = float(points[last, 1]) - float(points[first, 1])
    return True, dx, dy


@njit(cache=True)
def entry_of(labels: Labels, frame: Frame, way: Floats, wanted: int) -> int:
    """Return the index of the point at which a path enters a passage, 0 if it does not.

    Args:
        labels: (height, width) of passages.
        way: (n, 2) [m] in map; one that starts in a passage does not enter any.
        wanted: Points after the first that are looked at.
    """
    if wanted <= 0 or label_at(labels, frame, way[0, 0], way[0, 1]) > 0:
        return 0
    for k in range(1, min(wanted + 1, way.shape[0])):
        if label_at(labels, frame, way[k, 0], way[k, 1]) > 0:
            return k
    return 0


@njit(cache=True)
def barrier(
    labels: Labels,
    frame: Frame,
    way: Floats,
    wanted: int,
    own: tuple[int, int, int],
    base: int,
    columns: tuple[NDArray[np.generic], ...],
) -> tuple[int, int, int]:
    """Return how far a path may be claimed before a passage, for whom the robot waits, and a rank.

    A robot waits before a passage while a robot that ranks above it is in there, or comes through
    it within `FORESIGHT`, in the opposite direction: d . (h + i) < 0, with d the way through of
    this robot, h of what the other one holds, and i of what it intends. One that follows a higher
    robot through inherits its rank.

    Args:
        labels: (height, width) of passages.
        way: (n, 2) [m] in map, from the end of the held tube.
        wanted: Points of it that are wanted now.
        own: `Rank` of this robot as a plain tuple.
        base: Its priority without what it inherits here.
        columns: `Columns` of the neighbours as a plain tuple.

    Returns:
        Number of points that may be claimed, row of the robot that is waited for or -1, and the
        priority that is inherited from the highest robot that is followed, 0 for none.
    """
    entry = entry_of(labels, frame, way, wanted)
    if entry == 0:
        return wanted, -1, 0
    last = way.shape[0] - 1
    mine = label_at(labels, frame, way[entry, 0], way[entry, 1])
    _, dx, dy = ends_within(labels, frame, way[entry:], last + 1 - entry, mine)
    leads_out = label_at(labels, frame, way[last, 0], way[last, 1]) != mine
    others, rank = Columns(*columns), Rank(*own)
    free, ahead, inherited = wanted, -1, np.int64(0)
    for j in range(others.ids.shape[0]):
        is_above = may_hold_up(others.priorities[j], others.ids[j], others.gone[j], rank)
        may_lead = leads_out and others.priorities[j] > base and not others.gone[j]
        if not is_above and not may_lead:
            continue
        size = np.int64(others.held_size[j])
        is_inside, hx, hy = ends_within(labels, frame, others.held[j], size, mine)
        intent = min(np.int64(others.intent_size[j]), int(FORESIGHT / INTENT_SPACING))
        comes, ix, iy = ends_within(labels, frame, others.intent[j], intent, mine)
        along = (hx + ix) * dx + (hy + iy) * dy
        if may_lead and is_inside and along > 0.0 and others.priorities[j] & TOP_DEPTH > 0:
            inherited = max(inherited, passed_on(others.priorities[j]))
        if is_above and (is_inside or comes) and along < 0.0 and ahead < 0:
            free, ahead = entry - 1, j
    return free, ahead, inherited


@njit(cache=True)
def root_of(parents: NDArray[np.int64], cell: int) -> int:
    """Return the cell that stands for the set of a cell (union-find; halves the way to it).

    Args:
        parents: (n,) a cell of the same set nearer to the root, for the root itself; changed.
        cell: A cell of the set.
    """
    while parents[cell] != cell:
        parents[cell] = parents[parents[cell]]
        cell = parents[cell]
    return cell


@njit(cache=True)
def peaks(values: NDArray[np.int32], order: NDArray[np.int64], width: int, prominence: int) -> int:
    """Count the peaks that rise by `prominence` or more above the saddle to a higher one, or 0.

    Cells flow together from the highest to the lowest (union-find): where two sets meet, the one
    with the lower peak ends, and counts if it is that high above the meeting point.

    Args:
        values: (h · width,) heights, row after row.
        order: Cells (k,) from the highest to the lowest.
        width: Cells of a row.
        prominence: In the unit of the values.
    """
    parents = np.full(values.shape[0], -1, np.int64)
    count = 0
    for k in range(order.shape[0]):
        cell = order[k]
        parents[cell] = cell
        for down in (-width, 0, width):
            for aside in (-1, 0, 1):
                beside = cell + down + aside
                if not 0 <= beside < values.shape[0] or abs(beside % width - cell % width) > 1:
                    continue
                if parents[beside] < 0:
                    continue
                one, two = root_of(parents, cell), root_of(parents, beside)
                if one == two:
                    continue
                if values[one] > values[two]:
                    one, two = two, one
                if values[one] - values[cell] >= prominence:
                    count += 1
                parents[one] = two
    for k in range(order.shape[0]):
        cell = order[k]
        if parents[cell] == cell and values[cell] >= prominence:
            count += 1
    return count
