"""Bare numba kernels on robots that fell silent where they may have left the radio range.

A row is a beacon's words, as in `neighbor_table_kernels`; `facts` has what was learned since.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit
from swarm_nav.perception.neighbor_table_kernels import (
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


Words = NDArray[np.uint32]


class Absentees(NamedTuple):
    """The robots that fell silent, one a row."""

    words: Words  # (m, words) last beacons
    floats: NDArray[np.float32]  # the same memory
    facts: NDArray[np.int64]  # (m, 5) what was learned since
    places: NDArray[np.int64]  # row of each id, -1 for others


class Hearing(NamedTuple):
    """What the radio promises."""

    edge: float  # [m] within which a robot that lives is heard
    range: float  # [m] of the radio
    lost_ticks: int  # without a beacon after which a robot is silent


class Spot(NamedTuple):
    """A point in map, [m]."""

    x: float
    y: float


@njit(cache=True)
def nearest_and_farthest(
    words: Words, floats: NDArray[np.float32], x: float, y: float
) -> tuple[float, float]:
    """Return the smallest and the largest distance [m] of a point from what a beacon claims.

    Args:
        words: (words,) of the beacon.
        floats: The same memory.
        x: [m] in map.
        y: [m] in map.
    """
    near, far = 1e20, 0.0
    for first, size in ((HELD, words[HELD_SIZE]), (WANTED, words[WANTED_SIZE])):
        for k in range(np.int64(size)):
            gap = math.hypot(floats[first + 2 * k] - x, floats[first + 2 * k + 1] - y)
            near = min(near, gap)
            far = max(far, gap)
    return near, far


@njit(cache=True)
def listen(
    absent: Absentees,
    batch: Words,
    rows: NDArray[np.int64],
    own: Spot,
    hearing: Hearing,
    tick: int,
    is_witnessed: bool,
) -> int:
    """Take the beacons of a tick; return the number of absent robots whose fate changes.

    A robot that hears an absent robot while one of the two cannot be at the place that the absent
    one held is a witness that it has left: the witness is out of range of that place, or we are
    well in its range and hear nothing. An absent robot that no robot hears while we are near is
    silent: dead, unless it lives alone elsewhere.

    Args:
        absent: Robots that fell silent; their facts are updated.
        batch: (n, words) beacons.
        rows: Those of them that were heard.
        own: Where this robot is.
        hearing: What the radio promises.
        tick: Now.
        is_witnessed: Whether to use what the others hear, which costs more.
    """
    words, floats, facts, places = absent
    count = words.shape[0]
    sent = batch.view(np.float32)
    lost_ticks = hearing.lost_ticks
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
        if nearest_and_farthest(words[m], floats[m], own.x, own.y)[1] > hearing.edge - 0.01:
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
                if gap <= hearing.range + MOTION:
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
