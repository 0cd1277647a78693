"""Bare numba kernels on the table of neighbours: beacons as rows of 4-byte words, by id.

A row is the beacon's record word by word, `words` seen as uint32 and `floats` as float32, so that
kernels read members without numpy's cost per field. Rows ascend by id.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from swarm_common.beacon import word_of

ID = word_of("id")
TICK = word_of("tick")
POSE = word_of("pose")
PRIORITY = word_of("priority")
BLOCKED_TICKS = word_of("blocked_ticks")
BLOCKED_BY = word_of("blocked_by")
STATION = word_of("station")
STATION_TICK = word_of("station_tick")
HELD_SIZE = word_of("held_size")
WANTED_SIZE = word_of("wanted_size")


@njit(cache=True)
def merge(words, floats, distances, count, batch, x, y):
    """Store a batch of rows, with the distances of their poses to (x, y); return the new count."""
    row = 0
    for k in range(batch.shape[0]):
        robot = batch[k, ID]
        if row > 0 and words[row - 1, ID] >= robot:
            row = 0  # the batch is not in order of ids
        while row < count and words[row, ID] < robot:
            row += 1
        if row == count or words[row, ID] != robot:
            for j in range(count, row, -1):
                words[j] = words[j - 1]
                distances[j] = distances[j - 1]
            count += 1
        words[row] = batch[k]
        distances[row] = math.hypot(floats[row, POSE] - x, floats[row, POSE + 1] - y)
        row += 1
    return count


@njit(cache=True)
def refresh(words, distances, columns, count, tick, limits):
    """Drop the rows of those who left and fill the columns of the others; return their number.

    columns = (ids, ages, gone, priorities), one entry per row. limits = (lost_ticks, edge,
    dead_ticks, stopping_points): a robot silent for more than lost_ticks has left if it was heard
    beyond `edge` [m] and is gone otherwise; silent for more than dead_ticks it keeps only
    `stopping_points` of its held tube.
    """
    ids, ages, gone, priorities = columns
    lost_ticks, edge, dead_ticks, stopping_points = limits
    kept = 0
    for row in range(count):
        age = tick - np.int64(words[row, TICK])
        if age > lost_ticks and distances[row] > edge:
            continue
        if kept < row:
            words[kept] = words[row]
            distances[kept] = distances[row]
        if age > dead_ticks:
            words[kept, HELD_SIZE] = min(words[kept, HELD_SIZE], np.uint32(stopping_points))
            words[kept, WANTED_SIZE] = 0
        ids[kept] = words[kept, ID]
        ages[kept] = age
        gone[kept] = age > lost_ticks
        priorities[kept] = (np.int64(words[kept, PRIORITY]) << 32) | np.int64(
            words[kept, PRIORITY + 1]
        )
        kept += 1
    return kept


@njit(cache=True)
def row_of(ids, robot):
    """Return the row of a robot, -1 if it is not known."""
    for row in range(ids.shape[0]):
        if ids[row] == robot:
            return row
    return -1


@njit(cache=True)
def highest_pusher(words, gone, priorities, own_id, own_priority, yields_for, patience):
    """Return the row of the highest robot that has been blocked by us for `patience` ticks, or -1.

    It must rank above `own_priority`, or be the one that is made way for already; of equal
    priorities that of the smaller id counts.
    """
    best = -1
    for row in range(gone.shape[0]):
        if words[row, BLOCKED_BY] != own_id or words[row, BLOCKED_TICKS] < patience or gone[row]:
            continue
        if priorities[row] <= own_priority and words[row, ID] != yields_for:
            continue
        if best < 0 or priorities[row] > priorities[best]:
            best = row
    return best


@njit(cache=True)
def earlier_requests(words, floats, gone, station, tick, own_id, same):
    """Number of robots that asked before (tick, own_id) for a station within `same` [m] of ours."""
    count = 0
    for row in range(gone.shape[0]):
        asked = np.int64(words[row, STATION_TICK])
        if asked == 0 or gone[row] or asked > tick:
            continue
        if asked == tick and words[row, ID] >= own_id:
            continue
        dx = floats[row, STATION] - station[0]
        dy = floats[row, STATION + 1] - station[1]
        if math.hypot(dx, dy) < same:
            count += 1
    return count
