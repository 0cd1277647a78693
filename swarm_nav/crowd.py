"""How other robots enter the search lattice: as costs to go around, or as walls for a refuge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.beacon import MODE_YIELD
from swarm_nav import distance_kernels
from swarm_nav.search_kernels import WALL
from swarm_nav.situation import Situation

STANDING, MOVING, YIELDING, STUCK, OBSTACLE = 3.0, 0.6, 0.3, 30.0, 50.0  # extra cost per metre
PUSHABLE = 4.0  # extra cost per metre of a way on which a lower robot must be pushed
MOVING_SPEED = 0.05  # [m/s]
IMMOVABLE_MARGIN = 0.1  # [m] more than the reach that a way keeps from who cannot be pushed


def stamp(
    grid: NDArray[np.float32], situation: Situation, points: object, radius: float, value: float
) -> None:
    """Raise the lattice cells within `radius` of the points to at least `value`."""
    block = np.ascontiguousarray(points, np.float64).reshape(-1, 2)
    lattice = situation.planner.lattice
    distance_kernels.stamp_discs(grid, *lattice.frame, block, len(block), radius, np.float32(value))


def stamp_obstacles(grid: NDArray[np.float32], situation: Situation, value: float) -> None:
    """Stamp what the LiDAR sees beyond map and beacons."""
    points = situation.obstacle_points()
    if len(points):
        stamp(grid, situation, points, situation.obstacle_clearance + 0.03, value)


def congestion(situation: Situation) -> NDArray[np.float32]:
    """Return the extra costs under which a way to the goal is planned."""
    extra = situation.planner.no_extra()
    hood = situation.hood
    stuck, immovable = hood.stuck, hood.immovable
    for row in range(len(hood.beacons)):
        beacon = hood.beacons[row]
        if stuck[row]:
            value = STUCK
        elif beacon["mode"] == MODE_YIELD:
            value = YIELDING
        elif abs(float(beacon["twist"][0])) > MOVING_SPEED:
            value = MOVING
        else:
            value = STANDING
        # who cannot be pushed may not be grazed by the lattice's coarseness
        margin = IMMOVABLE_MARGIN if immovable[row] else 0.0
        stamp(extra, situation, hood.tubes(row), situation.reach(row) + margin, value)
    stamp_obstacles(extra, situation, OBSTACLE)
    return extra


def refuge_costs(situation: Situation, priority: int, margin: float) -> NDArray[np.float32]:
    """Return extra costs for making way at `priority`: who ranks as high or is stuck is a wall."""
    extra = situation.planner.no_extra()
    hood = situation.hood
    stuck = hood.stuck
    for row in range(len(hood.beacons)):
        if hood.priorities[row] >= priority or stuck[row]:
            value = float(WALL)
        else:
            value = PUSHABLE
        stamp(extra, situation, hood.tubes(row), situation.reach(row) + margin, value)
    stamp_obstacles(extra, situation, float(WALL))
    return extra
