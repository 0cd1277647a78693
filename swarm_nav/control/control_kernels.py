"""Bare numba kernels of the dynamic-window controller (Fox, Burgard, Thrun 1997; DWB's critics)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

STEP = 0.1  # [s] of a rollout
DISTANCE_UNIT = 0.05  # [m] of path distance that costs one path_distance_scale


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
def measure(path, segments):
    """Fill what the critics need of a path: per point, and per segment to the next one.

    segments (n, 6): step x, y, its squared length, its length, its yaw; arc length of the point.
    """
    n = path.shape[0]
    s = 0.0
    for j in range(n):
        segments[j, 5] = s
        if j + 1 < n:
            ax = path[j + 1, 0] - path[j, 0]
            ay = path[j + 1, 1] - path[j, 1]
            segments[j, 0] = ax
            segments[j, 1] = ay
            segments[j, 2] = ax * ax + ay * ay
            segments[j, 3] = math.hypot(ax, ay)
            segments[j, 4] = math.atan2(ay, ax)
            s += segments[j, 3]


@njit(cache=True)
def segment_gap(path, segments, k, x, y):
    """Squared distance of (x, y) to the segments on either side of point k; see `measure`."""
    best = 1e20
    for j in range(max(0, k - 1), min(path.shape[0] - 1, k + 1)):
        length = segments[j, 2]
        if length < 1e-12:
            continue
        ax = segments[j, 0]
        ay = segments[j, 1]
        t = ((x - path[j, 0]) * ax + (y - path[j, 1]) * ay) / length
        t = min(max(t, 0.0), 1.0)
        dx = path[j, 0] + t * ax - x
        dy = path[j, 1] + t * ay - y
        best = min(best, dx * dx + dy * dy)
    if best > 1e19:
        best = (path[k, 0] - x) ** 2 + (path[k, 1] - y) ** 2
    return best


@njit(cache=True)
def arc_length(path, segments, k, x, y):
    """Arc length [m] of the point of the path nearest to (x, y), near point k; see `measure`."""
    j = min(k, path.shape[0] - 2)
    if segments[j, 3] < 1e-9:
        return segments[k, 5]
    ahead = (x - path[k, 0]) * segments[j, 0] + (y - path[k, 1]) * segments[j, 1]
    return segments[k, 5] + ahead / segments[j, 3]


@njit(cache=True)
def advance(pose, pace, headings, path, track):
    """Drive `pace` [m] per step along given headings (steps, 2); return the path index reached.

    `track` (steps, 3) receives x, y and the index of the path point beside them.
    """
    x = pose[0]
    y = pose[1]
    k = 0
    for s in range(headings.shape[0]):
        x += pace * headings[s, 0]
        y += pace * headings[s, 1]
        best = (path[k, 0] - x) ** 2 + (path[k, 1] - y) ** 2
        while k + 1 < path.shape[0]:
            ahead = (path[k + 1, 0] - x) ** 2 + (path[k + 1, 1] - y) ** 2
            if ahead > best:
                break
            best = ahead
            k += 1
        track[s, 0] = x
        track[s, 1] = y
        track[s, 2] = k
    return k


@njit(cache=True)
def turning(yaw, w, headings):
    """Fill the directions (steps, 2) of a rollout that turns at rate w; return its final yaw."""
    for s in range(headings.shape[0]):
        middle = yaw + 0.5 * w * STEP
        headings[s, 0] = math.cos(middle)
        headings[s, 1] = math.sin(middle)
        yaw += w * STEP
    return yaw


@njit(cache=True)
def predict(pose, v, w, arc):
    """Fill the poses (steps, 3) under a constant twist."""
    x, y, yaw = pose
    for s in range(arc.shape[0]):
        middle = yaw + 0.5 * w * STEP
        x += v * STEP * math.cos(middle)
        y += v * STEP * math.sin(middle)
        yaw += w * STEP
        arc[s, 0] = x
        arc[s, 1] = y
        arc[s, 2] = yaw


@njit(cache=True)
def gap_cost(track, path, segments, scale, limit):
    """PathDist of a track; gives up with 1e20 once it is clear that it exceeds `limit`."""
    steps = track.shape[0]
    unit = DISTANCE_UNIT * DISTANCE_UNIT
    enough = limit * steps * unit * (1.0 + 1e-9) / scale if scale > 0.0 else 1e20
    total = 0.0
    for s in range(steps):
        total += segment_gap(path, segments, int(track[s, 2]), track[s, 0], track[s, 1])
        if total > enough:
            return 1e20
    return scale * (total / steps) / unit


@njit(cache=True)
def best_twist(pose, twist, path, inside, limits, samples, scales, arc):
    """Return (v, w, cost) of the admissible twist with the smallest critics' sum.

    pose = (x, y, yaw), twist = (v, w) now; path (n, 2) from the robot on, n > 1. inside =
    (v_limit, held, tolerance): a twist is admissible if v <= v_limit [m/s] and if braking after it
    ends within the tolerance [m] of the first `held` + 1 points, or no further away than now; if
    none is, v and w brake. limits = (v_max, w_max, v_acc, w_acc); samples = (nv, nw, horizon [s]);
    scales = (path, goal, align, oscillation). `arc` (steps, 3) receives the poses of the best
    rollout. Of equal costs the slower twist, then the first sample of w counts.

    The cheap critics come first; PathDist is only added up while the sum can still be the best.
    """
    v_limit, held, tolerance = inside
    v_max, w_max, v_acc, w_acc = limits
    nv, nw, horizon = samples
    steps = arc.shape[0]
    v_low = max(0.0, twist[0] - v_acc * STEP)
    v_high = max(v_low, min(v_max, v_limit, twist[0] + v_acc * STEP))
    if v_limit < v_low:
        v_high = v_low
    w_low = max(-w_max, twist[1] - w_acc * STEP)
    w_high = min(w_max, twist[1] + w_acc * STEP)
    straight = min(max(0.0, w_low), w_high)
    n = path.shape[0]
    segments = np.empty((n, 6))
    measure(path, segments)
    start = arc_length(path, segments, 0, pose[0], pose[1])
    wish = min(v_max * horizon, max(segments[n - 1, 5] - start, 1e-3))
    reach = max(tolerance, held_gap(path, held, pose[0], pose[1]))
    fastest = nv - 1 if v_high > v_low else 0  # of equal speeds the first sample counts
    best = 1e20
    best_index = 0
    best_v = v_low
    best_w = straight
    headings = np.empty((steps, 2))
    track = np.empty((steps, 3))
    for c in range(nw + 1):
        # the last sample goes straight on if that is reachable: no chatter; then the middle ones
        b = nw // 2 + (c // 2 if c % 2 else -c // 2) if c else nw
        w = w_low + (w_high - w_low) * b / (nw - 1) if b < nw else straight
        jerk = scales[3] * abs(w - twist[1])
        if jerk > best:
            continue
        yaw = turning(pose[2], w, headings)
        for a in range(fastest, -1, -1):
            index = a * (nw + 1) + b
            v = v_low + (v_high - v_low) * a / (nv - 1)
            k = advance(pose, v * STEP, headings, path, track)
            reached = arc_length(path, segments, k, track[steps - 1, 0], track[steps - 1, 1])
            short = max(0.0, wish - (reached - start)) / (v_max * horizon)
            turn = (yaw - segments[min(k, n - 2), 4] + math.pi) % (2.0 * math.pi) - math.pi
            rest = scales[1] * short + scales[2] * turn * turn + jerk
            if rest > best:
                continue
            gap = gap_cost(track, path, segments, scales[0], best - rest + 1e-9 * best)
            cost = gap + scales[1] * short + scales[2] * turn * turn + jerk
            is_better = cost < best or (cost == best and index < best_index)
            if is_better and stops_inside(pose, twist[0], v, w, v_acc, path, held, reach):
                best = cost
                best_index = index
                best_v = v
                best_w = w
    predict(pose, best_v, best_w, arc)
    return best_v, best_w, best
