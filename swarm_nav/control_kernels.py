"""Bare numba kernels of the dynamic-window controller (Fox, Burgard, Thrun 1997; DWB's critics)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

STEP = 0.1  # [s] of a rollout
DISTANCE_UNIT = 0.05  # [m] of path distance that costs one path_distance_scale


@njit(cache=True)
def rollout(x, y, yaw, v, w, steps, path, first, out):
    """Follow a constant twist; return (mean squared path distance, index reached, final yaw)."""
    k = first
    total = 0.0
    for s in range(steps):
        middle = yaw + 0.5 * w * STEP
        x += v * STEP * math.cos(middle)
        y += v * STEP * math.sin(middle)
        yaw += w * STEP
        best = (path[k, 0] - x) ** 2 + (path[k, 1] - y) ** 2
        while k + 1 < path.shape[0]:
            ahead = (path[k + 1, 0] - x) ** 2 + (path[k + 1, 1] - y) ** 2
            if ahead > best:
                break
            best = ahead
            k += 1
        total += segment_gap(path, k, x, y)
        out[s, 0] = x
        out[s, 1] = y
        out[s, 2] = yaw
    return total / steps, k, yaw


@njit(cache=True)
def segment_gap(path, k, x, y):
    """Squared distance of (x, y) to the segments on either side of point k."""
    best = 1e20
    for j in range(max(0, k - 1), min(path.shape[0] - 1, k + 1)):
        ax = path[j + 1, 0] - path[j, 0]
        ay = path[j + 1, 1] - path[j, 1]
        length = ax * ax + ay * ay
        if length < 1e-12:
            continue
        t = ((x - path[j, 0]) * ax + (y - path[j, 1]) * ay) / length
        t = min(max(t, 0.0), 1.0)
        dx = path[j, 0] + t * ax - x
        dy = path[j, 1] + t * ay - y
        best = min(best, dx * dx + dy * dy)
    if best > 1e19:
        best = (path[k, 0] - x) ** 2 + (path[k, 1] - y) ** 2
    return best


@njit(cache=True)
def along(path, k, x, y):
    """Arc length [m] of the point of the path nearest to (x, y), near point k."""
    s = 0.0
    for j in range(k):
        s += math.hypot(path[j + 1, 0] - path[j, 0], path[j + 1, 1] - path[j, 1])
    if k + 1 < path.shape[0]:
        a, b = k, k + 1
    elif k > 0:
        a, b = k - 1, k
    else:
        return s
    ax = path[b, 0] - path[a, 0]
    ay = path[b, 1] - path[a, 1]
    length = math.hypot(ax, ay)
    if length < 1e-9:
        return s
    return s + ((x - path[k, 0]) * ax + (y - path[k, 1]) * ay) / length


@njit(cache=True)
def length_between(path, start, end, x, y):
    """Length [m] from the projection of (x, y) on the segment after `start` to point `end`."""
    total = 0.0
    for k in range(start, end):
        total += math.hypot(path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1])
    ax = path[start + 1, 0] - path[start, 0]
    ay = path[start + 1, 1] - path[start, 1]
    first = max(1e-9, math.hypot(ax, ay))
    return total - ((x - path[start, 0]) * ax + (y - path[start, 1]) * ay) / first


@njit(cache=True)
def held_gap(path, held, x, y):
    """Distance [m] of (x, y) to the polyline of the first `held` + 1 points."""
    best = (path[0, 0] - x) ** 2 + (path[0, 1] - y) ** 2
    for j in range(held):
        ax = path[j + 1, 0] - path[j, 0]
        ay = path[j + 1, 1] - path[j, 1]
        length = max(ax * ax + ay * ay, 1e-12)
        t = min(max(((x - path[j, 0]) * ax + (y - path[j, 1]) * ay) / length, 0.0), 1.0)
        dx = path[j, 0] + t * ax - x
        dy = path[j, 1] + t * ay - y
        best = min(best, dx * dx + dy * dy)
    return math.sqrt(best)


@njit(cache=True)
def stops_inside(pose, speed, v, w, v_acc, path, held, reach):
    """Whether braking after one period of (v, w) ends within `reach` of the held polyline."""
    s = 0.5 * (speed + v) * STEP + v * v / (2.0 * v_acc)
    yaw = pose[2] + 0.5 * w * STEP
    gap = held_gap(path, held, pose[0] + s * math.cos(yaw), pose[1] + s * math.sin(yaw))
    return gap <= reach


@njit(cache=True)
def best_twist(pose, twist, path, inside, limits, samples, horizon, scales, arc):
    """Return (v, w, cost) of the admissible twist with the smallest critics' sum.

    pose = (x, y, yaw), twist = (v, w) now; path (n, 2) from the robot on. inside = (v_limit, held,
    tolerance): a twist is admissible if v <= v_limit [m/s] and if braking after it ends within the
    tolerance [m] of the first `held` + 1 points, or no further away than now; if none is, v and w
    brake. limits = (v_max, w_max, v_acc, w_acc); samples = (nv, nw); scales = (path, goal, align,
    oscillation). `arc` (steps, 3) receives the poses of the best rollout.
    """
    v_limit, held, tolerance = inside
    v_max, w_max, v_acc, w_acc = limits
    nv, nw = samples
    steps = arc.shape[0]
    v_low = max(0.0, twist[0] - v_acc * STEP)
    v_high = max(v_low, min(v_max, v_limit, twist[0] + v_acc * STEP))
    if v_limit < v_low:
        v_high = v_low
    w_low = max(-w_max, twist[1] - w_acc * STEP)
    w_high = min(w_max, twist[1] + w_acc * STEP)
    straight = min(max(0.0, w_low), w_high)
    total = 0.0
    for j in range(path.shape[0] - 1):
        total += math.hypot(path[j + 1, 0] - path[j, 0], path[j + 1, 1] - path[j, 1])
    start = along(path, 0, pose[0], pose[1])
    wish = min(v_max * horizon, max(total - start, 1e-3))
    reach = max(tolerance, held_gap(path, held, pose[0], pose[1]))
    best = 1e20
    best_v = v_low
    best_w = straight
    trial = np.empty_like(arc)
    for a in range(nv):
        v = v_low + (v_high - v_low) * a / (nv - 1)
        for b in range(nw + 1):
            # the last sample goes straight on if that is reachable: no chatter
            w = w_low + (w_high - w_low) * b / (nw - 1) if b < nw else straight
            gap, k, yaw = rollout(pose[0], pose[1], pose[2], v, w, steps, path, 0, trial)
            reached = along(path, k, trial[steps - 1, 0], trial[steps - 1, 1])
            short = max(0.0, wish - (reached - start)) / (v_max * horizon)
            a0 = max(0, min(k, path.shape[0] - 2))
            tangent = math.atan2(path[a0 + 1, 1] - path[a0, 1], path[a0 + 1, 0] - path[a0, 0])
            turn = (yaw - tangent + math.pi) % (2.0 * math.pi) - math.pi
            cost = (
                scales[0] * gap / (DISTANCE_UNIT * DISTANCE_UNIT)
                + scales[1] * short
                + scales[2] * turn * turn
                + scales[3] * abs(w - twist[1])
            )
            if cost < best and stops_inside(pose, twist[0], v, w, v_acc, path, held, reach):
                best = cost
                best_v = v
                best_w = w
    rollout(pose[0], pose[1], pose[2], best_v, best_w, steps, path, 0, arc)
    return best_v, best_w, best
