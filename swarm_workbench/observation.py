"""What a policy sees, in an environment and on a robot: the same numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, RobotSpec, Twist

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
        neighbours: Most that count.
    """
    count = len(goals)
    own = poses[:count]
    to_goals = _turned(own, (goals - own[:, :2])[:, None])[:, 0]
    return {
        "scan": np.clip(ranges, np.float32(0.0), np.float32(range_max)),
        "goal": to_goals.astype(np.float32),
        "twist": twists[:count].astype(np.float32),
        "neighbours": _heard(count, poses, twists, neighbours),
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


def _heard(
    count: int, poses: FloatArray, twists: FloatArray, neighbours: int
) -> NDArray[np.float32]:
    """Return what each of the first robots hears of its nearest neighbours (m, k, NEIGHBOUR)."""
    heard = np.zeros((count, neighbours, NEIGHBOUR), np.float32)
    most = min(neighbours, len(poses) - 1)
    if most == 0:
        return heard
    gaps = poses[None, :, :2] - poses[:count, None, :2]
    distances = np.einsum("ijk,ijk->ij", gaps, gaps)
    np.fill_diagonal(distances, np.inf)
    nearest = np.argsort(distances, axis=1)[:, :most]
    each = np.arange(count)[:, None]
    heard[:, :most, 0] = 1.0
    heard[:, :most, 1:3] = _turned(poses[:count], gaps[each, nearest])
    turns = poses[nearest, 2] - poses[:count, None, 2]
    heard[:, :most, 3] = turns - 2.0 * np.pi * np.round(turns / (2.0 * np.pi))
    heard[:, :most, 4:] = twists[nearest, :2]
    heard[:, :most][distances[each, nearest] > RADIO_RANGE**2] = 0.0
    return heard


def _turned(poses: FloatArray, gaps_map: FloatArray) -> FloatArray:
    """Return vectors (n, k, 2) in map in the base_footprint of each robot (n, 3)."""
    cos, sin = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    turned = np.empty_like(gaps_map)
    turned[:, :, 0] = cos * gaps_map[:, :, 0] + sin * gaps_map[:, :, 1]
    turned[:, :, 1] = cos * gaps_map[:, :, 1] - sin * gaps_map[:, :, 0]
    return turned
