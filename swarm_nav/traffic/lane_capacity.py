"""How many robots with goals on connected single lanes may be there at a time.

Where two robots cannot pass each other, each robot needs a place of its own to make way to for one
that goes out: a blind end or a mouth. With as many guests as there are such places, less one, there
is always a free one (the condition C3 of docs/liveness.md). `conditions` tells before a run where
more robots have goals; the leases of `lease` let no more in at a time. `RobotState.passing` has the
size of robot that it is told by.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from swarm_nav.planning import search_kernels
from swarm_nav.planning.cells import distance_cells, label
from swarm_nav.planning.search import SearchSpace
from swarm_nav.planning.terrain import Terrain
from swarm_nav.traffic import single_lane_kernels
from swarm_nav.traffic.single_lanes import Mask, parts, rooms, with_rim


@functools.lru_cache(maxsize=4)
def lane_labels(terrain: Terrain, radius: float) -> NDArray[np.int16]:
    """Return the number of the connected single lanes that each lattice cell belongs to.

    Args:
        radius: [m] safety radius: two robots keep twice that between their centres.

    Returns:
        (h, w) from 1; 0 where two robots pass each other, and in walls.
    """
    lanes = (terrain.lattice.base < search_kernels.WALL) & ~rooms(terrain, radius)
    return label(lanes)


@functools.lru_cache(maxsize=4)
def labels_with_rim(terrain: Terrain, radius: float) -> NDArray[np.int16]:
    """Return `lane_labels` for the places of robots, which may stand beside open cells.

    Args:
        terrain: See `lane_labels`.
    """
    return with_rim(lane_labels(terrain, radius), terrain.lattice.base < search_kernels.WALL)


@functools.lru_cache(maxsize=4)
def gaps_to(terrain: Terrain, radius: float, lane: int) -> NDArray[np.float32]:
    """Return the distance [m] of each lattice cell (h, w) from connected single lanes.

    Args:
        terrain: See `lane_labels`.
    """
    found = distance_cells(lane_labels(terrain, radius) == lane)
    return np.asarray(found * np.float32(terrain.lattice.step), np.float32)


@functools.lru_cache(maxsize=16)
def ways_to(
    terrain: Terrain, radius: float, lane: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the cost of driving to connected single lanes.

    Args:
        terrain: See `lane_labels`.

    Returns:
        (h, w) [m] from each lattice cell, inf where there is no way; and for one mouth, if all have
        the same floor before them, the ways from its cells (n,) in rising order.
    """
    lattice = terrain.lattice
    is_lane = lane_labels(terrain, radius) == lane
    base, against = lattice.base.copy(), lattice.lane.copy()
    base[is_lane] = against[is_lane] = 0.0
    space = SearchSpace(base, against, lattice.heading, lattice.step, lattice.slots)
    ways = np.full(base.shape, np.inf, np.float32)
    apart = np.flatnonzero(is_lane)  # without a way from those before that stays on the lanes
    while len(apart):
        ways = np.minimum(ways, space.cost_to_go(int(apart[0])))
        apart = apart[ways.ravel()[apart] > 0.0]
    beyond = np.sort(ways[np.isfinite(ways) & ~is_lane])
    return ways, beyond[:: max(1, mouths(terrain, radius, lane))].copy()


@functools.lru_cache(maxsize=64)
def extent(terrain: Terrain, radius: float, lane: int) -> float:
    """Return the diagonal [m] of the box around connected single lanes.

    Args:
        terrain: See `lane_labels`.
    """
    cells = np.argwhere(lane_labels(terrain, radius) == lane)
    return float(np.hypot(*np.ptp(cells, axis=0))) * terrain.lattice.step


@functools.lru_cache(maxsize=64)
def capacity(terrain: Terrain, radius: float, lane: int) -> int:
    """Return how many robots that have goals on connected single lanes have room there, from 1.

    Args:
        terrain: See `lane_labels`.
    """
    cells = lane_labels(terrain, radius) == lane
    gap = int(2.0 * radius / terrain.lattice.step)
    blind_ends = _blind_ends(cells, rooms(terrain, radius), gap)
    return max(1, blind_ends + mouths(terrain, radius, lane) - 1)


@functools.lru_cache(maxsize=64)
def mouths(terrain: Terrain, radius: float, lane: int) -> int:
    """Return the number of mouths of connected single lanes.

    Args:
        terrain: See `lane_labels`.
    """
    is_open = terrain.lattice.base < search_kernels.WALL
    cells = lane_labels(terrain, radius) == lane
    return len(list(parts(grown(cells) & is_open & ~cells)))


def _blind_ends(lane: Mask, wide: Mask, gap: int) -> int:
    """Return the number of blind ends of single lanes, each with room for a robot.

    Args:
        lane: (h, w) their cells.
        wide: (h, w) cells where two robots pass each other.
    """
    seeds = grown(wide) & lane
    if not seeds.any():
        seeds.ravel()[int(np.flatnonzero(lane)[0])] = True
    away = np.where(seeds, 0, -1).astype(np.int32)  # steps from the nearest seed
    single_lane_kernels.flood(lane, away, -1, 1)
    cells = np.flatnonzero(lane)
    order = cells[np.argsort(-away.ravel()[cells], kind="stable")]
    return int(single_lane_kernels.peaks(away.ravel(), order, lane.shape[1], gap))


def grown(mask: Mask) -> Mask:
    """Return a mask (h, w) and the cells beside it.

    Args:
        mask: (h, w)
    """
    wider = np.pad(mask, 1)
    rows = wider[:-2] | wider[1:-1] | wider[2:]
    return np.asarray(rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:], np.bool_)
