"""Bare numba kernels of floor that robots queue for: who is inside or asks, and blind aisles.

Args of more than one kernel:
    region: (height, width) number of the part that each cell belongs to, 0 outside.
    robots: `Robots` as a plain tuple.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import MODE_HOLD
from swarm_common.model.records import Mask
from swarm_common.process.numba_compat import njit
from swarm_nav.core.rank import SENIORITY, outranks
from swarm_nav.perception.absence_kernels import Sightings
from swarm_nav.planning.distance_kernels import Floats, Frame
from swarm_nav.traffic.single_lane_kernels import Labels, label_at


class GateColumns(NamedTuple):
    """The gate in the neighbours' beacons; a row per robot, the first ones are in use."""

    poses: NDArray[np.float32]  # (rows, 3) [m], [m], [rad] in map
    gate_ticks: NDArray[np.uint32]  # 0: asks not, 1: is admitted, later: asks since
    blocked_ticks: NDArray[np.uint32]
    modes: NDArray[np.uint32]


class RequestColumns(NamedTuple):
    """Requests in the neighbours' beacons; a row per robot, the first ones are in use."""

    stations: NDArray[np.float32]  # (rows, 2) [m] in map, NaN without one
    station_ticks: NDArray[np.uint32]  # 0: asks not, later: asks since
    gate_ticks: NDArray[np.uint32]  # as of `GateColumns`


class Robots(NamedTuple):
    """The neighbours, (n,) each."""

    ids: NDArray[np.uint32]
    priorities: NDArray[np.int64]
    gone: NDArray[np.bool_]  # whether it is silent


@njit(cache=True)
def entry(region: Labels | Mask, frame: Frame, way: Floats) -> int:
    """Return the index of the first point of a path that lies in the region, -1 if none does.

    Args:
        way: (n, 2) [m] in map.
    """
    for k in range(way.shape[0]):
        if label_at(region, frame, way[k, 0], way[k, 1]) > 0:
            return k
    return -1


@njit(cache=True)
def count_ahead(
    region: Labels,
    frame: Frame,
    columns: tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.uint32], NDArray[np.uint32]],
    robots: tuple[NDArray[np.uint32], NDArray[np.int64], NDArray[np.bool_]],
    own: tuple[int, int, int],
    mouth: tuple[float, float, float],
) -> tuple[int, int, bool, int]:
    """Count the robots that enter before this one, and those that wait inside for a station.

    The first are admitted, or ask from nearer to the mouth, and are not blocked on their way.

    Args:
        columns: `GateColumns` as a plain tuple.
        own: Seniority and id of this robot, and for how many ticks one that counts may have been
            blocked on its way to the mouth.
        mouth: x, y [m] in map of where this robot's way enters the region, and how far it is
            from there [m].

    Returns:
        Both numbers, whether none of those with a goal that are inside, admitted or ask ranks above
        this robot, and the id of the highest of those that count or are inside, 0 without any.
    """
    poses, gate_ticks, blocked, modes = GateColumns(*columns)
    ids, priorities, gone = Robots(*robots)
    seniority, own_id, patience = own
    x, y, distance = mouth
    coming = 0
    waiting = 0
    is_highest = True
    first = 0
    highest = np.int64(-1)
    for k in range(ids.shape[0]):
        inside = label_at(region, frame, poses[k, 0], poses[k, 1]) > 0
        if not inside and gate_ticks[k] == 0:
            continue
        theirs = priorities[k] & SENIORITY
        if outranks(theirs, ids[k], seniority, own_id):
            if not gone[k] and priorities[k] > SENIORITY:  # that has a goal
                is_highest = False
        if inside:
            waiting += modes[k] == MODE_HOLD
        else:
            is_nearer = math.hypot(poses[k, 0] - x, poses[k, 1] - y) < distance
            if blocked[k] > patience or not (gate_ticks[k] == 1 or is_nearer):
                continue
            coming += 1
        if theirs > highest:
            first, highest = np.int64(ids[k]), theirs
    return coming, waiting, is_highest, first


@njit(cache=True)
def highest_asking(
    floor: Labels | Mask,
    frame: Frame,
    columns: tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.uint32]],
    robots: tuple[NDArray[np.uint32], NDArray[np.int64], NDArray[np.bool_]],
    at_gate: bool,
) -> int:
    """Return the highest priority of the robots that ask for a station on a floor, 0 without any.

    Args:
        floor: (height, width) above 0 where it is.
        columns: `RequestColumns` as a plain tuple.
        at_gate: Whether robots that wait at a gate count, wherever their station is.
    """
    stations, station_ticks, gate_ticks = RequestColumns(*columns)
    ids, priorities, gone = Robots(*robots)
    highest = np.int64(0)
    for k in range(ids.shape[0]):
        if gone[k] or priorities[k] <= highest:
            continue
        x, y = stations[k, 0], stations[k, 1]
        asks = station_ticks[k] > 0 and math.isfinite(x + y) and label_at(floor, frame, x, y) > 0
        if asks or (at_gate and gate_ticks[k] > 1):
            highest = priorities[k]
    return highest


@njit(cache=True)
def count_seen(
    parts: Labels,
    part: int,
    frame: Frame,
    known: Sightings,
    since: int,
    own_id: int,
    must_ask: bool,
) -> int:
    """Return how many other robots are in a part of the floor, as far as anybody told.

    Args:
        parts: (height, width) number of the part that each cell belongs to, 0 outside.
        part: Number of the part that is looked at.
        since: Tick before which a sighting does not count.
        own_id: Id of this robot.
        must_ask: Whether only those count that had asked for a station.
    """
    count = 0
    for robot in range(known.ticks.shape[0]):
        if must_ask and not known.asks[robot]:
            continue
        if known.ticks[robot] >= since and robot != own_id:
            place = known.places[robot]
            count += label_at(parts, frame, place[0], place[1]) == part
    return count


@njit(cache=True)
def blind_floor(
    distances: NDArray[np.float32],
    step: float,
    within: tuple[float, float],
    farthest: float,
    widest: float,
) -> float:
    """Return the floor [m²] of the largest blind aisle around a station, 0.0 if there is none.

    A blind aisle is the floor within some distance of the station if all its cells from which the
    floor goes on lie in a square of `widest`, and `least` or more lies beyond them: the last corner
    of a closed room leads nowhere.

    Args:
        distances: (h, w) [m] by the way from each lattice cell to the station; inf without one.
        step: [m] of a cell.
        within: (least, most) [m²] of floor.
        farthest: Largest distance [m] of the mouth.
        widest: [m] edge of the square.
    """
    least, most = within
    height, width = distances.shape
    all_cells = np.isfinite(distances).sum()
    found = 0.0
    for number in range(1, int(farthest / step) + 1):
        mouth = number * step
        top, bottom, left, right, cells = height, -1, width, -1, 0
        for r in range(height):
            for c in range(width):
                if not distances[r, c] <= mouth:
                    continue
                cells += 1
                leads_on = False
                for y, x in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)):
                    if 0 <= y < height and 0 <= x < width:
                        leads_on |= mouth < distances[y, x] < np.inf
                if leads_on:
                    top, bottom = min(top, r), max(bottom, r)
                    left, right = min(left, c), max(right, c)
        floor = cells * step * step
        beyond = (all_cells - cells) * step * step
        if floor >= most or beyond < least:
            break
        if floor >= least and step * max(bottom - top, right - left) < widest:
            found = floor
    return found
