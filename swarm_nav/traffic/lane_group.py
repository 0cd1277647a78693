"""Connected single lanes, and how many robots with goals there may be on them at a time.

Where two robots cannot pass each other, each robot needs a place of its own to make way to for one
that goes out: a blind end or a mouth. With as many guests as there are such places, less one, there
is always a free one (the condition C3 of docs/liveness.md). `conditions` tells before a run where
more robots have goals; the leases of `lease` let no more in at a time. `RobotView.passing` has the
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
from swarm_nav.traffic.single_lanes import Mask, connected_components, passing_areas, with_rim


@functools.lru_cache(maxsize=4)
def lane_labels(terrain: Terrain, radius: float) -> NDArray[np.int16]:
    """Return the number of the connected single lanes that each lattice cell belongs to.

    Args:
        radius: [m] safety radius: two robots keep twice that between their centres.

    Returns:
        (h, w) from 1; 0 where two robots pass each other, and in walls.
    """
    lanes = (terrain.lattice.base < search_kernels.WALL) & ~passing_areas(terrain, radius)
    return label(lanes)


@functools.lru_cache(maxsize=4)
def labels_with_rim(terrain: Terrain, radius: float) -> NDArray[np.int16]:
    """Return `lane_labels` for the places of robots, which may stand beside open cells.

    Args:
        terrain: See `lane_labels`.
    """
    return with_rim(lane_labels(terrain, radius), terrain.lattice.base < search_kernels.WALL)


class LaneGroup:
    """Connected single lanes of a map; what is worked out is kept.

    Attributes:
        cells: (h, w) of the lattice.
    """

    def __init__(self, terrain: Terrain, radius: float, number: int) -> None:
        """Find the cells.

        Args:
            terrain: See `lane_labels`.
        """
        self.cells = lane_labels(terrain, radius) == number
        self._terrain, self._radius = terrain, radius
        self._is_open = terrain.lattice.base < search_kernels.WALL

    @functools.cached_property
    def gaps(self) -> NDArray[np.float32]:
        """Distance [m] of each lattice cell (h, w)."""
        step = np.float32(self._terrain.lattice.step)
        return np.asarray(distance_cells(self.cells) * step, np.float32)

    @functools.cached_property
    def ways(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Cost of driving there.

        (h, w) [m] from each lattice cell, inf where there is no way; and for one mouth, if all have
        the same floor before them, the ways from its cells (n,) in rising order.
        """
        lattice = self._terrain.lattice
        base, against = lattice.base.copy(), lattice.lane.copy()
        base[self.cells] = against[self.cells] = 0.0
        space = SearchSpace(base, against, lattice.heading, lattice.step, lattice.slots)
        ways = np.full(base.shape, np.inf, np.float32)
        apart = np.flatnonzero(self.cells)  # without a way over the lanes from those before
        while len(apart):
            ways = np.minimum(ways, space.cost_to_go(int(apart[0])))
            apart = apart[ways.ravel()[apart] > 0.0]
        beyond = np.sort(ways[np.isfinite(ways) & ~self.cells])
        return ways, beyond[:: max(1, self._mouths)].copy()

    @functools.cached_property
    def extent(self) -> float:
        """Diagonal [m] of the box around them."""
        height, width = np.ptp(np.argwhere(self.cells), axis=0)
        return float(np.hypot(height, width)) * self._terrain.lattice.step

    @functools.cached_property
    def capacity(self) -> int:
        """Number of robots with goals there for which there is room, from 1."""
        return max(1, self._blind_ends() + self._mouths - 1)

    @functools.cached_property
    def _mouths(self) -> int:
        return len(list(connected_components(grown(self.cells) & self._is_open & ~self.cells)))

    def _blind_ends(self) -> int:
        """Return the number of blind ends, each with room for a robot."""
        lane = self.cells
        seeds = grown(passing_areas(self._terrain, self._radius)) & lane
        if not seeds.any():
            seeds.ravel()[int(np.flatnonzero(lane)[0])] = True
        away = np.where(seeds, 0, -1).astype(np.int32)  # steps from the nearest seed
        single_lane_kernels.flood(lane, away, -1, 1)
        cells = np.flatnonzero(lane)
        order = cells[np.argsort(-away.ravel()[cells], kind="stable")]
        gap = int(2.0 * self._radius / self._terrain.lattice.step)
        return int(single_lane_kernels.peaks(away.ravel(), order, lane.shape[1], gap))


@functools.lru_cache(maxsize=16)
def lane_group(terrain: Terrain, radius: float, number: int) -> LaneGroup:
    """Return connected single lanes by their label; the last few are kept.

    Args:
        terrain: See `lane_labels`.
    """
    return LaneGroup(terrain, radius, number)


def grown(mask: Mask) -> Mask:
    """Return a mask (h, w) and the cells beside it.

    Args:
        mask: (h, w)
    """
    wider = np.pad(mask, 1)
    rows = wider[:-2] | wider[1:-1] | wider[2:]
    return np.asarray(rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:], np.bool_)
