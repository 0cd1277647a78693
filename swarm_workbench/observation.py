"""Observation of a policy, in an environment and on a robot: the same numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, RobotSpec, Twist
from swarm_workbench import observation_kernels

REACHED = 0.25  # [m] from the goal
NEIGHBOUR = 6  # there (0 or 1), x, y [m], yaw [rad] in base_footprint, vx [m/s], wz [rad/s]
RADIO_RANGE = 8.0  # [m] up to which a neighbour's beacon counts
Observation = dict[str, NDArray[np.float32]]


def observe(
    ranges: NDArray[np.float32],
    range_max: float,
    goals: FloatArray,
    poses: FloatArray,
    twists: FloatArray,
    neighbours: int,
) -> Observation:
    """Return what the first m of n robots see, a row for each.

    Args:
        ranges: (m, rays) [m] of their latest scans.
        range_max: [m] of their LiDARs.
        goals: (m, 2) [m] in map.
        poses: (n, 3) x, y, yaw in map.
        twists: (n, 3) vx, wz, vy; vy of the first m only.
        neighbours: Rows of each, the nearest first; zeros where there are fewer in range.
    """
    count = len(goals)
    heard = np.zeros((count, neighbours, NEIGHBOUR), np.float32)
    observation_kernels.nearest(poses, twists, RADIO_RANGE, heard)
    cos, sin = np.cos(poses[:count, 2]), np.sin(poses[:count, 2])
    gap_x, gap_y = (goals - poses[:count, :2]).T
    to_goals = np.column_stack((cos * gap_x + sin * gap_y, cos * gap_y - sin * gap_x))
    return {
        "scan": np.clip(ranges, np.float32(0.0), np.float32(range_max)),
        "goal": to_goals.astype(np.float32),
        "twist": twists[:count].astype(np.float32),
        "neighbours": heard,
    }


def speeds_of(spec: RobotSpec) -> FloatArray:
    """Return the largest vx, wz and vy [m/s], [rad/s] of a robot; actions are limited to them."""
    return np.array([spec.max_vel_x, spec.max_vel_theta, spec.max_vel_y])


def twist_of(action: FloatArray, spec: RobotSpec) -> Twist:
    """Return the twist of an action: vx, wz and perhaps vy; a number that is none counts as 0."""
    speeds = speeds_of(spec)
    values = np.zeros(3)
    values[: len(action)] = action
    values[~np.isfinite(values)] = 0.0
    vx, wz, vy = np.clip(values, -speeds, speeds).tolist()
    return Twist(vx, vy, wz)
