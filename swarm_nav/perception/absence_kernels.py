"""Bare numba kernels on robots that fell silent where they may have left the radio range.

A row is a beacon's words, as in `neighborhood_kernels`; `facts` has what was learned since, row by
row.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from swarm_nav.perception.neighborhood_kernels import (
    HEARD,
    HELD,
    HELD_SIZE,
    ID,
    POSE,
    TICK,
    WANTED,
    WANTED_SIZE,
)

SINCE, FIRST, LAST, FATE, PARTED = range(5)  # columns of the facts
NEVER = -(1 << 40)  # a tick before all others
UNKNOWN, HEARD_AGAIN, LEFT, SILENT = range(4)  # fates
DECIDE_TICKS = 40  # within hearing of a place after which its silence counts as a death
PARTED_TICKS = 600  # the same for one that drove out of range: then it counts as left after all
MOTION = 0.2  # [m] that a witness may have driven since it heard the robot


@njit(cache=True)
def nearest_and_farthest(words, floats, x, y):
    """Return the smallest and the largest distance [m] of (x, y) from the points of a beacon."""
    near, far = 1e20, 0.0
    for first, size in ((HELD, words[HELD_SIZE]), (WANTED, words[WANTED_SIZE])):
        for k in range(np.int64(size)):
            gap = math.hypot(floats[first + 2 * k] - x, floats[first + 2 * k + 1] - y)
            near = min(near, gap)
            far = max(far, gap)
    return near, far


@njit(cache=True)
def listen(words, floats, facts, places, count, heard, own, limits, tick, is_witnessed):
    """Take the beacons of a tick; return the number of rows whose state changes.

    places: row of each id, -1 for others. heard = (beacons as words, rows of them heard);
    own = (x, y) [m]; limits = (edge [m], range [m], lost_ticks).

    A robot that hears an absent robot while one of the two cannot be at the place that the absent
    one held is a witness that it has left: the witness is out of range of that place, or we are
    well in its range and hear nothing. An absent robot that no robot hears while we are near is
    silent: dead, unless it lives alone elsewhere.
    """
    batch, rows = heard
    sent = batch.view(np.float32)
    edge, reach, lost_ticks = limits
    found = 0
    for k in rows:
        robot = batch[k, ID]
        if robot >= places.shape[0] or places[robot] < 0:
            continue
        if batch[k, TICK] > words[places[robot], TICK]:
            facts[places[robot], FATE] = HEARD_AGAIN
            found += 1
    if not is_witnessed:
        return found
    for m in range(count):
        if nearest_and_farthest(words[m], floats[m], own[0], own[1])[1] > edge - 0.01:
            facts[m, SINCE] = NEVER
        elif facts[m, SINCE] == NEVER:
            facts[m, SINCE] = tick
    for k in rows:
        if tick - np.int64(batch[k, TICK]) > lost_ticks:
            continue
        for word in range(HEARD, batch.shape[1]):
            robot = batch[k, word] >> np.uint32(16)
            if robot >= places.shape[0] or places[robot] < 0:
                continue
            m = places[robot]
            age = (tick - np.int64(batch[k, word])) & 0xFFFF
            shown = tick - age
            if age > lost_ticks or shown <= facts[m, LAST]:
                continue
            is_near = facts[m, SINCE] != NEVER and shown > facts[m, SINCE]
            if not is_near:
                gap = nearest_and_farthest(words[m], floats[m], sent[k, POSE], sent[k, POSE + 1])[0]
                if gap <= reach + MOTION:
                    continue
            if shown - facts[m, LAST] > DECIDE_TICKS:
                facts[m, FIRST] = shown
            facts[m, LAST] = shown
            if shown - facts[m, FIRST] > lost_ticks and facts[m, FATE] != HEARD_AGAIN:
                facts[m, FATE] = LEFT
                found += 1
    for m in range(count):
        near_ticks = tick - max(facts[m, SINCE], facts[m, LAST])
        if facts[m, SINCE] == NEVER:
            continue
        if facts[m, FATE] == UNKNOWN and near_ticks >= DECIDE_TICKS:
            facts[m, FATE] = SILENT
            found += 1
        elif facts[m, FATE] == SILENT and facts[m, PARTED] and near_ticks >= PARTED_TICKS:
            facts[m, FATE] = LEFT
            found += 1
    return found
