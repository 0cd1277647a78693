"""Bare numba kernels of the dynamic-window controller (Fox, Burgard, Thrun 1997; DWB's critics)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

STEP = 0.1  # [s] of a rollout
DISTANCE_UNIT = 0.05  # [m] of path distance that costs one path_distance_scale


@njit(cache=True)
def length_between(path, start, end, x, y):
    """Length [m] of a path from the place beside a point to a later point.

    Args:
        path: (n, 2) [m].
        start: Index of the point after which (x, y) is projected on the path.
        end: Index of the last point, above `start`.
        x: [m] of the place.
        y: [m] of the place.
    """
    total = 0.0
    for k in range(start, end):
        total += math.hypot(path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1])
    ax = path[start + 1, 0] - path[start, 0]
    ay = path[start + 1, 1] - path[start, 1]
    first = max(1e-9, math.hypot(ax, ay))
    return total - ((x - path[start, 0]) * ax + (y - path[start, 1]) * ay) / first


@njit(cache=True)
def held_gap(path, held, x, y):
    """Distance [m] of a place to a polyline.

    Args:
        path: (n, 2) [m].
        held: The first `held` + 1 points are the polyline; with 0 it is one point.
        x: [m] of the place.
        y: [m] of the place.
    """
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
    """Whether braking after one period of a twist ends near the held polyline.

    The stop is (speed + v) / 2 * STEP + v² / (2 v_acc) ahead, in the direction of half the turn.

    Args:
        pose: (x, y, yaw) now, in map.
        speed: [m/s] now.
        v: [m/s] of the twist.
        w: [rad/s] of the twist.
        v_acc: [m/s²] with which the drive brakes.
        path: (n, 2) [m] in map.
        held: See `held_gap`.
        reach: [m] from the polyline.
    """
    s = 0.5 * (speed + v) * STEP + v * v / (2.0 * v_acc)
    yaw = pose[2] + 0.5 * w * STEP
    gap = held_gap(path, held, pose[0] + s * math.cos(yaw), pose[1] + s * math.sin(yaw))
    return gap <= reach


@njit(cache=True)
def measure(path, segments):
    """Fill what the critics need of a path: per point, and per segment to the next one.

    Args:
        path: (n, 2) [m].
        segments: (n, 6), written: step x, y, its squared length, its length, its yaw; arc length
            of the point. Those of the last point have an arc length only.
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
    """Squared distance [m²] of a place to the segments on either side of a point.

    Args:
        path: (n, 2) [m].
        segments: (n, 6) from `measure`.
        k: Index of the point.
        x: [m] of the place.
        y: [m] of the place.
    """
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
    """Arc length [m] of the point of the path that is nearest to a place.

    Args:
        path: (n, 2) [m].
        segments: (n, 6) from `measure`.
        k: Index of the path point beside the place.
        x: [m] of the place.
        y: [m] of the place.
    """
    j = min(k, path.shape[0] - 2)
    if segments[j, 3] < 1e-9:
        return segments[k, 5]
    ahead = (x - path[k, 0]) * segments[j, 0] + (y - path[k, 1]) * segments[j, 1]
    return segments[k, 5] + ahead / segments[j, 3]


@njit(cache=True)
def advance(pose, pace, headings, path, track):
    """Drive along given headings.

    Args:
        pose: (x, y, yaw) where the rollout begins, in map.
        pace: [m] per step.
        headings: (steps, 2) unit directions.
        path: (n, 2) [m] in map.
        track: (steps, 3) receives x, y and the index of the path point beside them.

    Returns:
        The index of the path point reached.
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
    """Fill the directions of a rollout that turns at a constant rate.

    Args:
        yaw: [rad] where it begins.
        w: [rad/s].
        headings: (steps, 2) receives unit directions, each in the middle of its step.

    Returns:
        The final yaw [rad].
    """
    for s in range(headings.shape[0]):
        middle = yaw + 0.5 * w * STEP
        headings[s, 0] = math.cos(middle)
        headings[s, 1] = math.sin(middle)
        yaw += w * STEP
    return yaw


@njit(cache=True)
def predict(pose, v, w, arc):
    """Fill the poses under a constant twist.

    Args:
        pose: (x, y, yaw) now, in map.
        v: [m/s].
        w: [rad/s].
        arc: (steps, 3) receives x, y, yaw after each step of `STEP`.
    """
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
    """Critic PathDist: mean squared distance of a track to the path, in `DISTANCE_UNIT`².

    Args:
        track: (steps, 3) from `advance`.
        path: (n, 2) [m].
        segments: (n, 6) from `measure`.
        scale: Weight of the critic.
        limit: Cost above which the sum is given up.

    Returns:
        The cost; 1e20 once it is clear that it exceeds the limit.
    """
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
    """Find the admissible twist with the smallest sum of critics (Fox, Burgard, Thrun 1997).

    A twist is admissible if v <= v_limit and if braking after it ends within the tolerance of the
    held part, or no further away than now; if none is, v and w brake. Of equal costs the slower
    twist counts, then the first sample of w. The cheap critics come first; PathDist is only added
    up while the sum can still be the best.

    Args:
        pose: (x, y, yaw) now, in map.
        twist: (v [m/s], w [rad/s]) now.
        path: (n, 2) [m] in map, from the robot on, n > 1.
        inside: (v_limit [m/s], held, tolerance [m]): the first `held` + 1 points are held.
        limits: (v_max, w_max, v_acc, w_acc) in m and rad.
        samples: (nv, nw, horizon [s]).
        scales: (path, goal, align, oscillation): weights of the critics.
        arc: (steps, 3) receives the poses of the best rollout.

    Returns:
        (v, w, cost).
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
