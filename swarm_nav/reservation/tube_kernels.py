"""Bare numba kernels of the reservation protocol: how far may a held tube grow?

Args of more than one kernel:
    beacon: (words,) float32 of the neighbour.
    p: (x, y) [m] in map, the point.
    points: (n, 2) [m] in map, the path.
    position: (x, y) [m] of the robot, in map.
    reach: [m] sum of both radii.
    x: [m] of the place.
    y: [m] of the place.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import HELD_POINTS, word_of
from swarm_common.process.numba_compat import njit
from swarm_nav.core.rank import Rank, may_hold_up, outranks
from swarm_nav.perception.neighbor_table_kernels import (
    BLOCKED_TICKS,
    HELD,
    HELD_SIZE,
    OWN,
    PLACE,
    RADIUS,
    SOURCE,
    WANTED,
    WANTED_SIZE,
)

INTENT = word_of("intent")
INTENT_SIZE = word_of("intent_size")
REACHED, UNCONFIRMED, ROBOT, OBSTACLE, RIGHT_OF_WAY = range(5)
REASONABLE_REACH = 2.5  # [m] beyond which two claims cannot meet, radii excepted
PRIORITY_LENGTH = 0.8  # [m] of an entitled robot's path that lower ones keep free
INTENT_SPACING = 0.1  # [m] between the points of an intent
ROUNDING = 1e-6  # [m] by which two robots may compute one distance differently


class Claims(NamedTuple):
    """The neighbours' table with a row per robot, see `neighbor_table_kernels`."""

    ids: NDArray[np.uint32]
    acks: NDArray[np.int64]  # tick of the newest of our beacons that each has acknowledged
    gone: NDArray[np.bool_]  # whether it is silent
    priorities: NDArray[np.int64]
    words: NDArray[np.uint32]  # beacons, word by word
    links: NDArray[np.int64]  # where the points of each beacon are
    air: NDArray[np.uint32]  # beacons as they were heard


@njit(cache=True)
def gap_squared(points, size, x, y):
    """Squared distance [m²] of a place to some points; 1e20 without points.

    Args:
        points: (n, 2) [m].
        size: Number of rows that count.
    """
    best = 1e20
    for k in range(size):
        dx = points[k, 0] - x
        dy = points[k, 1] - y
        d = dx * dx + dy * dy
        if d < best:
            best = d
    return best


@njit(cache=True)
def claimed_gap(beacon, first, size, x, y):
    """Squared distance [m²] of a place to points in a beacon; 1e20 without points.

    Args:
        beacon: (words,) float32, a beacon's words.
        first: Word at which the points begin.
        size: Number of points.
        x: [m] of the place, in map.
        y: [m] of the place, in map.
    """
    best = 1e20
    for k in range(first, first + 2 * size, 2):
        dx = beacon[k] - x
        dy = beacon[k + 1] - y
        d = dx * dx + dy * dy
        if d < best:
            best = d
    return best


@njit(cache=True)
def last_point(size):
    """Word of a beacon at which the last held point is.

    Args:
        size: Number of held points.
    """
    return HELD + 2 * ((np.int64(size) - 1) % HELD_POINTS)


@njit(cache=True)
def intent_gap(beacon, head, p):
    """Squared distance [m²] of a place to the first `PRIORITY_LENGTH` of a robot's intent.

    Args:
        beacon: (words,) float32 with the points.
        head: (words,) uint32 with the size of the intent.
        p: (x, y) [m] in map.
    """
    ahead = min(np.int64(head[INTENT_SIZE]), int(PRIORITY_LENGTH / INTENT_SPACING))
    return claimed_gap(beacon, INTENT, ahead, p[0], p[1])


@njit(cache=True)
def intrudes(claim, first, size, p, previous, limit, rounding):
    """Whether the step to a point of a path comes too near to any claimed point.

    A step away from a point never does: a tube that is too near already, by an actuation error, may
    grow away. Each claimed point counts by itself: what is farther from the nearest one may be
    nearer to another.

    Args:
        claim: (words,) float32 in which the claimed points are.
        first: Word at which they begin.
        size: Their number.
        previous: (x, y) [m] of the point before it on the path.
        limit: [m] that it has to keep from claimed points.
        rounding: [m²] by which a squared distance must shrink to count as a step nearer.
    """
    for k in range(first, first + 2 * size, 2):
        here = (claim[k] - p[0]) ** 2 + (claim[k + 1] - p[1]) ** 2
        if here < limit * limit:
            before = (claim[k] - previous[0]) ** 2 + (claim[k + 1] - previous[1]) ** 2
            if here < before - rounding:
                return True
    return False


@njit(cache=True)
def grantable_prefix(beacon, size, end, held, held_size, reach, slack):
    """Return how many points of a neighbour's request precede the first one that our tube denies.

    All points that it might be granted count: it may make way by now (slack), and its tube may grow
    away if it is too near already.

    Args:
        size: Number of points that it requests.
        end: Word at which its tube's last point is, see `last_point`.
        held: (n, 2) [m] our tube as published.
        held_size: Number of its points that count.
        slack: [m] `traffic.yield_slack`.
    """
    claim = held.ravel()
    limit = reach - slack - ROUNDING
    before = beacon[end : end + 2]
    for k in range(size):
        at = WANTED + 2 * k
        here = beacon[at : at + 2]
        if intrudes(claim, 0, held_size, here, before, limit, 1e-5):
            return k
        before = here
    return size


@njit(cache=True)
def admissible(p, previous, beacon, held_size, reach, slack, wins, prefix):
    """Whether a point may join our tube as far as one living neighbour is concerned (rule G2).

    A robot that makes way may pass a neighbour `slack` nearer, so that it is not caught by
    millimetres.

    Args:
        previous: (x, y) [m] of the point before it on our path.
        held_size: Number of points that it holds.
        slack: [m] by which the point may be nearer.
        wins: Whether we rank higher.
        prefix: Points of its request that it may be granted, see `grantable_prefix`.
    """
    if intrudes(beacon, HELD, held_size, p, previous, reach - slack, 1e-6):
        return False
    return wins or claimed_gap(beacon, WANTED, prefix, p[0], p[1]) >= (reach - slack) ** 2


@njit(cache=True)
def acknowledged(requests, tick):
    """Return the last point that the beacon of a tick and all later ones have requested (rule G3).

    Args:
        requests: (k, 2) ticks and last points, in order of ticks.
        tick: Tick of the beacon that a neighbour has acknowledged.

    Returns:
        The index of the point, -1 if the request is older than those remembered.
    """
    for k in range(requests.shape[0] - 1, -1, -1):
        if requests[k, 0] <= tick:
            return requests[k, 1]
    return -1


@njit(cache=True)
def extend(points, span, own, own_held, own_held_size, requests, protocol, around, claims):
    """Let the tube grow along a path until the first refusal.

    Rules G1, G2, G3 and G5 of docs/architecture/safety.md, named where they are checked; the caller
    (`swarm_nav.traffic.arbiter.Arbiter.extend`) checks G4: that the robot has
    listened for long enough.

    Args:
        span: (stop, last, confirmed): indices of the tube's end, of the last point wanted now and
            of the last point that was requested in enough beacons.
        own: (radius [m], priority, id, yields_for).
        own_held: (m, 2) [m] our tube as published.
        own_held_size: Number of its points that count.
        requests: (k, 2) ticks and last points of the requests published since the last change.
        protocol: (push_ticks, yield_slack [m], distance [m] within which every robot that is heard
            has to know a request).
        around: (obstacles (k, 2) [m], clearance [m] that points keep from them).
        claims: `Claims` of the neighbours as a plain tuple.

    Returns:
        (new stop, reason, row of the neighbour in the way or -1); the reason is one of `REACHED`,
        `UNCONFIRMED`, `ROBOT`, `OBSTACLE`, `RIGHT_OF_WAY`.
    """
    stop, last, confirmed = span
    radius, priority, own_id, yields_for = own
    rank = Rank(priority, own_id, yields_for)
    push_ticks, yield_slack, hearing_reach = protocol
    slack = yield_slack if yields_for != 0 else 0.0
    obstacles, clearance = around
    ids, acks, gone, priorities, words, links, air = Claims(*claims)
    heads = words.view(np.float32)
    far = air.view(np.float32)
    origin = points[stop]
    prefix = np.full(ids.shape[0], -1)
    near = gone.copy()
    for j in range(ids.shape[0]):
        reach = radius + heads[j, RADIUS]
        gap = math.hypot(heads[j, HELD] - origin[0], heads[j, HELD + 1] - origin[1])
        near[j] = gap < REASONABLE_REACH + reach
        if gap < hearing_reach and not gone[j]:  # G3
            confirmed = min(confirmed, acknowledged(requests, acks[j]))
    for k in range(stop + 1, last + 1):
        p = points[k]
        before = points[k - 1]
        here = gap_squared(obstacles, obstacles.shape[0], p[0], p[1])
        if here < clearance * clearance and here <= gap_squared(
            obstacles, obstacles.shape[0], before[0], before[1]
        ):
            return k - 1, OBSTACLE, -1
        for j in range(ids.shape[0]):
            if not near[j]:
                continue
            reach = radius + heads[j, RADIUS]
            beacon = heads[j] if links[j, SOURCE] == OWN else far[links[j, PLACE]]
            held = np.int64(words[j, HELD_SIZE])
            if gone[j]:  # G2 of a silent robot, whatever its rank:
                # it may have stopped anywhere in its held or requested space
                wanted = np.int64(words[j, WANTED_SIZE])
                is_free = not intrudes(
                    beacon, HELD, held, p, before, reach - slack, 1e-6
                ) and not intrudes(beacon, WANTED, wanted, p, before, reach, 1e-6)
            else:
                # G2
                wins = outranks(priority, own_id, priorities[j], ids[j])
                if not wins and prefix[j] < 0:
                    prefix[j] = grantable_prefix(
                        beacon, np.int64(words[j, WANTED_SIZE]), last_point(words[j, HELD_SIZE]),
                        own_held, own_held_size, reach, yield_slack,
                    )  # fmt: skip
                is_free = admissible(p, before, beacon, held, reach, slack, wins, prefix[j])
            if not is_free:
                return k - 1, ROBOT, j
            if (  # G5
                words[j, BLOCKED_TICKS] >= push_ticks
                and may_hold_up(priorities[j], ids[j], gone[j], rank)
                and intent_gap(beacon, words[j], p) < reach * reach
                and not intent_gap(beacon, words[j], origin) < reach * reach  # there already
            ):
                return k - 1, RIGHT_OF_WAY, j
        if k > confirmed:  # G1, or G3: not requested, or not acknowledged
            return k - 1, UNCONFIRMED, -1
    return last, REACHED, -1


@njit(cache=True)
def first_overlap(points, near, stop, radius, slack, claims):
    """Return the index of the first held point ahead that is too near to a living robot's tube.

    Too near is nearer than both radii minus the slack, and nearer than the robot's present place:
    robots whose places overlap already may part.

    Args:
        near: Index of the robot on it.
        stop: Index of the last held point.
        radius: [m] of this robot.
        slack: [m] by which tubes may be nearer than both radii.
        claims: `Claims` of the neighbours as a plain tuple.

    Returns:
        The index; stop + 1 if no point is too near.
    """
    ids, _, gone, _, words, links, air = Claims(*claims)
    heads = words.view(np.float32)
    far = air.view(np.float32)
    best = stop + 1
    x, y = points[near, 0], points[near, 1]
    way = 0.0  # [m] to the farthest point
    for k in range(near + 1, best):
        way = max(way, math.hypot(points[k, 0] - x, points[k, 1] - y))
    for j in range(ids.shape[0]):
        if gone[j]:
            continue
        reach = radius + heads[j, RADIUS] - slack
        beacon = heads[j] if links[j, SOURCE] == OWN else far[links[j, PLACE]]
        size = np.int64(words[j, HELD_SIZE])
        before = claimed_gap(beacon, HELD, size, x, y)
        if before > (way + reach) ** 2:
            continue
        for k in range(near + 1, best):
            gap = claimed_gap(beacon, HELD, size, points[k, 0], points[k, 1])
            if gap < reach * reach and gap < before - 1e-6:
                best = k
                break
    return best


@njit(cache=True)
def nearest_ahead(points, first, gap, limit, x, y):
    """Return the index of the path point nearest to a place, from an index on.

    The path may pass the same place again: it is the first local minimum.

    Args:
        points: (n, 2) [m].
        first: Index where the search begins.
        gap: [m] from the place to that point.
        limit: Largest index.
    """
    k = first
    while k < limit:
        ahead = math.hypot(points[k + 1, 0] - x, points[k + 1, 1] - y)
        if ahead > gap:
            break
        gap = ahead
        k += 1
    return k


@njit(cache=True)
def nearest_on(points, first, last, x, y):
    """Return the place (x, y) on a polyline that is nearest to a place.

    Args:
        points: (n, 2) [m] in map.
        first: Index where the polyline begins.
        last: Index where it ends; with `first` it is one point.
    """
    best_x = points[first, 0]
    best_y = points[first, 1]
    best = (best_x - x) ** 2 + (best_y - y) ** 2
    for k in range(first, last):
        ax = points[k + 1, 0] - points[k, 0]
        ay = points[k + 1, 1] - points[k, 1]
        length = max(ax * ax + ay * ay, 1e-12)
        t = min(max(((x - points[k, 0]) * ax + (y - points[k, 1]) * ay) / length, 0.0), 1.0)
        near_x = points[k, 0] + t * ax
        near_y = points[k, 1] + t * ay
        gap = (near_x - x) ** 2 + (near_y - y) ** 2
        if gap < best:
            best = gap
            best_x = near_x
            best_y = near_y
    return best_x, best_y


@njit(cache=True)
def point_beyond(points, near, stop, position, way):
    """Return the first point of the held part that lies a way beyond the robot, or the stop.

    Args:
        near: Index of the point nearest to the robot.
        stop: Index of the last point held.
        way: [m] along the path.
    """
    if way <= 0.0:
        return near
    done = -math.hypot(points[near, 0] - position[0], points[near, 1] - position[1])
    k = near
    while k < stop and done < way:
        k += 1
        done += math.hypot(points[k, 0] - points[k - 1, 0], points[k, 1] - points[k - 1, 1])
    return k


@njit(cache=True)
def publish(points, position, span, tolerance, held, wanted, intent):
    """Fill the point blocks of a beacon, and the rest of each with zeros.

    Args:
        span: (tail, stop, end): the held part goes from `tail` to `stop`, the request from there to
            `end`, the intent from `stop` on with every second point.
        tolerance: [m] from the held part beyond which the robot's position is put before it.
        held: (k, 2) float32, written.
        wanted: (k, 2) float32, written.
        intent: (k, 2) float32, written.

    Returns:
        The sizes (held, wanted, intent).
    """
    tail, stop, end = span
    held[:] = 0.0
    wanted[:] = 0.0
    intent[:] = 0.0
    x, y = position
    near_x, near_y = nearest_on(points, tail, stop, x, y)
    first = 0
    if math.hypot(near_x - x, near_y - y) > tolerance:
        held[0, 0], held[0, 1] = x, y
        first = 1
    held_size = min(first + stop - tail + 1, held.shape[0])
    for k in range(first, held_size):
        held[k, 0] = points[tail + k - first, 0]
        held[k, 1] = points[tail + k - first, 1]
    wanted_size = min(end - stop, wanted.shape[0])
    for k in range(wanted_size):
        wanted[k, 0] = points[stop + 1 + k, 0]
        wanted[k, 1] = points[stop + 1 + k, 1]
    intent_size = min((points.shape[0] - stop + 1) // 2, intent.shape[0])
    for k in range(intent_size):
        intent[k, 0] = points[stop + 2 * k, 0]
        intent[k, 1] = points[stop + 2 * k, 1]
    return held_size, wanted_size, intent_size
