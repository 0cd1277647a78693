"""Bare numba kernels of the baselines: dynamic window (Fox, Burgard, Thrun 1997), and sight."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_common.process.numba_compat import njit
from swarm_nav.control.dwa_kernels import Limits, Velocity
from swarm_nav.planning.distance_kernels import Field, Frame, Place, sample

STEP = 0.1  # [s] of a rollout, and the control period
FAR = 1e9
TOO_NEAR = 0.01  # [m] of overlap beyond which only a way out is admissible
GETAWAY = 0.3  # [m] of gap that a way out gains per metre
SIGHT_STEP = 0.05  # [m] between the samples of a line
STRIDE = 3  # path points between two candidates


class Obstacles(NamedTuple):
    """Obstacles that the robot may touch: walls, discs and LiDAR points."""

    distance: FloatArray  # (h, w) [m] from mapped walls
    frame: Frame  # of these
    discs: FloatArray  # (k, 3) [m] x, y, radius
    points: FloatArray  # (m, 2) [m] that the LiDAR sees
    reach: float  # [m] by which a body may extend around each point


class WindowSamples(NamedTuple):
    """How many speeds of the window are tried."""

    v: int
    w: int


class Weights(NamedTuple):
    """Weights of the objective."""

    heading: float
    progress: float
    path: float
    clearance: float
    enough: float  # [m] of clearance beyond which more is not rewarded


@njit(cache=True)
def gap(x: float, y: float, radius: float, obstacles: Obstacles) -> float:
    """Return the distance [m] of a robot's circle from what may be touched.

    Args:
        x: [m] of its centre, in map.
        y: [m] of its centre, in map.
        radius: [m]
        obstacles: What may be touched.
    """
    discs, points, reach = obstacles.discs, obstacles.points, obstacles.reach
    best = sample(obstacles.distance, obstacles.frame, x, y) - radius
    for k in range(discs.shape[0]):
        near = math.hypot(discs[k, 0] - x, discs[k, 1] - y) - discs[k, 2] - radius
        best = min(best, near)
    for k in range(points.shape[0]):
        near = math.hypot(points[k, 0] - x, points[k, 1] - y) - reach - radius
        best = min(best, near)
    return best


@njit(cache=True)
def path_gap(x: float, y: float, path: FloatArray) -> float:
    """Return the distance [m] of (x, y) to the nearest point of a path (n, 2).

    Args:
        x: [m] in map.
        y: [m] in map.
        path: (n, 2) [m] in map.
    """
    best = FAR
    for k in range(path.shape[0]):
        best = min(best, (path[k, 0] - x) ** 2 + (path[k, 1] - y) ** 2)
    return math.sqrt(best)


@njit(cache=True)
def follow(
    pose: Place,
    v: float,
    w: float,
    steps: int,
    radius: float,
    obstacles: Obstacles,
    path: FloatArray,
) -> tuple[float, float, float, float, float, float]:
    """Drive an arc for `steps` periods.

    A robot that is slightly too near to something may drive wherever the gap does not shrink. If it
    is much too near, the gap has to grow.

    Args:
        pose: Where it starts.
        v: [m/s]
        w: [rad/s]
        steps: Periods of `STEP`.
        radius: [m] of the robot.
        obstacles: What may be touched.
        path: (n, 2) [m] in map.

    Returns:
        Way to the first contact [m], smallest gap [m], x, y [m] and yaw [rad] at the end, and mean
        distance from the path [m].
    """
    x, y, yaw = pose
    start = gap(x, y, radius, obstacles)
    floor = min(0.0, start)
    rise = GETAWAY * abs(v) * STEP if start < -TOO_NEAR else 0.0
    smallest = start
    free = FAR
    off_path = 0.0
    if v == 0.0:  # a circle that turns on the spot
        return free, smallest, x, y, yaw + w * steps * STEP, path_gap(x, y, path)
    looks = 0
    for s in range(steps):
        middle = yaw + 0.5 * w * STEP
        x += v * STEP * math.cos(middle)
        y += v * STEP * math.sin(middle)
        yaw += w * STEP
        near = gap(x, y, radius, obstacles)
        smallest = min(smallest, near)
        floor += rise
        if near < min(floor, 0.0):
            free = abs(v) * STEP * s
            break
        if s % 3 == 2:
            off_path += path_gap(x, y, path)
            looks += 1
    return free, smallest, x, y, yaw, off_path / max(1, looks)


@njit(cache=True)
def best_twist(
    pose: Place,
    twist: Velocity,
    target: tuple[float, float],
    limits: Limits,
    samples: WindowSamples,
    radius: float,
    obstacles: Obstacles,
    path: FloatArray,
    scales: Weights,
    steps: int,
) -> tuple[float, float, float]:
    """Return (v, w, score) of the best admissible twist; (0, 0, -FAR) if there is none.

    A twist is admissible if the robot can stop before the first contact on its arc:
    v STEP + v² / (2 v_acc) is at most the way to it. The score is the weighted sum of heading,
    progress and clearance less the distance from the path.

    Args:
        pose: Pose of the robot in map.
        twist: Now.
        target: (x, y) [m] in map, on the path ahead.
        limits: Limits of the drive: speeds and accelerations.
        samples: Numbers of speeds that are tried.
        radius: [m] of the robot.
        obstacles: What may be touched.
        path: (n, 2) [m] in map.
        scales: Weights of the terms of the objective.
        steps: Periods of a rollout.
    """
    v_max, w_max, v_acc, w_acc = limits
    nv, nw = samples
    v_low = max(0.0, twist.v - v_acc * STEP)
    v_high = min(v_max, max(0.0, twist.v) + v_acc * STEP)
    w_low = max(-w_max, twist.w - w_acc * STEP)
    w_high = min(w_max, twist.w + w_acc * STEP)
    straight = min(max(0.0, w_low), w_high)
    rest = math.hypot(target[0] - pose.x, target[1] - pose.y)
    wish = max(1e-3, min(rest, v_max * STEP * steps))
    best = -FAR
    best_v = 0.0
    best_w = 0.0
    for a in range(nv):
        v = v_low + (v_high - v_low) * a / (nv - 1)
        for b in range(nw + 1):
            w = straight if b == nw else w_low + (w_high - w_low) * b / (nw - 1)
            free, smallest, x, y, yaw, off = follow(pose, v, w, steps, radius, obstacles, path)
            if v * STEP + v * v / (2.0 * v_acc) > free:
                continue
            left = math.hypot(target[0] - x, target[1] - y)
            ahead = math.atan2(target[1] - y, target[0] - x) if left > 0.05 else yaw
            error = abs((ahead - yaw + math.pi) % (2.0 * math.pi) - math.pi)
            score = scales.heading * (1.0 - error / math.pi)
            score += scales.progress * (rest - left) / wish
            score -= scales.path * off
            clear = min(max(smallest, 0.0), scales.enough)
            score += scales.clearance * clear / scales.enough
            if score > best:
                best = score
                best_v = v
                best_w = w
    return best_v, best_w, best


@njit(cache=True)
def can_stop(
    pose: Place, v: float, w: float, v_acc: float, radius: float, obstacles: Obstacles
) -> bool:
    """Whether a robot that drives (v, w) for a period can stop before it touches something.

    Args:
        pose: Pose of the robot in map.
        v: [m/s]
        w: [rad/s]
        v_acc: [m/s²] with which it brakes.
        radius: [m] of the robot.
        obstacles: What may be touched.
    """
    free = follow(pose, v, w, 4, radius, obstacles, np.zeros((1, 2)))[0]
    return abs(v) * STEP + v * v / (2.0 * v_acc) <= free


@njit(cache=True)
def backing_room(pose: Place, way: float, radius: float, obstacles: Obstacles) -> bool:
    """Whether backing up in a straight line touches nothing.

    Args:
        pose: Pose of the robot in map.
        way: [m]
        radius: [m] of the robot.
        obstacles: What may be touched.
    """
    free, _, _, _, _, _ = follow(
        pose, -way, 0.0, round(1.0 / STEP), radius, obstacles, np.zeros((1, 2))
    )
    return free >= FAR


@njit(cache=True)
def farthest_in_sight(
    points: FloatArray, x: float, y: float, clearance: float, slack: float, walls: Field
) -> int:
    """Return the index of the last point to which the line from (x, y) is clear; 0 without one.

    Args:
        points: (n, 2) [m] in map.
        x: [m] in map.
        y: [m] in map.
        clearance: [m] that a clear line keeps from walls; less if one of its ends is nearer.
        slack: [m] by which the line may be nearer than that.
        walls: Distances to them.
    """
    field, frame = walls
    here = min(clearance, sample(field, frame, x, y))
    for k in range(points.shape[0] - 1, 0, -STRIDE):
        dx = points[k, 0] - x
        dy = points[k, 1] - y
        there = sample(field, frame, points[k, 0], points[k, 1])
        floor = min(here, there) - slack
        steps = max(1, math.ceil(math.hypot(dx, dy) / SIGHT_STEP))
        clear = True
        for s in range(1, steps):
            share = s / steps
            px = x + share * dx
            py = y + share * dy
            if sample(field, frame, px, py) < floor:
                clear = False
                break
        if clear:
            return k
    return 0
