"""Bare numba kernels on the table of neighbours: beacons as rows of 4-byte words, by id.

A row is the beacon's record word by word, `words` seen as uint32 and `floats` as float32, so that
kernels read members without numpy's cost per field. Rows ascend by id.
Args of more than one kernel:
    ages: (n,) [ticks] of the beacons.
    air: (k, words) beacons as they were heard.
    count: Rows in use.
    floats: (rows, words) the same memory as float32.
    gone: (n,) whether each robot is silent.
    ids: (n,).
    links: (rows, 4), see `merge`.
    notes: (rows, 2), see `merge`.
    own_id: Id of this robot.
    priorities: (n,) as published.
    tick: Now.
    words: (rows, words) the table, changed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import (
    FLAG_ACTIVE,
    FLAG_DEAF,
    FLAG_LEFT,
    FLAG_SPLIT,
    HEARD_ENTRIES,
    word_of,
)
from swarm_common.model.records import FloatArray, Mask
from swarm_common.process.numba_compat import njit
from swarm_nav.core.rank import DEPTH_BITS, ID_MASK, TOP_DEPTH, outranks

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
STATION = word_of("station")
STATION_TICK = word_of("station_tick")
HELD = word_of("held")
WANTED = word_of("wanted")
FOOTPRINT = word_of("footprint")
HEARD = word_of("heard")
LAST_HEARD = HEARD + HEARD_ENTRIES - 1
AT_ONCE = HELD + 2  # words that are copied of every beacon: all up to the first point
SOURCE, PLACE, HEARD_OURS, SEEN_THROUGH = range(4)  # columns of the links
OWN, NOW, BEFORE = range(3)  # where points are: in the table, or heard in this merge or the last
UNHEARD = -(1 << 40)  # tick that no request is as old as
RAY_SPACING = 0.05  # [m] of rays at a place that they must not miss a LiDAR's housing in
RAY_NOISE = 0.03  # [m]
PASSED_TICKS = 3  # age up to which a beacon tells where a robot is now
PASSED_GAP = 0.08  # [m] that the centres of no two robots can have: their bodies would be one
LONGEST_TRIP = 60  # ticks; an older acknowledgement means a robot that does not answer
ROTATING = 8  # entries that are shared out in turn when there are more robots than entries

Words = NDArray[np.uint32]
Floats = NDArray[np.float32]
Ints = NDArray[np.int64]
Plain = tuple[Words, Ints, Mask, Ints, Ints]  # ids, ages, gone, priorities, acks


class Columns(NamedTuple):
    """Columns for kernels that look at all neighbours: a row per robot, ascending by id."""

    ids: Words
    acks: Ints  # tick of the newest of our beacons that each has acknowledged
    gone: Mask  # whether it is silent
    priorities: Ints
    radius: Floats  # [m] safety radius
    blocked_ticks: Words
    held: Floats  # (rows, n, 2) [m] points of the held tube in map
    held_size: Words
    wanted: Floats  # (rows, n, 2) [m] points that are requested
    wanted_size: Words
    intent: Floats  # (rows, n, 2) [m] points of the path ahead
    intent_size: Words


@njit(cache=True)
def merge(
    words: Words,
    floats: Floats,
    notes: FloatArray,
    links: Ints,
    count: int,
    heard: tuple[Words, Ints],
    before: Words,
    own: tuple[float, float, int, int],
) -> int:
    """Store beacons that are newer than the known ones; return the new number of rows.

    Of a beacon, the head and the first point are copied at once. The other points are copied when
    they are needed (`fetch`), or before they are lost because the robot is not heard again. A robot
    that was removed from the world is forgotten.

    Args:
        notes: (rows, 2): distance [m] of the pose to (x, y) when heard, and the tick since which
            the robot is heard.
        links: (rows, 4): where the points are, at which row there, the acknowledgement of our
            beacon, and which of the points the last scan saw through, as bits.
        heard: (beacons (k, words), rows of them that were heard).
        before: (j, words) beacons of the last merge.
        own: (x [m], y [m], id, lost_ticks) of this robot.
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
            links[row, SEEN_THROUGH] = links[row, HEARD_OURS] = 0
        elif batch[k, TICK] < words[row, TICK]:
            continue  # overtaken by a newer one
        elif np.int64(batch[k, TICK]) - np.int64(words[row, TICK]) > lost_ticks:
            notes[row, 1] = batch[k, TICK]
        for word in range(AT_ONCE):
            words[row, word] = batch[k, word]
        links[row, SOURCE] = NOW
        links[row, PLACE] = k
        links[row, HEARD_OURS] = heard_entry(batch, k, own_id, links[row, HEARD_OURS], lost_ticks)
        notes[row, 0] = math.hypot(floats[row, POSE] - x, floats[row, POSE + 1] - y)
        row += 1
    for row in range(count):
        if links[row, SOURCE] == BEFORE:
            copy_points(words, links, row, before)
    return count


@njit(cache=True)
def move_row(words: Words, notes: FloatArray, links: Ints, row: int, to: int) -> None:
    """Copy a row of the table, see `merge`, to another one.

    Args:
        words: (rows, words).
        notes: (rows, 2).
        links: (rows, 4).
        row: Index of the row that is copied.
        to: Index of the row that is written.
    """
    words[to] = words[row]
    notes[to] = notes[row]
    links[to] = links[row]


@njit(cache=True)
def heard_entry(batch: Words, k: int, own_id: int, known: int, lost_ticks: int) -> int:
    """Return the newest acknowledgement of a beacon of ours: id and tick in one word, 0 without.

    A robot that hears more robots than it can acknowledge at a time names them in turn: what it
    said last counts until then, but no longer than it remembers a robot that it hears no more. A
    robot that names fewer than it could and not us does not hear us.

    Args:
        batch: (k, words) beacons.
        k: Row.
        known: Acknowledgement in the sender's beacon before this one, 0 for nothing.
        lost_ticks: For which the sender remembers us.
    """
    for word in range(HEARD, LAST_HEARD + 1):
        if batch[k, word] >> np.uint32(16) == own_id:
            return np.int64(batch[k, word])
    age = (np.int64(batch[k, TICK]) - known) & 0xFFFF
    return known if batch[k, LAST_HEARD] != 0 and age <= lost_ticks else 0


@njit(cache=True)
def copy_points(words: Words, links: Ints, row: int, air: Words) -> None:
    """Copy what `merge` left of a beacon.

    Args:
        words: (rows, words) the table.
        row: Row of the beacon.
    """
    k = links[row, PLACE]
    for word in range(AT_ONCE, words.shape[1]):
        words[row, word] = air[k, word]
    links[row, SOURCE] = OWN


@njit(cache=True)
def fetch(words: Words, links: Ints, count: int, air: Words) -> None:
    """Complete the beacons in the table.

    Args:
        words: (rows, words).
    """
    for row in range(count):
        if links[row, SOURCE] != OWN:
            copy_points(words, links, row, air)


@njit(cache=True)
def receive_batch(
    table: tuple[Words, Floats, FloatArray, Ints],
    count: int,
    heard: tuple[Words, Ints],
    before: Words,
    own: tuple[float, float, int, int],
    columns: Plain,
    tick: int,
    limits: tuple[int, float, tuple[int, float, int]],
    out: Words,
    left: tuple[Words, Ints],
) -> tuple[int, int, bool, bool, bool, bool, float]:
    """Compute `merge` and `refresh` in one call, as almost every tick needs both.

    Args:
        table: (words, floats, notes, links) as of `merge`.
        count: See `merge`.
        heard: See `merge`.
        before: See `merge`.
        own: See `merge`.
        columns: See `refresh`.
        tick: See `refresh`.
        limits: See `refresh`.
        out: See `refresh`.
        left: See `refresh`.

    Returns:
        The values that `refresh` returns.
    """
    words, floats, notes, links = table
    count = merge(words, floats, notes, links, count, heard, before, own)
    return refresh(words, notes, links, count, heard[0], own[2], columns, tick, limits, out, left)


@njit(cache=True)
def mean_trip(acks: Ints, tick: int) -> float:
    """Return the mean age [ticks] of the acknowledgements; 0 if none counts.

    Args:
        acks: (n,) tick of the newest own beacon that each neighbour has acknowledged. One of now
            is none that was needed.
    """
    total = 0
    count = 0
    for row in range(acks.shape[0]):
        age = tick - acks[row]
        if 0 < age <= LONGEST_TRIP:
            total += age
            count += 1
    return total / count if count else 0.0


@njit(cache=True)
def refresh(
    words: Words,
    notes: FloatArray,
    links: Ints,
    count: int,
    air: Words,
    own_id: int,
    columns: Plain,
    tick: int,
    limits: tuple[int, float, tuple[int, float, int]],
    out: Words,
    left: tuple[Words, Ints],
) -> tuple[int, int, bool, bool, bool, bool, float]:
    """Remove the rows of robots that may have left, and compute the columns of the others.

    A robot that has been silent for more than lost_ticks may have left if it was heard beyond the
    edge, and is gone otherwise.

    Args:
        columns: (ids, ages, gone, priorities, acks), a row per robot; written.
        limits: (lost_ticks, edge [m], those of `deaf_neighbor`).
        out: (entries,) acknowledgements, written by `acknowledge`.
        left: (words, (1,) number of rows): rows that were taken out are added, except for those
            of robots of which no place is left.

    Returns:
        Number of rows, id as of `deaf_neighbor`, whether any robot says that we block it, whether
        any is silent, whether any is silent or inactive, whether any that is heard says that the
        radio is split, and the mean round trip [ticks].
    """
    ids, ages, gone, priorities, acks = columns
    lost_ticks, edge, unheard = limits
    kept = 0
    is_pushed = False
    has_silent = False
    is_any_inactive = False
    hears_split = False
    for row in range(count):
        age = tick - np.int64(words[row, TICK])
        if age > lost_ticks:
            if words[row, HELD_SIZE] + words[row, WANTED_SIZE] == 0:
                continue
            if notes[row, 0] > edge:
                if links[row, SOURCE] != OWN:
                    copy_points(words, links, row, air)
                left[0][left[1][0]] = words[row]
                left[1][0] += 1
                continue
        has_silent |= age > lost_ticks
        if kept < row:
            move_row(words, notes, links, row, kept)
        ids[kept] = words[kept, ID]
        ages[kept] = age
        gone[kept] = age > lost_ticks
        priorities[kept] = (np.int64(words[kept, PRIORITY]) << 32) | np.int64(
            words[kept, PRIORITY + 1]
        )
        is_pushed |= words[kept, BLOCKED_BY] == own_id
        is_any_inactive |= words[kept, FLAGS] & np.uint32(FLAG_ACTIVE) == 0
        hears_split |= not gone[kept] and words[kept, FLAGS] & np.uint32(FLAG_SPLIT) > 0
        is_deaf = words[kept, FLAGS] & np.uint32(FLAG_DEAF)
        entry = links[kept, HEARD_OURS]
        if gone[kept] or is_deaf:
            acks[kept] = tick
        else:
            acks[kept] = tick - ((tick - entry) & 0xFFFF) if entry else UNHEARD
        kept += 1
    acknowledge(words, notes, kept, tick, out)
    deaf = deaf_neighbor(ids[:kept], acks, notes, tick, unheard)
    trip = mean_trip(acks[:kept], tick)
    is_any_immovable = has_silent or is_any_inactive
    return kept, deaf, is_pushed, has_silent, is_any_immovable, hears_split, trip


@njit(cache=True)
def acknowledge(words: Words, notes: FloatArray, count: int, tick: int, out: Words) -> None:
    """Write which beacons were heard last: those of the nearest robots, of further ones in turn.

    Args:
        words: (rows, words) the table.
        tick: Now; it decides whose turn it is.
        out: (entries,) id and tick in one word, 0 for none; written.
    """
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
def deaf_neighbor(
    ids: Words, acks: Ints, notes: FloatArray, tick: int, limits: tuple[int, float, int]
) -> int:
    """Return the id of a robot that must hear us and does not, 0 if there is none.

    In a crowd a robot may have more neighbours than acknowledgements: a neighbour that is not among
    the nearest waits for its turn.

    Args:
        acks: (n,) tick of the newest of our beacons that each has acknowledged.
        limits: (patience [ticks] without an acknowledgement, reach [m] within which it is needed,
            entries of a beacon for acknowledgements).
    """
    patience, reach, entries = limits
    patience += max(0, ids.shape[0] - entries) // ROTATING
    for row in range(ids.shape[0]):
        need_not_hear = acks[row] == tick
        is_near = notes[row, 0] <= reach and tick - notes[row, 1] > patience
        if is_near and not need_not_hear and tick - acks[row] > patience:
            return np.int64(ids[row])
    return 0


@njit(cache=True)
def masks(
    table: tuple[Words, Floats],
    links: Ints,
    air: Words,
    ages: Ints,
    gone: Mask,
    count: int,
    own: tuple[float, float, float, float],
    travel: float,
    fresh_ticks: int,
    out: tuple[FloatArray, FloatArray, Mask],
) -> int:
    """Write the discs in which LiDAR hits belong to a robot; return their number.

    A robot that is heard masks the part of its held space that it can have reached; a silent one
    masks all that it held and requested. We keep out of that space anyhow, by the sum of both radii
    from its points, so we cannot touch anything within the robot's radius of them. For one
    that is heard our own margin is added, as hits and both poses may be off.

    Args:
        table: (words, floats) as of `merge`.
        own: (x, y, reach, margin) [m]: robots beyond the reach are left out.
        travel: Points of a tube that a robot passes in a tick, at most.
        fresh_ticks: Age up to which a beacon is fresh.
        out: (discs (k, 2) [m] in map, radii (k,) [m], (k,) whether the beacon is fresh); written.
    """
    words, floats = table
    x, y, reach, margin = own
    discs, radii, fresh = out
    far = air.view(np.float32)
    n = 0
    for row in range(count):
        if math.hypot(floats[row, POSE] - x, floats[row, POSE + 1] - y) > reach:
            continue
        beacon = floats[row] if links[row, SOURCE] == OWN else far[links[row, PLACE]]
        held = np.int64(words[row, HELD_SIZE])
        wanted = np.int64(words[row, WANTED_SIZE])
        if not gone[row]:
            held, wanted = min(held, 3 + np.int64(travel * ages[row])), 0
        for k in range(held + wanted):
            at = HELD + 2 * k if k < held else WANTED + 2 * (k - held)
            discs[n, 0] = beacon[at]
            discs[n, 1] = beacon[at + 1]
            radii[n] = floats[row, RADIUS] + (0.0 if gone[row] else margin)
            fresh[n] = ages[row] <= fresh_ticks
            n += 1
    return n


@njit(cache=True)
def is_through(
    ranges: Floats,
    beam: tuple[float, float, float],
    pose: tuple[float, float, float],
    disc: tuple[float, float, float],
    reach: float,
) -> bool:
    """Return whether all rays of a scan that meet a disc went on beyond it.

    Of a disc at distance d and bearing b, the ray at bearing b + o meets the far side at
    d cos(o) + sqrt(r^2 - (d sin(o))^2).

    Args:
        ranges: (n,) [m].
        beam: (angle_min [rad], angle_increment [rad], range_min [m]).
        pose: (x [m], y [m], yaw [rad]) of the LiDAR in map.
        disc: (x, y, radius) [m] in map.
        reach: [m] beyond which nothing is concluded.

    Returns:
        False also if too few rays meet the disc.
    """
    x, y, radius = disc
    dx = x - pose[0]
    dy = y - pose[1]
    d = math.hypot(dx, dy)
    if d > reach or d <= radius + beam[2] or d * beam[1] > RAY_SPACING:
        return False
    turn = np.int64(round(2.0 * math.pi / beam[1]))
    half = math.asin(radius / d)
    bearing = math.atan2(dy, dx) - pose[2] - beam[0]
    first, last = math.ceil((bearing - half) / beam[1]), math.floor((bearing + half) / beam[1])
    for k in range(first, last + 1):
        if k % turn >= ranges.shape[0]:
            return False  # outside the field of view
        off = k * beam[1] - bearing
        lateral = d * math.sin(off)
        end = d * math.cos(off) + math.sqrt(max(0.0, radius * radius - lateral * lateral))
        if not ranges[k % turn] > end + RAY_NOISE:
            return False
    return True


@njit(cache=True)
def clear_empty_places(
    words: Words,
    floats: Floats,
    links: Ints,
    ages: Ints,
    gone: Mask,
    scan: tuple[Floats, tuple[float, float, float], tuple[float, float, float]],
    limits: tuple[float, float, int],
    footprint: Words,
) -> None:
    """Clear the places of silent robots that two scans in a row have seen through.

    This concerns robots with our footprint: their LiDARs are at our height, so that ours sees them.

    Args:
        links: (rows, 4), see `merge`; changed.
        scan: (ranges, beam, pose) as of `is_through`.
        limits: (reach [m], radius [m] in which its LiDAR is seen, dead_ticks).
        footprint: (2 * FOOTPRINT_POINTS,) ours, as the words of a beacon.
    """
    ranges, beam, pose = scan
    reach, radius, dead_ticks = limits
    for row in range(ages.shape[0]):
        is_ours = gone[row] and ages[row] > dead_ticks
        for k in range(footprint.shape[0]):
            is_ours = is_ours and words[row, FOOTPRINT + k] == footprint[k]
        if not is_ours:
            continue
        before = links[row, SEEN_THROUGH]
        held = np.int64(words[row, HELD_SIZE])
        places = held + np.int64(words[row, WANTED_SIZE])
        kept, now = 0, 0
        for k in range(places):
            at = HELD + 2 * k if k < held else WANTED + 2 * (k - held)
            disc = (floats[row, at], floats[row, at + 1], radius)
            through = is_through(ranges, beam, pose, disc, reach)
            if through and (before >> k) & 1:
                continue
            words[row, HELD + 2 * kept] = words[row, at]
            words[row, HELD + 2 * kept + 1] = words[row, at + 1]
            now |= np.int64(through) << kept
            kept += 1
        words[row, HELD_SIZE] = kept
        words[row, WANTED_SIZE] = 0
        links[row, SEEN_THROUGH] = now


@njit(cache=True)
def passed(
    words: Words,
    floats: Floats,
    links: Ints,
    ages: Ints,
    gone: Mask,
    own: tuple[float, float],
    dead_ticks: int,
) -> None:
    """Remove the places of silent robots on which another robot is now.

    Args:
        links: (rows, 4), see `merge`; changed.
        own: (x, y) [m] of this robot in map.
        dead_ticks: Silence after which a robot has stopped.
    """
    for row in range(ages.shape[0]):
        if not gone[row] or ages[row] <= dead_ticks:
            continue
        held = np.int64(words[row, HELD_SIZE])
        places = held + np.int64(words[row, WANTED_SIZE])
        kept, seen = 0, 0
        for k in range(places):
            at = HELD + 2 * k if k < held else WANTED + 2 * (k - held)
            x, y = floats[row, at], floats[row, at + 1]
            gap = math.hypot(own[0] - x, own[1] - y)
            for other in range(ages.shape[0]):
                if ages[other] <= PASSED_TICKS:
                    gap = min(gap, math.hypot(floats[other, POSE] - x, floats[other, POSE + 1] - y))
            if gap < PASSED_GAP:
                continue
            words[row, HELD + 2 * kept] = words[row, at]
            words[row, HELD + 2 * kept + 1] = words[row, at + 1]
            seen |= ((links[row, SEEN_THROUGH] >> k) & 1) << kept
            kept += 1
        words[row, HELD_SIZE] = kept
        words[row, WANTED_SIZE] = 0
        links[row, SEEN_THROUGH] = seen


@njit(cache=True)
def bodies(
    floats: Floats,
    ages: Ints,
    limits: tuple[np.float32, float, int],
    robots: FloatArray,
    reach: FloatArray,
) -> None:
    """Write where the robots were and how far they may be from there: r + m + v min(age, most).

    Args:
        floats: (rows, words) the table.
        limits: (margin m [m] in single precision, travel v [m] per tick of age, most ticks).
        robots: (rows, 2) [m] in map, written.
        reach: (rows,) [m], written.
    """
    margin, travel, most = limits
    for row in range(ages.shape[0]):
        robots[row, 0] = floats[row, POSE]
        robots[row, 1] = floats[row, POSE + 1]
        near = np.float32(floats[row, RADIUS] + margin)
        reach[row] = near + travel * min(ages[row], most)


@njit(cache=True)
def row_of(ids: Words, robot: int) -> int:
    """Return the row of a robot, -1 if it is not known.

    Args:
        robot: Its id.
    """
    for row in range(ids.shape[0]):
        if ids[row] == robot:
            return row
    return -1


@njit(cache=True)
def highest_pusher(
    words: Words, gone: Mask, priorities: Ints, own: tuple[int, int], patience: int
) -> int:
    """Return the row of the highest robot that we block and that may push us, or -1.

    The pusher must rank above us, must not itself make way for us, and must have hops left in its
    chain of inheritance: so that no priority goes round in a circle for ever. If two robots
    inherited the same priority, the smaller id wins.

    Args:
        words: (rows, words) the table.
        own: (id, priority without what was inherited from pushers) of this robot.
        patience: [ticks] for which it must have been blocked.
    """
    own_id, own_priority = own
    best = -1
    for row in range(gone.shape[0]):
        if words[row, BLOCKED_BY] != own_id or words[row, BLOCKED_TICKS] < patience or gone[row]:
            continue
        if not outranks(priorities[row], np.int64(words[row, ID]), own_priority, own_id):
            continue
        if words[row, YIELDS_FOR] == own_id or priorities[row] & TOP_DEPTH == 0:
            continue
        if best < 0 or priorities[row] > priorities[best]:
            best = row
    return best


@njit(cache=True)
def _is_any(stations: NDArray[np.float64], x: float, y: float, same: float) -> bool:
    for k in range(stations.shape[0]):
        if math.hypot(x - stations[k, 0], y - stations[k, 1]) < same:
            return True
    return False


@njit(cache=True)
def queue(
    words: Words,
    floats: Floats,
    gone: Mask,
    priorities: Ints,
    stations: NDArray[np.float64],
    tick: int,
    own_id: int,
    same: float,
) -> tuple[int, int, int]:
    """Compare the requests for a station: those before (tick, own_id), and the highest.

    Requests are in lexicographic order of tick and id. Only priorities of their own count, told by
    the id in them: one that was inherited may come from the very robot that asks, and would go
    round for ever.

    Args:
        words: (n, words) uint32, the neighbours' beacons.
        floats: (n, words) the same memory as float32.
        gone: (n,) whether each is silent.
        stations: (k, 2) [m] in map, for any of which the requests count.
        tick: Tick of the robot's own request.
        same: [m] within which two stations are the same.

    Returns:
        The number of robots before it, the id of the first of them, and the highest priority of all
        that asked; 0 for none.
    """
    count = 0
    first = 0
    first_asked = np.int64(0)
    highest = 0
    for row in range(gone.shape[0]):
        asked = np.int64(words[row, STATION_TICK])
        if asked == 0 or gone[row]:
            continue
        if not _is_any(stations, floats[row, STATION], floats[row, STATION + 1], same):
            continue
        robot = np.int64(words[row, ID])
        owner = ID_MASK - ((priorities[row] >> DEPTH_BITS) & ID_MASK)
        if owner == robot % (ID_MASK + 1):
            highest = max(highest, priorities[row])
        if asked < tick or (asked == tick and robot < own_id):
            count += 1
            if count == 1 or asked < first_asked or (asked == first_asked and robot < first):
                first, first_asked = robot, asked
    return count, first, highest
