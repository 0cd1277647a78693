"""Bare numba kernel of the dynamic window for drives that move in any direction.

Args of more than one kernel:
    arc: Receives the poses (steps, 3) of the best rollout.
    path: (n, 2) [m] in map from the robot on, n > 1.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from swarm_common.process.numba_compat import njit
from swarm_nav.control.dwa_kernels import (
    RETURN,
    STEP,
    advance,
    arc_length,
    gap_cost,
    held_gap,
    measure,
    turning,
)
from swarm_nav.planning.distance_kernels import Floats, Place


class PlanarVelocity(NamedTuple):
    """Velocity in base_footprint, [m/s] and [rad/s]."""

    vx: float
    vy: float
    w: float


class InsideTowards(NamedTuple):
    """Limits as in `dwa_kernels.StopConstraint`, and a point that one sample leads straight to."""

    v_limit: float  # [m/s]
    held: int
    tolerance: float  # [m]
    aim_x: float  # [m] in map
    aim_y: float


class PlanarLimits(NamedTuple):
    """Limits of the drive, [m/s], [rad/s], [m/s²] and [rad/s²]."""

    vx_max: float
    vy_max: float
    w_max: float
    vx_acc: float
    vy_acc: float
    w_acc: float


class PlanarSamples(NamedTuple):
    """Velocities that are tried."""

    x: int  # number of speeds ahead
    y: int  # number of speeds sideways
    w: int  # number of turning rates
    horizon: float  # [s] of a rollout


class PlanarScales(NamedTuple):
    """Weights as in `dwa_kernels.Scales`; the facing [rad] is added to the path's direction."""

    path: float
    goal: float
    align: float
    oscillation: float
    facing: float


@njit(cache=True)
def sample(low: float, high: float, index: int, count: int) -> float:
    """Return one of several even samples.

    Args:
        low: First sample.
        high: Last sample.
        index: Index of the sample, from 0 on.
        count: Number of samples, at least 2.
    """
    return low + (high - low) * index / (count - 1)


@njit(cache=True)
def window(now: float, most: float, acceleration: float) -> tuple[float, float]:
    """Return the speeds within reach of one period.

    Args:
        now: [m/s] or [rad/s].
        most: Limit of the speed, either way, in the same unit.
        acceleration: [m/s²] or [rad/s²].

    Returns:
        (low, high).
    """
    low = max(-most, now - acceleration * STEP)
    high = min(most, now + acceleration * STEP)
    return min(low, high), max(low, high)


@njit(cache=True)
def stop_gap(
    pose: Place,
    now: PlanarVelocity,
    vx: float,
    vy: float,
    w: float,
    limits: PlanarLimits,
    path: Floats,
    held: int,
) -> float:
    """Return the distance [m] from the held polyline at which braking after one period ends.

    Either component brakes by itself, as the drive does: s = (now + v) / 2 T + v |v| / (2 acc).

    Args:
        vx: [m/s] at the end of the period, in base_footprint.
        vy: [m/s] likewise.
        w: [rad/s].
        path: (n, 2) [m] in map.
        held: Index of the last point that is held.
    """
    ahead = 0.5 * (now.vx + vx) * STEP + vx * abs(vx) / (2.0 * limits.vx_acc)
    aside = 0.5 * (now.vy + vy) * STEP + vy * abs(vy) / (2.0 * limits.vy_acc)
    yaw = pose.yaw + 0.5 * w * STEP
    x = pose.x + ahead * math.cos(yaw) - aside * math.sin(yaw)
    y = pose.y + ahead * math.sin(yaw) + aside * math.cos(yaw)
    return held_gap(path, held, x, y)


@njit(cache=True)
def predict(pose: Place, vx: float, vy: float, w: float, arc: Floats) -> None:
    """Fill the poses `arc` (steps, 3) under a constant velocity in base_footprint.

    Args:
        vx: [m/s]
        vy: [m/s]
        w: [rad/s]
        arc: (steps, 3) receives x, y [m], yaw [rad].
    """
    x, y, yaw = pose.x, pose.y, pose.yaw
    for s in range(arc.shape[0]):
        middle = yaw + 0.5 * w * STEP
        x += STEP * (vx * math.cos(middle) - vy * math.sin(middle))
        y += STEP * (vx * math.sin(middle) + vy * math.cos(middle))
        yaw += w * STEP
        arc[s, 0] = x
        arc[s, 1] = y
        arc[s, 2] = yaw


@njit(cache=True)
def straight_to(
    pose: Place, aim_x: float, aim_y: float, speed: float, limits: PlanarLimits
) -> tuple[float, float]:
    """Return (vx, vy) that leads straight to a point, no faster than the drive goes that way.

    Args:
        aim_x: [m] in map.
        aim_y: [m] in map.
        speed: [m/s] at most.
    """
    bearing = math.atan2(aim_y - pose.y, aim_x - pose.x) - pose.yaw
    vx = speed * math.cos(bearing)
    vy = speed * math.sin(bearing)
    share = min(1.0, limits.vx_max / max(abs(vx), 1e-9), limits.vy_max / max(abs(vy), 1e-9))
    return share * vx, share * vy


@njit(cache=True)
def best_velocity(
    pose: Place,
    velocity: PlanarVelocity,
    path: Floats,
    inside: InsideTowards,
    limits: PlanarLimits,
    samples: PlanarSamples,
    scales: PlanarScales,
    arc: Floats,
) -> tuple[float, float, float]:
    """Return (vx, vy, w) of the admissible velocity with the smallest critics' sum.

    As `dwa_kernels.best_twist`, with a second axis. If no velocity is admissible, the robot
    brakes.
    """
    v_limit, held = inside.v_limit, inside.held
    nx, ny, nw, horizon = samples.x, samples.y, samples.w, samples.horizon
    steps = arc.shape[0]
    x_low, x_high = window(velocity.vx, limits.vx_max, limits.vx_acc)
    y_low, y_high = window(velocity.vy, limits.vy_max, limits.vy_acc)
    w_low, w_high = window(velocity.w, limits.w_max, limits.w_acc)
    straight = min(max(0.0, w_low), w_high)
    n = path.shape[0]
    segments = np.empty((n, 6))
    measure(path, segments)
    start = arc_length(path, segments, 0, pose.x, pose.y)
    wish = min(limits.vx_max * horizon, max(segments[n - 1, 5] - start, 1e-3))
    reach = max(inside.tolerance, RETURN * held_gap(path, held, pose.x, pose.y))
    fastest = min(v_limit, limits.vx_max)
    direct = straight_to(pose, inside.aim_x, inside.aim_y, fastest, limits)
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
            if speed > fastest + 1e-9:
                continue
            end = turning(pose.yaw + math.atan2(vy, vx), w, headings) - math.atan2(vy, vx)
            k = advance(pose, speed * STEP, headings, path, track)
            gone = arc_length(path, segments, k, track[steps - 1, 0], track[steps - 1, 1]) - start
            short = max(0.0, wish - gone) / (limits.vx_max * horizon)
            way = segments[min(k, n - 2), 4] + scales.facing
            turn = (end - way + math.pi) % (2.0 * math.pi) - math.pi
            rest = scales.goal * short + scales.align * turn * turn
            rest += scales.oscillation * abs(w - velocity.w)
            if rest > best:
                continue
            cost = rest + gap_cost(track, path, segments, scales.path, best - rest + 1e-9 * best)
            if cost < best and stop_gap(pose, velocity, vx, vy, w, limits, path, held) <= reach:
                best = cost
                result = (vx, vy, w)
    predict(pose, result[0], result[1], result[2], arc)
    return result


@njit(cache=True)
def choose_velocity(
    pose: tuple[float, float, float],
    velocity: tuple[float, float, float],
    path: Floats,
    inside: tuple[float, int, float, float, float],
    limits: tuple[float, float, float, float, float, float],
    samples: tuple[int, int, int, float],
    scales: tuple[float, float, float, float, float],
    arc: Floats,
) -> tuple[float, float, float]:
    """Return `best_velocity` of plain tuples; see `dwa_kernels.choose_twist`.

    Args:
        pose: (x, y, yaw) [m], [rad] in map.
        velocity: Fields of `PlanarVelocity`, the present one.
        inside: Fields of `InsideTowards`: where the robot must be able to stop, and its aim.
        limits: Fields of `PlanarLimits`: those of the drive.
        samples: Fields of `PlanarSamples`: velocities that are tried.
        scales: Fields of `PlanarScales`: weights of the critics.

    Returns:
        (vx [m/s], vy [m/s], w [rad/s]).
    """
    return best_velocity(
        Place(*pose),
        PlanarVelocity(*velocity),
        path,
        InsideTowards(*inside),
        PlanarLimits(*limits),
        PlanarSamples(*samples),
        PlanarScales(*scales),
        arc,
    )
