"""Bare numba kernels on robots that fell silent, and on where all robots were seen last.

A row is a beacon's words, as in `neighbor_table_kernels`; `facts` has what was learned since.
Args of more than one kernel:
    count: Number of these robots.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import FLAG_LEFT, NO_ROBOT, SIGHTED_ASKS, SIGHTINGS, word_of
from swarm_common.process.numba_compat import njit
from swarm_nav.perception.neighbor_table_kernels import (
    FLAGS,
    HELD,
    HELD_SIZE,
    ID,
    POSE,
    STATION_TICK,
    TICK,
    WANTED,
    WANTED_SIZE,
)

SIGHTED_ID, SIGHTED_TICK, SIGHTED_AT = map(word_of, ("sighted_id", "sighted_tick", "sighted_at"))
SINCE, FATE, PARTED = range(3)  # columns of the facts
NEVER = -(1 << 40)  # a tick before all others
UNKNOWN, HEARD_AGAIN, LEFT, FELL_SILENT, SILENT, MOVED = range(6)  # fates
DECIDE_TICKS = 40  # within hearing of a place after which its silence counts as a death
PARTED_TICKS = 600  # the same for one that did not stay there: then it counts as left after all
ELSEWHERE = 0.2  # [m] from all that a robot claimed, at which it claims something else
NOWHERE = np.float32(1e6)  # [m] x and y of a robot that was taken out of the world
OWN_SHIFT = 13  # robots that tell the same sightings begin with different ones


Words = NDArray[np.uint32]


class Absentees(NamedTuple):
    """The robots that fell silent, one a row; there may be more rows than robots."""

    words: Words  # (m, words) last beacons
    floats: NDArray[np.float32]  # the same memory
    facts: NDArray[np.int64]  # (m, 3) what was learned since
    rows: NDArray[np.int64]  # row of each id, -1 for others


class Sightings(NamedTuple):
    """Last place of each robot, as far as this one knows it from anybody; a row per id."""

    ticks: NDArray[np.int64]  # of the beacon that said so, NEVER for none
    places: NDArray[np.float32]  # (ids, 2) [m] in map
    asks: NDArray[np.bool_]  # whether it had asked for a station


# for calls in every tick: numba's dispatcher takes longer for a `NamedTuple`
PlainSightings = tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.bool_]]
PlainAbsentees = tuple[Words, NDArray[np.float32], NDArray[np.int64], NDArray[np.int64]]


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
def add(
    absent: Absentees, count: int, words: Words, has_parted: NDArray[np.bool_], fate: int
) -> int:
    """Write beacons of robots that are not heard any more behind the others.

    Args:
        count: Number of robots that are absent until now.
        words: (n, words); robots that are absent already are left out.
        has_parted: (n,) whether each was driving out of range.
        fate: Fate that is recorded for all of them.

    Returns:
        Number of robots that are absent now.
    """
    for k in range(words.shape[0]):
        robot = words[k, ID]
        if absent.rows[robot] < 0:
            absent.rows[robot] = count
            absent.words[count] = words[k]
            absent.facts[count, SINCE], absent.facts[count, FATE] = NEVER, fate
            absent.facts[count, PARTED] = has_parted[k]
            count += 1
    return count


@njit(cache=True)
def hear(
    known: PlainSightings, absent: PlainAbsentees, batch: Words, rows: NDArray[np.int64]
) -> tuple[int, bool]:
    """Update the places of robots that are heard or sighted; find out which absent ones are back.

    Args:
        known: Fields of `Sightings`, updated with what is newer.
        absent: Fields of `Absentees`; their facts are updated.
        batch: (n, words) beacons.
        rows: (k,) rows of those that were heard.

    Returns:
        The number of rows that `known` has to have; if it has fewer, nothing is lost by a second
        call. Whether any absent robot was heard again.
    """
    ticks, places, asks = known
    words, _, facts, row_of = absent
    floats = batch.view(np.float32)
    most = 0
    is_back = False
    for k in rows:
        for place in range(-1, SIGHTINGS):
            robot, tick, at = batch[k, ID], batch[k, TICK], POSE
            has_asked = batch[k, STATION_TICK] > 0
            if place >= 0:
                robot, tick = batch[k, SIGHTED_ID + place], batch[k, SIGHTED_TICK + place]
                at = SIGHTED_AT + 2 * place
                has_asked = robot & np.uint32(SIGHTED_ASKS) != 0
                robot &= np.uint32(SIGHTED_ASKS - 1)
            most = max(most, np.int64(robot) + 1)
            is_known = robot != NO_ROBOT and robot < ticks.shape[0]
            if is_known and np.int64(tick) > ticks[robot]:
                ticks[robot], asks[robot] = tick, has_asked
                places[robot, 0], places[robot, 1] = floats[k, at], floats[k, at + 1]
                if place < 0 and batch[k, FLAGS] & np.uint32(FLAG_LEFT):
                    places[robot, :] = NOWHERE
        robot = batch[k, ID]
        if robot < row_of.shape[0] and row_of[robot] >= 0:
            m = row_of[robot]
            if batch[k, TICK] > words[m, TICK]:
                facts[m, FATE] = HEARD_AGAIN
                is_back = True
    return most, is_back


@njit(cache=True)
def write_sightings(known: PlainSightings, own_id: int, tick: int, out: Words) -> None:
    """Write the sightings that are due in a beacon: all of other robots, in turn.

    Args:
        known: Fields of `Sightings`.
        own_id: Id of this robot.
        tick: Tick of the beacon; it decides whose turn it is.
        out: (4 * SIGHTINGS,) words of the beacon from `sighted_id` on; written.
    """
    ticks, places, asks = known
    out[:] = 0
    count = 0
    for robot in range(ticks.shape[0]):
        if ticks[robot] != NEVER and robot != own_id:
            count += 1
    if not count:
        return
    floats = out.view(np.float32)
    k = -((tick * SIGHTINGS + own_id * OWN_SHIFT) % count)  # turn of the first robot
    for robot in range(ticks.shape[0]):
        if ticks[robot] == NEVER or robot == own_id:
            continue
        turn = k if k >= 0 else k + count
        k += 1
        if turn < SIGHTINGS:
            out[turn] = robot + SIGHTED_ASKS if asks[robot] else robot
            out[SIGHTINGS + turn] = ticks[robot]
            floats[2 * SIGHTINGS + 2 * turn] = places[robot, 0]
            floats[2 * SIGHTINGS + 2 * turn + 1] = places[robot, 1]


@njit(cache=True)
def judge(
    absent: Absentees, count: int, known: Sightings, own: Spot, edge: float, tick: int
) -> bool:
    """Decide what became of absent robots; return whether anything did.

    An absent robot is where anybody saw it last. If that is not where this robot believes it to be,
    it has moved, and nothing is known of what it claimed there but its place. Silent is one that
    this robot does not hear while it is near for long: dead, unless it went on and nobody saw it,
    which is likely if it was driving out of range.

    Args:
        edge: [m] within which a robot that lives is heard.
        tick: Now.
    """
    words, floats, facts, _ = absent
    is_any = False
    for m in range(count):
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
                is_any = True
                continue
        if nearest_and_farthest(words[m], floats[m], own.x, own.y)[1] > edge - 0.01:
            facts[m, SINCE] = NEVER
        elif facts[m, SINCE] == NEVER:
            facts[m, SINCE] = tick
        elif facts[m, FATE] == UNKNOWN and tick - facts[m, SINCE] >= DECIDE_TICKS:
            facts[m, FATE] = FELL_SILENT
            is_any = True
        elif facts[m, PARTED] and tick - facts[m, SINCE] >= PARTED_TICKS:
            facts[m, FATE] = LEFT
            is_any = True
    return is_any


@njit(cache=True)
def sort_out(
    absent: Absentees, count: int, silent: Words, left: NDArray[np.int64]
) -> tuple[int, int, int]:
    """Remove the robots whose fate is known.

    Args:
        silent: (count, words) written: beacons of those found silent where they were; they stay.
        left: (count,) written: ids of those that are not where they were thought to be.

    Returns:
        Number of robots that are absent still, and numbers of rows in `silent` and in `left`.
    """
    kept, silent_count, left_count = 0, 0, 0
    for m in range(count):
        robot, fate = absent.words[m, ID], absent.facts[m, FATE]
        if fate == FELL_SILENT:
            silent[silent_count] = absent.words[m]
            silent_count += 1
            fate = SILENT
        elif fate == LEFT or fate == MOVED:
            left[left_count] = robot
            left_count += 1
            fate = UNKNOWN if fate == MOVED else LEFT
        if fate != UNKNOWN and fate != SILENT:
            absent.rows[robot] = -1
            continue
        absent.facts[m, FATE] = fate
        if kept < m:
            absent.words[kept] = absent.words[m]
            absent.facts[kept] = absent.facts[m]
        absent.rows[robot] = kept
        kept += 1
    return kept, silent_count, left_count
