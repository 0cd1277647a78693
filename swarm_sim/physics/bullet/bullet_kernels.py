"""Numba kernels around the rigid-body engine: speed ramps and the search for near pairs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray
from swarm_common.process.numba_compat import njit
from swarm_sim.physics.planar_kernels import Walls, is_beyond, ramp
from swarm_sim.physics.walker_kernels import disc_gap
from swarm_sim.scene.polygon_kernels import distance, place


@njit(cache=True)
def ramp_all(
    speeds: FloatArray, targets: FloatArray, limits: FloatArray, period: float
) -> NDArray[np.bool_]:
    """Move speeds (n, 3) one step towards targets; return which robots' speeds changed.

    Args:
        speeds: v, w, v to the left of each robot; changed.
        targets: Speeds that are aimed at, in the same order.
        limits: Accelerations.
        period: [s] of the step.
    """
    changed = np.zeros(len(speeds), np.bool_)
    for i in range(len(speeds)):
        for axis in range(3):
            speed = ramp(speeds[i, axis], targets[i, axis], limits[i, axis] * period)
            if speed != speeds[i, axis]:
                speeds[i, axis] = speed
                changed[i] = True
    return changed


@njit(cache=True)
def near_pairs(
    poses: FloatArray,
    radii: FloatArray,
    hulls: FloatArray,
    walls: Walls,
    near: float,
    robot_gaps: FloatArray,
    wall_gaps: FloatArray,
) -> tuple[int, int]:
    """List the pairs whose footprints are nearer than `near`; return how many of either kind.

    Args:
        poses: (n, 3).
        radii: (n,) circumscribed radii.
        hulls: (n, k, 2) footprints in base_footprint.
        walls: Walls that can be touched; discs are counted after the polygons.
        near: [m]
        robot_gaps: Rows i, j, distance with i < j, written.
        wall_gaps: Rows i, wall, distance, written.
    """
    placed = np.empty_like(hulls)
    for i in range(len(poses)):
        place(hulls[i], poses[i, 0], poses[i, 1], poses[i, 2], placed[i])
    robots, sides = 0, 0
    for i in range(len(poses)):
        x, y = poses[i, 0], poses[i, 1]
        for j in range(i + 1, len(poses)):
            reach = radii[i] + radii[j] + near
            dx, dy = poses[j, 0] - x, poses[j, 1] - y
            if dx * dx + dy * dy > reach * reach:
                continue
            gap = distance(placed[i], placed[j])
            if gap <= near:
                robot_gaps[robots, 0], robot_gaps[robots, 1] = i, j
                robot_gaps[robots, 2] = gap
                robots += 1
        for k in range(len(walls.polygons)):
            if is_beyond(walls.bounds[k], x, y, radii[i] + near):
                continue
            gap = distance(placed[i], walls.polygons[k])
            if gap <= near:
                wall_gaps[sides, 0], wall_gaps[sides, 1] = i, k
                wall_gaps[sides, 2] = gap
                sides += 1
        for k in range(len(walls.discs)):
            disc = walls.discs[k]
            if math.hypot(disc[0] - x, disc[1] - y) > radii[i] + disc[2] + near:
                continue
            gap = disc_gap(placed[i], disc[0], disc[1], disc[2])
            if gap <= near:
                wall_gaps[sides, 0], wall_gaps[sides, 1] = i, len(walls.polygons) + k
                wall_gaps[sides, 2] = gap
                sides += 1
    return robots, sides
