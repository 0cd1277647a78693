"""Slow twins of the controller's and the obstacle layer's kernels."""

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


def twist_costs(
    pose: Pose, twist: tuple[float, float], path: FloatArray, v_limit: float,
    limits: tuple[float, float, float, float], samples: tuple[int, int], horizon: float,
    scales: tuple[float, float, float, float], steps: int,
) -> dict[tuple[float, float], float]:  # fmt: skip
    """Return the critics' sum of every twist in the dynamic window, admissible or not."""
    v_max, w_max, v_acc, w_acc = limits
    period = 0.1
    v_low = max(0.0, twist[0] - v_acc * period)
    v_high = max(v_low, min(v_max, v_limit, twist[0] + v_acc * period))
    w_low = max(-w_max, twist[1] - w_acc * period)
    w_high = min(w_max, twist[1] + w_acc * period)
    speeds = [v_low + (v_high - v_low) * a / (samples[0] - 1) for a in range(samples[0])]
    rates = [w_low + (w_high - w_low) * b / (samples[1] - 1) for b in range(samples[1])]
    rates.append(min(max(0.0, w_low), w_high))
    lengths = [math.dist(a, b) for a, b in itertools.pairwise(path)]

    def along(k: int, x: float, y: float) -> float:
        j = min(k, len(path) - 2)
        step = path[j + 1] - path[j]
        return sum(lengths[:k]) + float(step @ (np.array((x, y)) - path[k])) / lengths[j]

    start = along(0, pose[0], pose[1])
    wish = min(v_max * horizon, max(sum(lengths) - start, 1e-3))
    costs = {}
    for v, w in itertools.product(speeds, rates):
        poses = arc(pose, v, w, steps, period)
        k, gaps = 0, []
        for x, y, _ in poses:
            while k + 1 < len(path) and math.dist(path[k + 1], (x, y)) <= math.dist(
                path[k], (x, y)
            ):
                k += 1
            gaps.append(polyline_gap(path[max(0, k - 1) : k + 2], x, y) ** 2)
        x, y, yaw = poses[-1]
        step = path[min(k, len(path) - 2) + 1] - path[min(k, len(path) - 2)]
        turn = (yaw - math.atan2(step[1], step[0]) + math.pi) % (2 * math.pi) - math.pi
        short = max(0.0, wish - (along(k, x, y) - start)) / (v_max * horizon)
        critics = (sum(gaps) / steps / 0.05**2, short, turn * turn, abs(w - twist[1]))
        costs[v, w] = sum(scale * value for scale, value in zip(scales, critics, strict=True))
    return costs


def polyline_gap(path: FloatArray, x: float, y: float) -> float:
    """Return the distance of a point to a polyline."""
    point, best = np.array((x, y)), math.inf
    for a, b in itertools.pairwise(path):
        share = min(1.0, max(0.0, float((point - a) @ (b - a)) / float((b - a) @ (b - a))))
        best = min(best, math.dist(a + share * (b - a), point))
    return best


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
