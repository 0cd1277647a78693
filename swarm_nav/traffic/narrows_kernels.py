"""Bare numba kernels of single-lane passages."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from swarm_nav.control.tube_kernels import INTENT_SPACING
from swarm_nav.core.order_kernels import may_hold_up

CLIMB = 1.5  # [m] within which the wall on the other side of a passage is looked for
FORESIGHT = 2.0  # [m] of a neighbour's path that counts


@njit(cache=True)
def half_width(clearance, step, out):
    """Half the distance between the walls on either side of each cell; inf where one is far away.

    The way across is that of the distance field's gradient, away from the nearest wall.
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
def free_length(clearance, step, i, j, dy, dx):
    """Distance [m] from cell (i, j) to a wall in direction (dy, dx); inf beyond `CLIMB`."""
    for k in range(1, int(2.0 * CLIMB / step)):
        r = round(i + 0.5 * k * dy)
        c = round(j + 0.5 * k * dx)
        if r < 0 or c < 0 or r >= clearance.shape[0] or c >= clearance.shape[1]:
            break
        if clearance[r, c] < 0.5 * step:
            return 0.5 * k * step
    return np.inf


@njit(cache=True)
def label(mask, labels):
    """Number the 8-connected components of mask from 1 in labels, which starts as zeros."""
    height, width = mask.shape
    stack = np.empty((height * width, 2), np.int64)
    count = 0
    for i in range(height):
        for j in range(width):
            if not mask[i, j] or labels[i, j] > 0:
                continue
            count += 1
            labels[i, j] = count
            stack[0, 0] = i
            stack[0, 1] = j
            size = 1
            while size > 0:
                size -= 1
                r = stack[size, 0]
                c = stack[size, 1]
                for y in range(max(0, r - 1), min(height, r + 2)):
                    for x in range(max(0, c - 1), min(width, c + 2)):
                        if mask[y, x] and labels[y, x] == 0:
                            labels[y, x] = count
                            stack[size, 0] = y
                            stack[size, 1] = x
                            size += 1


@njit(cache=True)
def spread(mask, labels):
    """Give each cell of `mask` without a label that of the nearest labelled cell, by the way."""
    height, width = mask.shape
    queue = np.empty((height * width, 2), np.int64)
    first = last = 0
    for i in range(height):
        for j in range(width):
            if labels[i, j] > 0:
                queue[last, 0], queue[last, 1] = i, j
                last += 1
    while first < last:
        i, j = queue[first]
        first += 1
        for r in range(max(0, i - 1), min(height, i + 2)):
            for c in range(max(0, j - 1), min(width, j + 2)):
                if mask[r, c] and labels[r, c] == 0:
                    labels[r, c] = labels[i, j]
                    queue[last, 0], queue[last, 1] = r, c
                    last += 1


@njit(cache=True)
def places(mask, gap, most):
    """Number of cells of `mask`, at least `gap` cells apart, taken row by row; at most `most`."""
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
def label_at(labels, frame, x, y):
    """Label of the cell that holds (x, y), 0 outside the map."""
    i = int((y - frame[1]) / frame[2])
    j = int((x - frame[0]) / frame[2])
    if i < 0 or j < 0 or i >= labels.shape[0] or j >= labels.shape[1]:
        return 0
    return int(labels[i, j])


@njit(cache=True)
def ends_within(labels, frame, points, size, wanted):
    """Return (whether any point has the label, dx, dy from the first such point to the last)."""
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
def leads_in(labels, frame, way, wanted):
    """Return whether the path enters a passage within `wanted` points, not starting in one."""
    if wanted <= 0 or label_at(labels, frame, way[0, 0], way[0, 1]) > 0:
        return False
    for k in range(1, min(wanted + 1, way.shape[0])):
        if label_at(labels, frame, way[k, 0], way[k, 1]) > 0:
            return True
    return False


@njit(cache=True)
def barrier(labels, frame, way, wanted, own, claims):
    """Return (number of points of `way` that may be claimed, row that is waited for or -1).

    `way` starts at the end of the held tube; `wanted` points of it are wanted now. own =
    (priority, id, yields for). claims = the neighbours' columns, see
    `Neighborhood.columns`.
    """
    if wanted <= 0 or label_at(labels, frame, way[0, 0], way[0, 1]) > 0:
        return wanted, -1
    entry = 0
    mine = 0
    for k in range(1, min(wanted + 1, way.shape[0])):
        mine = label_at(labels, frame, way[k, 0], way[k, 1])
        if mine > 0:
            entry = k
            break
    if mine == 0:
        return wanted, -1
    _, dx, dy = ends_within(labels, frame, way[entry:], way.shape[0] - entry, mine)
    ids, gone, priorities = claims[0], claims[2], claims[3]
    held, held_size, intent, intent_size = claims[6], claims[7], claims[10], claims[11]
    for j in range(ids.shape[0]):
        if not may_hold_up(priorities[j], ids[j], gone[j], own):
            continue
        is_inside, hx, hy = ends_within(labels, frame, held[j], np.int64(held_size[j]), mine)
        ahead = min(np.int64(intent_size[j]), int(FORESIGHT / INTENT_SPACING))
        comes, ix, iy = ends_within(labels, frame, intent[j], ahead, mine)
        if not is_inside and not comes:
            continue
        if (hx + ix) * dx + (hy + iy) * dy < 0.0:
            return entry - 1, j
    return wanted, -1
