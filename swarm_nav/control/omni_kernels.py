"""Bare numba kernel of the dynamic window for drives that move in any direction."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from swarm_nav.control.control_kernels import (
    STEP,
    advance,
    arc_length,
    gap_cost,
    held_gap,
    measure,
    turning,
)


@njit(cache=True)
def sample(low, high, index, count):
    """Return one of several even samples.

    Args:
        low: First sample.
        high: Last sample.
        index: Which one, from 0 on.
        count: Number of samples, at least 2.
    """
    return low + (high - low) * index / (count - 1)


@njit(cache=True)
def window(now, most, acceleration):
    """Return the speeds within reach of one period.

    Args:
        now: [m/s] or [rad/s].
        most: Limit of the speed, either way.
        acceleration: [m/s²] or [rad/s²].

    Returns:
        (low, high).
    """
    low = max(-most, now - acceleration * STEP)
    high = min(most, now + acceleration * STEP)
    return min(low, high), max(low, high)


@njit(cache=True)
def stop_gap(pose, now, wish, w, limits, path, held):
    """Distance [m] from the held polyline at which braking after one period of a velocity ends.

    Either component brakes by itself, as the drive does.

    Args:
        pose: (x, y, yaw) now, in map.
        now: (vx, vy, ...) [m/s] in base_footprint.
        wish: (vx, vy) [m/s] in base_footprint.
        w: [rad/s].
        limits: See `best_velocity`.
        path: (n, 2) [m] in map.
        held: See `control_kernels.held_gap`.
    """
    ahead = 0.5 * (now[0] + wish[0]) * STEP + wish[0] * abs(wish[0]) / (2.0 * limits[3])
    aside = 0.5 * (now[1] + wish[1]) * STEP + wish[1] * abs(wish[1]) / (2.0 * limits[4])
    yaw = pose[2] + 0.5 * w * STEP
    x = pose[0] + ahead * math.cos(yaw) - aside * math.sin(yaw)
    y = pose[1] + ahead * math.sin(yaw) + aside * math.cos(yaw)
    return held_gap(path, held, x, y)


@njit(cache=True)
def predict(pose, velocity, arc):
    """Fill the poses under a constant velocity.

    Args:
        pose: (x, y, yaw) now, in map.
        velocity: (vx [m/s], vy [m/s], w [rad/s]) in base_footprint.
        arc: (steps, 3) receives x, y, yaw after each step.
    """
    x, y, yaw = pose
    for s in range(arc.shape[0]):
        middle = yaw + 0.5 * velocity[2] * STEP
        x += STEP * (velocity[0] * math.cos(middle) - velocity[1] * math.sin(middle))
        y += STEP * (velocity[0] * math.sin(middle) + velocity[1] * math.cos(middle))
        yaw += velocity[2] * STEP
        arc[s, 0] = x
        arc[s, 1] = y
        arc[s, 2] = yaw


@njit(cache=True)
def straight_to(pose, aim, speed, limits):
    """Return the velocity that leads straight to a point, no faster than the drive goes that way.

    Args:
        pose: (x, y, yaw) now, in map.
        aim: (x, y) [m] in map.
        speed: [m/s] that is wished for.
        limits: (vx_max, vy_max, ...) [m/s].

    Returns:
        (vx, vy) [m/s] in base_footprint.
    """
    bearing = math.atan2(aim[1] - pose[1], aim[0] - pose[0]) - pose[2]
    vx = speed * math.cos(bearing)
    vy = speed * math.sin(bearing)
    share = min(1.0, limits[0] / max(abs(vx), 1e-9), limits[1] / max(abs(vy), 1e-9))
    return share * vx, share * vy


@njit(cache=True)
def best_velocity(pose, velocity, path, inside, limits, samples, scales, arc):
    """Find the admissible velocity with the smallest sum of critics.

    As `control_kernels.best_twist`, with a second axis. If no velocity is admissible, the robot
    brakes.

    Args:
        pose: (x, y, yaw) now, in map.
        velocity: (vx, vy, w) now, in base_footprint.
        path: (n, 2) [m] in map, from the robot on, n > 1.
        inside: (v_limit, held, tolerance, aim x, aim y): one sample leads straight to the aim.
        limits: (vx_max, vy_max, w_max, vx_acc, vy_acc, w_acc) in m and rad.
        samples: (nx, ny, nw, horizon [s]).
        scales: (path, goal, align, oscillation, facing): weights of the critics; facing [rad] is
            added to the path's direction.
        arc: (steps, 3) receives the poses of the best rollout.

    Returns:
        (vx, vy, w).
    """
    v_limit, held, tolerance, aim_x, aim_y = inside
    nx, ny, nw, horizon = samples
    steps = arc.shape[0]
    x_low, x_high = window(velocity[0], limits[0], limits[3])
    y_low, y_high = window(velocity[1], limits[1], limits[4])
    w_low, w_high = window(velocity[2], limits[2], limits[5])
    straight = min(max(0.0, w_low), w_high)
    n = path.shape[0]
    segments = np.empty((n, 6))
    measure(path, segments)
    start = arc_length(path, segments, 0, pose[0], pose[1])
    wish = min(limits[0] * horizon, max(segments[n - 1, 5] - start, 1e-3))
    reach = max(tolerance, held_gap(path, held, pose[0], pose[1]))
    direct = straight_to(pose, (aim_x, aim_y), min(v_limit, limits[0]), limits)
    headings = np.empty((steps, 2))
    track = np.empty((steps, 3))
    best = 1e20
    result = (0.0, 0.0, min(max(0.0, w_low), w_high))
    for c in range(nw + 1):
        w = straight if c == nw else sample(w_low, w_high, c, nw)
        for a in range(nx * ny + 1):
            if a == nx * ny:
                vx = min(max(direct[0], x_low), x_high)
                vy = min(max(direct[1], y_low), y_high)
            else:
                vx = sample(x_low, x_high, a // ny, nx)
                vy = sample(y_low, y_high, a % ny, ny)
            speed = math.hypot(vx, vy)
            if speed > min(v_limit, limits[0]) + 1e-9:
                continue
            end = turning(pose[2] + math.atan2(vy, vx), w, headings) - math.atan2(vy, vx)
            k = advance(pose, speed * STEP, headings, path, track)
            gone = arc_length(path, segments, k, track[steps - 1, 0], track[steps - 1, 1]) - start
            short = max(0.0, wish - gone) / (limits[0] * horizon)
            way = segments[min(k, n - 2), 4] + scales[4]
            turn = (end - way + math.pi) % (2.0 * math.pi) - math.pi
            rest = scales[1] * short + scales[2] * turn * turn + scales[3] * abs(w - velocity[2])
            if rest > best:
                continue
            cost = rest + gap_cost(track, path, segments, scales[0], best - rest + 1e-9 * best)
            if cost < best and (stop_gap(pose, velocity, (vx, vy), w, limits, path, held) <= reach):
                best = cost
                result = (vx, vy, w)
    predict(pose, result, arc)
    return result
