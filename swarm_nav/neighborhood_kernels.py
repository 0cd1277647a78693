"""Bare numba kernels on the table of neighbours: beacons as rows of 4-byte words, by id.

A row is the beacon's record word by word, `words` seen as uint32 and `floats` as float32, so that
kernels read members without numpy's cost per field. Rows ascend by id.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from swarm_common.beacon import FLAG_DEAF, FLAG_LEFT, word_of
from swarm_nav.priority import TOP_DEPTH

STANDOFF_TICKS = 200  # that a robot of equal priority is blocked before it pushes
ID = word_of("id")
TICK = word_of("tick")
RADIUS = word_of("radius")
POSE = word_of("pose")
PRIORITY = word_of("priority")
BLOCKED_TICKS = word_of("blocked_ticks")
YIELDS_FOR = word_of("yields_for")
BLOCKED_BY = word_of("blocked_by")
HELD_SIZE = word_of("held_size")
WANTED_SIZE = word_of("wanted_size")
FLAGS = word_of("flags")
HELD = word_of("held")
HEARD = word_of("heard")
AT_ONCE = HELD + 2  # words that are copied of every beacon: all up to the first point
SOURCE, PLACE, HEARD_OURS = range(3)  # columns of the links
OWN, NOW, BEFORE = range(3)  # where points are: in the table, or heard in this merge or the last
UNHEARD = -(1 << 40)  # tick that no request is as old as
ROTATING = 8  # entries that are shared out in turn when there are more robots than entries


@njit(cache=True)
def merge(words, floats, notes, links, count, heard, before, own):
    """Store beacons that are newer than what is known; return the new count.

    Of a beacon its head and first point are copied, the other points only once they are wanted,
    by `fetch`, or before they are gone: of those not heard again. A robot that was taken out of
    the world is forgotten.

    notes = (n, 2): distance of the pose to (x, y) when heard, tick since which it is heard.
    links = (n, 3): where the points are, at which row there, and the acknowledgement of ours.
    heard = (beacons as words, rows of them that were heard); before = those of the last merge.
    own = (x, y, id, lost_ticks).
    """
    batch, rows = heard
    x, y, own_id, lost_ticks = own
    for row in range(count):
        if links[row, SOURCE] == NOW:
            links[row, SOURCE] = BEFORE
    row = 0
    for k in rows:
        robot = batch[k, ID]
        if row > 0 and words[row - 1, ID] >= robot:
            row = 0  # the batch is not in order of ids
        while row < count and words[row, ID] < robot:
            row += 1
        if batch[k, FLAGS] & np.uint32(FLAG_LEFT):
            if row < count and words[row, ID] == robot:
                count -= 1
                for j in range(row, count):
                    move_row(words, notes, links, j + 1, j)
            continue
        if row == count or words[row, ID] != robot:
            for j in range(count, row, -1):
                move_row(words, notes, links, j - 1, j)
            count += 1
            notes[row, 1] = batch[k, TICK]
        elif batch[k, TICK] < words[row, TICK]:
            continue  # overtaken by a newer one
        elif np.int64(batch[k, TICK]) - np.int64(words[row, TICK]) > lost_ticks:
            notes[row, 1] = batch[k, TICK]
        for word in range(AT_ONCE):
            words[row, word] = batch[k, word]
        links[row, SOURCE] = NOW
        links[row, PLACE] = k
        links[row, HEARD_OURS] = heard_entry(batch, k, own_id)
        notes[row, 0] = math.hypot(floats[row, POSE] - x, floats[row, POSE + 1] - y)
        row += 1
    for row in range(count):
        if links[row, SOURCE] == BEFORE:
            copy_points(words, links, row, before)
    return count


@njit(cache=True)
def move_row(words, notes, links, row, to):
    """Copy a row to another one."""
    words[to] = words[row]
    notes[to] = notes[row]
    links[to] = links[row]


@njit(cache=True)
def heard_entry(batch, k, own_id):
    """Return the acknowledgement of a beacon of ours in row k, 0 without."""
    for word in range(HEARD, batch.shape[1]):
        if batch[k, word] >> np.uint32(16) == own_id:
            return np.int64(batch[k, word])
    return 0


@njit(cache=True)
def copy_points(words, links, row, air):
    """Copy what `merge` left of a beacon."""
    k = links[row, PLACE]
    for word in range(AT_ONCE, words.shape[1]):
        words[row, word] = air[k, word]
    links[row, SOURCE] = OWN


@njit(cache=True)
def fetch(words, links, count, air):
    """Complete the beacons in the table."""
    for row in range(count):
        if links[row, SOURCE] != OWN:
            copy_points(words, links, row, air)


@njit(cache=True)
def take_in(table, count, heard, before, own, columns, tick, limits, out):
    """Do `merge` and `refresh` in one call, as they are done together in almost every tick.

    table = (words, floats, notes, links).
    """
    words, floats, notes, links = table
    count = merge(words, floats, notes, links, count, heard, before, own)
    return refresh(words, notes, links, count, own[2], columns, tick, limits, out)


@njit(cache=True)
def refresh(words, notes, links, count, own_id, columns, tick, limits, out):
    """Drop the rows of those who left and work out all that holds for the tick about the others.

    Returns (number of rows, id as of `deaf_neighbor`, whether anybody says to be blocked by us).
    columns = (ids, ages, gone, priorities, acks), one entry per row. `out` is filled by
    `acknowledge`. limits = (lost_ticks, edge, dead_ticks, stopping_points, those of
    `deaf_neighbor`): a robot silent for more than lost_ticks has left if it was heard beyond
    `edge` [m] and is gone otherwise; silent for more than dead_ticks it keeps only the first
    `stopping_points` of what it held and requested.
    """
    ids, ages, gone, priorities, acks = columns
    lost_ticks, edge, dead_ticks, stopping_points, unheard = limits
    kept = 0
    is_pushed = False
    for row in range(count):
        age = tick - np.int64(words[row, TICK])
        if age > lost_ticks and notes[row, 0] > edge:
            continue
        if kept < row:
            move_row(words, notes, links, row, kept)
        if age > dead_ticks:
            held = min(np.int64(words[kept, HELD_SIZE]), stopping_points)
            words[kept, HELD_SIZE] = held
            words[kept, WANTED_SIZE] = min(
                np.int64(words[kept, WANTED_SIZE]), stopping_points - held
            )
        ids[kept] = words[kept, ID]
        ages[kept] = age
        gone[kept] = age > lost_ticks
        priorities[kept] = (np.int64(words[kept, PRIORITY]) << 32) | np.int64(
            words[kept, PRIORITY + 1]
        )
        is_pushed |= words[kept, BLOCKED_BY] == own_id
        is_deaf = words[kept, FLAGS] & np.uint32(FLAG_DEAF)
        entry = links[kept, HEARD_OURS]
        if gone[kept] or is_deaf:
            acks[kept] = tick
        else:
            acks[kept] = tick - ((tick - entry) & 0xFFFF) if entry else UNHEARD
        kept += 1
    acknowledge(words, notes, kept, tick, out)
    return kept, deaf_neighbor(ids[:kept], acks, notes, tick, unheard), is_pushed


@njit(cache=True)
def acknowledge(words, notes, count, tick, out):
    """Write which beacons were heard last: those of the nearest robots, of further ones in turn."""
    room = out.shape[0]
    out[:] = 0
    if count <= room:
        for row in range(count):
            out[row] = (words[row, ID] << np.uint32(16)) | (words[row, TICK] & np.uint32(0xFFFF))
        return
    order = np.argsort(notes[:count, 0])
    for k in range(room):
        row = order[k]
        if k >= room - ROTATING:
            row = order[room - ROTATING + (tick * ROTATING + k) % (count - room + ROTATING)]
        out[k] = (words[row, ID] << np.uint32(16)) | (words[row, TICK] & np.uint32(0xFFFF))


@njit(cache=True)
def deaf_neighbor(ids, acks, notes, tick, limits):
    """Return the id of a robot that does not hear us, 0 if all do that matter.

    limits = (patience, near, far, entries): a robot within `near` [m] that has not acknowledged a
    beacon for `patience` ticks; or within `far`, if nobody there has. In a crowd each may have too
    many neighbours to acknowledge all at once, by `entries`: who is not among the nearest waits
    for its turn.
    """
    patience, near, far, entries = limits
    turn = max(0, ids.shape[0] - entries) // ROTATING
    silent = 0
    is_heard = False
    for row in range(ids.shape[0]):
        need_not_hear = acks[row] == tick
        if need_not_hear or notes[row, 0] > far or tick - notes[row, 1] <= patience + turn:
            continue
        if tick - acks[row] <= patience + turn:
            is_heard = True
        elif notes[row, 0] <= near:
            return np.int64(ids[row])
        else:
            silent = np.int64(ids[row])
    return 0 if is_heard else silent


@njit(cache=True)
def bodies(floats, ages, limits, robots, reach):
    """Write where the robots were, robots (n, 2), and how far they may be off, reach (n,).

    limits = (margin [m], travel [m] per tick of age, most ticks); the margin in single precision.
    """
    margin, travel, most = limits
    for row in range(ages.shape[0]):
        robots[row, 0] = floats[row, POSE]
        robots[row, 1] = floats[row, POSE + 1]
        near = np.float32(floats[row, RADIUS] + margin)
        reach[row] = near + travel * min(ages[row], most)


@njit(cache=True)
def row_of(ids, robot):
    """Return the row of a robot, -1 if it is not known."""
    for row in range(ids.shape[0]):
        if ids[row] == robot:
            return row
    return -1


@njit(cache=True)
def highest_pusher(words, gone, priorities, own, patience, least_depth):
    """Return the row of the highest robot that has been blocked by us for `patience` ticks, or -1.

    own = (id, priority without what was inherited from pushers). The pusher must rank above that,
    must not itself make way for us, and must be of at least `least_depth` in its chain of
    inheritance: so that no priority outlives its source by going round in a circle. Of equal
    priorities, which two can have inherited from one robot, that of the smaller id counts, once
    it is clear that waiting does not help.
    """
    own_id, own_priority = own
    best = -1
    for row in range(gone.shape[0]):
        if words[row, BLOCKED_BY] != own_id or words[row, BLOCKED_TICKS] < patience or gone[row]:
            continue
        is_above = priorities[row] > own_priority or (
            priorities[row] == own_priority
            and words[row, ID] < own_id
            and words[row, BLOCKED_TICKS] >= STANDOFF_TICKS
        )
        if not is_above or words[row, YIELDS_FOR] == own_id:
            continue
        if (priorities[row] & TOP_DEPTH) < least_depth:
            continue
        if best < 0 or priorities[row] > priorities[best]:
            best = row
    return best
