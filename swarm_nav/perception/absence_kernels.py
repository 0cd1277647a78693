"""Bare numba kernels on robots that fell silent, and on where all robots were seen last.

A row is a beacon's words, as in `neighbor_table_kernels`; `facts` has what was learned since.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import FLAG_LEFT, NO_ROBOT, SIGHTINGS, word_of
from swarm_common.process.numba_compat import njit
from swarm_nav.perception.neighbor_table_kernels import (
    FLAGS,
    HELD,
    HELD_SIZE,
    ID,
    POSE,
    TICK,
    WANTED,
    WANTED_SIZE,
)

SIGHTED_ID, SIGHTED_TICK, SIGHTED_AT = map(word_of, ("sighted_id", "sighted_tick", "sighted_at"))
SINCE, FATE, PARTED = range(3)  # columns of the facts
NEVER = -(1 << 40)  # a tick before all others
UNKNOWN, HEARD_AGAIN, LEFT, SILENT, MOVED = range(5)  # fates
DECIDE_TICKS = 40  # within hearing of a place after which its silence counts as a death
PARTED_TICKS = 600  # the same for one that did not stay there: then it counts as left after all
ELSEWHERE = 0.2  # [m] from all that a robot claimed, at which it claims something else
NOWHERE = np.float32(1e6)  # [m] x and y of a robot that was taken out of the world
OWN_SHIFT = 13  # robots that tell the same sightings begin with different ones


Words = NDArray[np.uint32]


class Absentees(NamedTuple):
    """The robots that fell silent, one a row."""

    words: Words  # (m, words) last beacons
    floats: NDArray[np.float32]  # the same memory
    facts: NDArray[np.int64]  # (m, 3) what was learned since
    places: NDArray[np.int64]  # row of each id, -1 for others


class Sightings(NamedTuple):
    """Where each robot was last, as far as this one knows from anybody; a row per id."""

    ticks: NDArray[np.int64]  # of the beacon that said so, NEVER for none
    places: NDArray[np.float32]  # (ids, 2) [m] in map


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
        floats: (words,) the same memory as float32.
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
def hear(
    ticks: NDArray[np.int64],
    places: NDArray[np.float32],
    absent: Words,
    facts: NDArray[np.int64],
    absent_places: NDArray[np.int64],
    batch: Words,
    rows: NDArray[np.int64],
) -> tuple[int, bool]:
    """Take where the robots are that are heard, and those that they tell of, and who is back.

    Args:
        ticks: See `Sightings`; updated with what is newer.
        places: See `Sightings`; updated with what is newer.
        absent: (m, words) last beacons of the robots that fell silent.
        facts: (m, 3) what was learned of them; updated.
        absent_places: Row of each id in `absent`, -1 for others.
        batch: (n, words) beacons.
        rows: (k,) rows of those that were heard.

    Returns:
        The number of rows that the sightings have to have; if they have fewer, nothing is lost by a
        second call. Whether any absent robot was heard again.
    """
    floats = batch.view(np.float32)
    most = 0
    is_back = False
    for k in rows:
        for place in range(-1, SIGHTINGS):
            robot, tick, at = batch[k, ID], batch[k, TICK], POSE
            if place >= 0:
                robot, tick = batch[k, SIGHTED_ID + place], batch[k, SIGHTED_TICK + place]
                at = SIGHTED_AT + 2 * place
            most = max(most, np.int64(robot) + 1)
            is_known = robot != NO_ROBOT and robot < ticks.shape[0]
            if is_known and np.int64(tick) > ticks[robot]:
                ticks[robot] = tick
                places[robot, 0], places[robot, 1] = floats[k, at], floats[k, at + 1]
                if place < 0 and batch[k, FLAGS] & np.uint32(FLAG_LEFT):
                    places[robot, :] = NOWHERE
        robot = batch[k, ID]
        if robot < absent_places.shape[0] and absent_places[robot] >= 0:
            m = absent_places[robot]
            if batch[k, TICK] > absent[m, TICK]:
                facts[m, FATE] = HEARD_AGAIN
                is_back = True
    return most, is_back


@njit(cache=True)
def tell(
    ticks: NDArray[np.int64], places: NDArray[np.float32], own_id: int, tick: int, out: Words
) -> None:
    """Write the sightings that are due in a beacon: all of other robots, in turn.

    Args:
        ticks: See `Sightings`.
        places: See `Sightings`.
        own_id: Of this robot.
        tick: Of the beacon; it decides whose turn it is.
        out: (4 * SIGHTINGS,) words of the beacon from `sighted_id` on; written.
    """
    out[:] = 0
    count = 0
    for robot in range(ticks.shape[0]):
        if ticks[robot] != NEVER and robot != own_id:
            count += 1
    if not count:
        return
    floats = out.view(np.float32)
    first = (tick * SIGHTINGS + own_id * OWN_SHIFT) % count
    turn = -1
    for robot in range(ticks.shape[0]):
        if ticks[robot] == NEVER or robot == own_id:
            continue
        turn += 1
        k = (turn - first) % count
        if k < SIGHTINGS:
            out[k], out[SIGHTINGS + k] = robot, ticks[robot]
            floats[2 * SIGHTINGS + 2 * k] = places[robot, 0]
            floats[2 * SIGHTINGS + 2 * k + 1] = places[robot, 1]


@njit(cache=True)
def judge(absent: Absentees, known: Sightings, own: Spot, edge: float, tick: int) -> int:
    """Decide what became of absent robots; return how many changed.

    An absent robot is where anybody saw it last. If that is not where this robot believes it to be,
    it has moved, and nothing is known of what it claimed there but its place. Silent is one that
    this robot does not hear while it is near for long: dead, unless it went on and nobody saw it,
    which is likely if it was driving out of range.

    Args:
        absent: Robots that fell silent; changed.
        known: Sightings of all robots.
        own: Where this robot is.
        edge: [m] within which a robot that lives is heard.
        tick: Now.
    """
    words, floats, facts, _ = absent
    found = 0
    for m in range(words.shape[0]):
        if facts[m, FATE] == HEARD_AGAIN:
            continue
        robot = words[m, ID]
        if robot < known.ticks.shape[0] and known.ticks[robot] > np.int64(words[m, TICK]):
            x, y = known.places[robot, 0], known.places[robot, 1]
            if nearest_and_farthest(words[m], floats[m], x, y)[0] > ELSEWHERE:
                words[m, TICK] = known.ticks[robot]
                words[m, HELD_SIZE], words[m, WANTED_SIZE] = 1, 0
                for at in (POSE, HELD):
                    floats[m, at], floats[m, at + 1] = x, y
                facts[m, SINCE], facts[m, PARTED], facts[m, FATE] = NEVER, 1, MOVED
                found += 1
                continue
        if nearest_and_farthest(words[m], floats[m], own.x, own.y)[1] > edge - 0.01:
            facts[m, SINCE] = NEVER
        elif facts[m, SINCE] == NEVER:
            facts[m, SINCE] = tick
        elif facts[m, FATE] == UNKNOWN and tick - facts[m, SINCE] >= DECIDE_TICKS:
            facts[m, FATE] = SILENT
            found += 1
        elif facts[m, PARTED] and tick - facts[m, SINCE] >= PARTED_TICKS:
            facts[m, FATE] = LEFT
            found += 1
    return found
