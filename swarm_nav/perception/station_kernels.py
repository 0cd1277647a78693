"""Bare numba kernels on the table of neighbours: the robots that wait for a station."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import word_of
from swarm_common.process.numba_compat import njit
from swarm_nav.core.priority import DEPTH_BITS, ID_MASK
from swarm_nav.perception.neighbor_table_kernels import ID

STATION = word_of("station")
STATION_TICK = word_of("station_tick")


@njit(cache=True)
def earlier_requests(
    words: NDArray[np.uint32],
    floats: NDArray[np.float32],
    gone: NDArray[np.bool_],
    station: tuple[float, float],
    tick: int,
    own_id: int,
    same: float,
) -> tuple[int, int]:
    """Count the robots that asked for a station before (tick, own_id), in lexicographic order.

    Args:
        words: (n, words) uint32, the neighbours' beacons.
        floats: The same memory as float32.
        gone: (n,) whether each is silent.
        station: (x, y) [m] in map.
        tick: Of the own request.
        own_id: Of this robot.
        same: [m] within which two stations are the same.

    Returns:
        The number of such robots, and the id of the first of them, 0 for none.
    """
    count = 0
    first = 0
    first_asked = np.int64(0)
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
            robot = np.int64(words[row, ID])
            if count == 1 or asked < first_asked or (asked == first_asked and robot < first):
                first, first_asked = robot, asked
    return count, first


@njit(cache=True)
def highest_waiting(
    words: NDArray[np.uint32],
    floats: NDArray[np.float32],
    gone: NDArray[np.bool_],
    priorities: NDArray[np.int64],
    station: tuple[float, float],
    same: float,
) -> int:
    """Return the highest priority of the robots that asked for a station, 0 if there are none.

    Only priorities of their own count, told by the id in them: one that was inherited may come
    from the very robot that asks, and would go round for ever.

    Args:
        words: (n, words) uint32, the neighbours' beacons.
        floats: The same memory as float32.
        gone: (n,) whether each is silent.
        priorities: (n,) as published.
        station: (x, y) [m] in map.
        same: [m] within which two stations are the same.
    """
    highest = 0
    for row in range(gone.shape[0]):
        if words[row, STATION_TICK] == 0 or gone[row]:
            continue
        owner = ID_MASK - ((priorities[row] >> DEPTH_BITS) & ID_MASK)
        if owner != np.int64(words[row, ID]) % (ID_MASK + 1):
            continue
        dx = floats[row, STATION] - station[0]
        dy = floats[row, STATION + 1] - station[1]
        if math.hypot(dx, dy) < same:
            highest = max(highest, priorities[row])
    return highest
