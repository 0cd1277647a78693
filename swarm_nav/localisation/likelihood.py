"""Likelihood fields: how probable it is that a LiDAR hit lies at a place of the map."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.grid import OCCUPIED
from swarm_nav.core.localisation_config import LocalisationConfig
from swarm_nav.localisation import amcl_kernels
from swarm_nav.localisation.amcl_kernels import HitWeights
from swarm_nav.planning.cells import distance_cells
from swarm_nav.planning.distance_kernels import Frame
from swarm_nav.planning.terrain import Terrain

DEPTH = 0.25  # of a cell, of a wall's face inside the outermost occupied cells


@dataclass(frozen=True, slots=True)
class LikelihoodField:
    """Likelihood field of one map."""

    # logarithm of the likelihood in each cell of the map and around it, 0 on a wall
    log: NDArray[np.float32]
    frame: Frame  # of its cells in map
    weights: HitWeights  # with which it was made
    agreement: float  # logarithm from which a hit is said to be at a wall


def field_for(terrain: Terrain, config: LocalisationConfig, range_max: float) -> LikelihoodField:
    """Return the field of a map; robots in one process share it.

    Args:
        config: Its sigma_hit, z_hit, z_rand and distances count.
        range_max: [m] of the LiDAR.
    """
    weights = HitWeights(config.z_hit, config.z_rand / range_max)
    return _field(
        terrain, config.sigma_hit, weights, config.laser_likelihood_max_dist,
        config.beam_skip_distance,
    )  # fmt: skip


@functools.lru_cache(maxsize=4)
def _field(
    terrain: Terrain, sigma: float, weights: HitWeights, most: float, agree: float
) -> LikelihoodField:
    grid = terrain.grid
    border = math.ceil(most / grid.resolution) + 1  # around the map, which may end with a wall
    distance = wall_distance(np.pad(grid.cells == OCCUPIED, border), grid.resolution)
    log = np.empty(distance.shape, np.float32)
    amcl_kernels.likelihood(distance, sigma, weights, most, log)
    x, y = (low - border * grid.resolution for low in (grid.origin_x, grid.origin_y))
    hit, other = weights.hit, weights.other
    least = hit * math.exp(-0.5 * (min(agree, most) / sigma) ** 2) + other
    return LikelihoodField(
        log, Frame(x, y, grid.resolution), weights, math.log(least / (hit + other))
    )


def wall_distance(cells: NDArray[np.bool_], size: float) -> NDArray[np.float64]:
    """Return the distance [m] of each cell's centre from the nearest wall's face.

    A wall that reaches into a cell occupies it, be it by the cell's width or by little, so its
    face is taken to be `DEPTH` of a cell inside. Within walls the distance is negative: were it
    zero all through a wall, a robot could slip into it by the wall's thickness unnoticed.

    Args:
        cells: (h, w), which are occupied.
        size: [m] of a cell.
    """
    if not cells.any():
        return np.full(cells.shape, np.inf)
    if cells.all():
        return np.full(cells.shape, -np.inf)
    outside = distance_cells(cells) - 0.5 + DEPTH
    inside = distance_cells(~cells) - 0.5 - DEPTH
    distances: NDArray[np.float64] = np.where(cells, -inside, outside) * size
    return distances
