"""Bare numba kernels of the dynamic-window baseline (Fox, Burgard, Thrun 1997)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from swarm_common.model.records import FloatArray
from swarm_nav.planning.distance_kernels import Frame, sample

# What may be touched: distances of the map and their frame, discs (k, 3): x, y, radius, points
# (m, 2), and how far a body may extend around each of these.
Scene = tuple[FloatArray, Frame, FloatArray, FloatArray, float]

STEP = 0.1  # [s] of a rollout, and the control period
FAR = 1e9
TOO_NEAR = 0.01  # [m] below zero from which only a way out is admissible: one on which
GETAWAY = 0.3  # [m] of gap are gained per metre


@njit(cache=True)
def gap(x, y, radius, field, frame, discs, points, reach):
    """Distance [m] of a robot's circle at (x, y) from walls, discs (k, 3) and points (m, 2)."""
    best = sample(field, frame, x, y) - radius
    for k in range(discs.shape[0]):
        near = math.hypot(discs[k, 0] - x, discs[k, 1] - y) - discs[k, 2] - radius
        best = min(best, near)
    for k in range(points.shape[0]):
        near = math.hypot(points[k, 0] - x, points[k, 1] - y) - reach - radius
        best = min(best, near)
    return best


@njit(cache=True)
def path_gap(x, y, path):
    """Distance [m] of (x, y) to the nearest point of a path (n, 2)."""
    best = FAR
    for k in range(path.shape[0]):
        best = min(best, (path[k, 0] - x) ** 2 + (path[k, 1] - y) ** 2)
    return math.sqrt(best)


@njit(cache=True)
def follow(pose, v, w, steps, radius, scene, path):
    """Drive an arc; return (way to the first contact, smallest gap, end x, y, yaw, path gap).

    A robot that is a little too near to something already may go where it does not get nearer,
    one that is much too near only where it gets away.
    """
    field, frame, discs, points, reach = scene
    x, y, yaw = pose
    start = gap(x, y, radius, field, frame, discs, points, reach)
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
        near = gap(x, y, radius, field, frame, discs, points, reach)
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
def best_twist(pose, twist, target, limits, samples, radius, scene, path, scales, steps):
    """Return (v, w, score) of the best admissible twist; (0, 0, -FAR) if there is none.

    pose = (x, y, yaw), twist = (v, w) now; target = (x, y) on the path ahead; limits = (v_max,
    w_max, v_acc, w_acc); samples = (nv, nw); scene = (field, frame, discs, points, reach), see
    `gap`; scales = (heading, progress, path, clearance, clearance that is enough).
    A twist is admissible if the robot can stop before the first contact on its arc.
    """
    v_max, w_max, v_acc, w_acc = limits
    nv, nw = samples
    v_low = max(0.0, twist[0] - v_acc * STEP)
    v_high = min(v_max, max(0.0, twist[0]) + v_acc * STEP)
    w_low = max(-w_max, twist[1] - w_acc * STEP)
    w_high = min(w_max, twist[1] + w_acc * STEP)
    straight = min(max(0.0, w_low), w_high)
    rest = math.hypot(target[0] - pose[0], target[1] - pose[1])
    wish = max(1e-3, min(rest, v_max * STEP * steps))
    best = -FAR
    best_v = 0.0
    best_w = 0.0
    for a in range(nv):
        v = v_low + (v_high - v_low) * a / (nv - 1)
        for b in range(nw + 1):
            w = straight if b == nw else w_low + (w_high - w_low) * b / (nw - 1)
            free, smallest, x, y, yaw, off = follow(pose, v, w, steps, radius, scene, path)
            if v * STEP + v * v / (2.0 * v_acc) > free:
                continue
            left = math.hypot(target[0] - x, target[1] - y)
            ahead = math.atan2(target[1] - y, target[0] - x) if left > 0.05 else yaw
            error = abs((ahead - yaw + math.pi) % (2.0 * math.pi) - math.pi)
            score = scales[0] * (1.0 - error / math.pi)
            score += scales[1] * (rest - left) / wish
            score -= scales[2] * off
            score += scales[3] * min(max(smallest, 0.0), scales[4]) / scales[4]
            if score > best:
                best = score
                best_v = v
                best_w = w
    return best_v, best_w, best


@njit(cache=True)
def can_stop(pose, v, w, v_acc, radius, scene):
    """Whether a robot that drives (v, w) for a period can stop before it touches something."""
    free = follow(pose, v, w, 4, radius, scene, np.zeros((1, 2)))[0]
    return abs(v) * STEP + v * v / (2.0 * v_acc) <= free


@njit(cache=True)
def backing_room(pose, way, radius, scene):
    """Whether backing up by `way` [m] in a straight line touches nothing."""
    free, _, _, _, _, _ = follow(
        pose, -way, 0.0, round(1.0 / STEP), radius, scene, np.zeros((1, 2))
    )
    return free >= FAR
