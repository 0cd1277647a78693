"""Slow twins of the controller's and the obstacle layer's kernels."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Pose = tuple[float, float, float]


def arc(pose: Pose, v: float, w: float, steps: int, period: float) -> FloatArray:
    """Return the poses (steps, 3) under a constant twist, by midpoint integration."""
    x, y, yaw = pose
    poses = []
    for _ in range(steps):
        middle = yaw + w * period / 2
        x, y, yaw = (
            x + v * period * math.cos(middle),
            y + v * period * math.sin(middle),
            (yaw + w * period),
        )
        poses.append((x, y, yaw))
    return np.array(poses)


def segment_gap(path: FloatArray, x: float, y: float) -> float:
    """Return the distance of a point to a polyline, by fine sampling."""
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    dense = [a + share * (b - a) for a, b in itertools.pairwise(path)]
    return float(np.hypot(*(np.vstack(dense) - (x, y)).T).min())


def held_gap(path: FloatArray, held: int, x: float, y: float) -> float:
    """Return the distance of a point to the first `held` segments, to the first point for 0."""
    if held == 0:
        return math.dist(path[0], (x, y))
    return segment_gap(path[: held + 1], x, y)


def stop_point(
    pose: Pose, speed: float, v: float, w: float, v_acc: float, period: float
) -> tuple[float, float]:
    """Return where a robot stands that ramps to v in one period and brakes then, in fine steps.

    Its heading stays that of the middle of the period.
    """
    count = 2000
    middles = (np.arange(count) + 0.5) / count
    way = float((speed + (v - speed) * middles).sum()) * period / count
    braking = v / v_acc
    way += float((v - v_acc * braking * middles).sum()) * braking / count
    yaw = pose[2] + w * period / 2
    return pose[0] + way * math.cos(yaw), pose[1] + way * math.sin(yaw)


def unexplained(
    hits: FloatArray, ranges: FloatArray, limits: tuple[float, float, float],
    wall_distances: FloatArray, robots: FloatArray, reach: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the hits that are neither too near, too far, a mapped wall nor a known robot.

    limits = (range_min, range_max, static_tolerance).
    """
    kept = []
    for hit, distance, wall in zip(hits, ranges, wall_distances, strict=True):
        is_robot = any(math.dist(hit, robot) < r for robot, r in zip(robots, reach, strict=True))
        if limits[0] <= distance <= limits[1] and wall >= limits[2] and not is_robot:
            kept.append(hit)
    return np.array(kept).reshape(-1, 2)
