"""Bare numba kernels of the dynamic window: trajectories are sampled, scored, and one is chosen.

Fox, Burgard, Thrun 1997, with critics of Nav2's DWB. `best_twist` rolls out a trajectory for each
twist (v, w) that the drive can reach in a tick, and takes the one with the smallest sum of

    PathDist     path_distance_scale * mean(d²) / DISTANCE_UNIT², d from its points to the path
    GoalDist     goal_distance_scale * max(0, wish - progress along the path) / (v_max * horizon)
    PathAlign    path_align_scale * e², e its heading against the path's at the end
    Oscillation  oscillation_scale * |w - present w|

among those after which braking ends inside the held tube (`stops_inside`).
Args of more than one kernel:
    arc: Receives the poses (steps, 3) of the best rollout.
    path: (n, 2) [m].
    segments: (n, 6) from `measure`.
    w: [rad/s].
    x: [m] of the place.
    y: [m] of the place.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Floats, Place

STEP = 0.1  # [s] of a rollout
RETURN = 0.999  # of its distance from the polyline, left of one that is larger than tolerated
DISTANCE_UNIT = 0.05  # [m] of path distance that costs one path_distance_scale


class Velocity(NamedTuple):
    """Speed [m/s] and turning rate [rad/s]."""

    v: float
    w: float


class StopConstraint(NamedTuple):
    """Places in which a twist must be able to stop."""

    v_limit: float  # [m/s] largest speed
    held: int  # index of the last point of the path that the robot holds
    tolerance: float  # [m] from the polyline up to that point


class Limits(NamedTuple):
    """Limits of the drive, [m/s], [rad/s], [m/s²] and [rad/s²]."""

    v_max: float
    w_max: float
    v_acc: float
    w_acc: float


class Samples(NamedTuple):
    """Twists that are tried."""

    v: int  # number of speeds
    w: int  # number of turning rates
    horizon: float  # [s] of a rollout


class Scales(NamedTuple):
    """Weights of the critics, as Nav2's DWB has them."""

    path: float  # per `DISTANCE_UNIT` of mean distance from the path
    goal: float  # for getting nowhere within the horizon
    align: float  # per squared [rad] from the path's direction at the end
    oscillation: float  # per [rad/s] of change


@njit(cache=True)
def length_between(path: Floats, start: int, end: int, x: float, y: float) -> float:
    """Length [m] of a path from the place beside a point to a later point.

    Args:
        start: Index of the point after which (x, y) is projected on the path.
        end: Index of the last point, above `start`.
    """
    total = 0.0
    for k in range(start, end):
        total += math.hypot(path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1])
    ax = path[start + 1, 0] - path[start, 0]
    ay = path[start + 1, 1] - path[start, 1]
    first = max(1e-9, math.hypot(ax, ay))
    return total - ((x - path[start, 0]) * ax + (y - path[start, 1]) * ay) / first


@njit(cache=True)
def held_gap(path: Floats, held: int, x: float, y: float) -> float:
    """Distance [m] of a place to a polyline.

    Args:
        held: The first `held` + 1 points are the polyline; with 0 it is one point.
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
def stops_inside(
    pose: Place,
    speed: float,
    v: float,
    w: float,
    v_acc: float,
    path: Floats,
    held: int,
    reach: float,
) -> bool:
    """Return True if braking after one period of (v, w) ends near the held polyline.

    The robot drives s = (speed + v) / 2 T + v² / (2 v_acc) in the direction of the middle of the
    period.

    Args:
        speed: [m/s] now.
        v: [m/s] at the end of the period.
        v_acc: [m/s²] of braking.
        path: (n, 2) [m] in map.
        held: Index of the last point that is held.
        reach: [m] from the polyline that will do.
    """
    s = 0.5 * (speed + v) * STEP + v * v / (2.0 * v_acc)
    yaw = pose.yaw + 0.5 * w * STEP
    gap = held_gap(path, held, pose.x + s * math.cos(yaw), pose.y + s * math.sin(yaw))
    return gap <= reach


@njit(cache=True)
def measure(path: Floats, segments: Floats) -> None:
    """Fill what the critics need of a path: per point, and per segment to the next one.

    Args:
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
def segment_gap(path: Floats, segments: Floats, k: int, x: float, y: float) -> float:
    """Squared distance [m²] of a place to the segments on either side of a point.

    Args:
        k: Index of the point.
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
def arc_length(path: Floats, segments: Floats, k: int, x: float, y: float) -> float:
    """Arc length [m] of the point of the path that is nearest to a place.

    Args:
        k: Index of the path point beside the place.
    """
    j = min(k, path.shape[0] - 2)
    if segments[j, 3] < 1e-9:
        return segments[k, 5]
    ahead = (x - path[k, 0]) * segments[j, 0] + (y - path[k, 1]) * segments[j, 1]
    return segments[k, 5] + ahead / segments[j, 3]


@njit(cache=True)
def advance(pose: Place, pace: float, headings: Floats, path: Floats, track: Floats) -> int:
    """Drive along given headings; return the index of the path point that is reached.

    Args:
        pace: [m] per step.
        headings: (steps, 2) unit vectors.
        path: (n, 2) [m] in map.
        track: (steps, 3) receives x, y [m] and the index of the path point beside them.
    """
    x = pose.x
    y = pose.y
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
def turning(yaw: float, w: float, headings: Floats) -> float:
    """Fill the directions of a rollout that turns at a constant rate.

    Args:
        yaw: [rad] where it begins.
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
def predict(pose: Place, v: float, w: float, arc: Floats) -> None:
    """Fill the poses `arc` (steps, 3) under a constant twist.

    Args:
        v: [m/s]
        w: [rad/s]
        arc: (steps, 3) receives x, y [m], yaw [rad].
    """
    x, y, yaw = pose.x, pose.y, pose.yaw
    for s in range(arc.shape[0]):
        middle = yaw + 0.5 * w * STEP
        x += v * STEP * math.cos(middle)
        y += v * STEP * math.sin(middle)
        yaw += w * STEP
        arc[s, 0] = x
        arc[s, 1] = y
        arc[s, 2] = yaw


@njit(cache=True)
def gap_cost(track: Floats, path: Floats, segments: Floats, scale: float, limit: float) -> float:
    """Critic PathDist: mean squared distance of a track to the path, in `DISTANCE_UNIT`².

    Args:
        track: (steps, 3) from `advance`.
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
def best_twist(
    pose: Place,
    twist: Velocity,
    path: Floats,
    inside: StopConstraint,
    limits: Limits,
    samples: Samples,
    scales: Scales,
    arc: Floats,
) -> tuple[float, float, float]:
    """Return (v, w, cost) of the admissible twist with the smallest critics' sum.

    A twist is admissible if v <= v_limit and if braking after it ends within the tolerance of the
    held points, or nearer to them than now, for the smallest v no farther; if none is, v and w
    brake. Of equal costs the slower twist, then the first sample of w counts. The cheap critics
    come first; PathDist is only added up while the sum can still be the best.

    Args:
        path: (n, 2) [m] in map from the robot on, n > 1.
    """
    v_limit, held, tolerance = inside.v_limit, inside.held, inside.tolerance
    v_max, w_max, v_acc, w_acc = limits.v_max, limits.w_max, limits.v_acc, limits.w_acc
    nv, nw, horizon = samples.v, samples.w, samples.horizon
    steps = arc.shape[0]
    v_low = max(0.0, twist.v - v_acc * STEP)
    v_high = max(v_low, min(v_max, v_limit, twist.v + v_acc * STEP))
    if v_limit < v_low:
        v_high = v_low
    w_low = max(-w_max, twist.w - w_acc * STEP)
    w_high = min(w_max, twist.w + w_acc * STEP)
    straight = min(max(0.0, w_low), w_high)
    n = path.shape[0]
    segments = np.empty((n, 6))
    measure(path, segments)
    start = arc_length(path, segments, 0, pose.x, pose.y)
    wish = min(v_max * horizon, max(segments[n - 1, 5] - start, 1e-3))
    gap_now = held_gap(path, held, pose.x, pose.y)
    no_farther, nearer = max(tolerance, gap_now), max(tolerance, RETURN * gap_now)
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
        jerk = scales.oscillation * abs(w - twist.w)
        if jerk > best:
            continue
        yaw = turning(pose.yaw, w, headings)
        for a in range(fastest, -1, -1):
            index = a * (nw + 1) + b
            v = v_low + (v_high - v_low) * a / (nv - 1)
            k = advance(pose, v * STEP, headings, path, track)
            reached = arc_length(path, segments, k, track[steps - 1, 0], track[steps - 1, 1])
            short = max(0.0, wish - (reached - start)) / (v_max * horizon)
            turn = (yaw - segments[min(k, n - 2), 4] + math.pi) % (2.0 * math.pi) - math.pi
            rest = scales.goal * short + scales.align * turn * turn + jerk
            if rest > best:
                continue
            gap = gap_cost(track, path, segments, scales.path, best - rest + 1e-9 * best)
            cost = gap + scales.goal * short + scales.align * turn * turn + jerk
            is_better = cost < best or (cost == best and index < best_index)
            reach = nearer if v > v_low else no_farther
            if is_better and stops_inside(pose, twist.v, v, w, v_acc, path, held, reach):
                best = cost
                best_index = index
                best_v = v
                best_w = w
    predict(pose, best_v, best_w, arc)
    return best_v, best_w, best


@njit(cache=True)
def choose_twist(
    pose: tuple[float, float, float],
    twist: tuple[float, float],
    path: Floats,
    inside: tuple[float, int, float],
    limits: tuple[float, float, float, float],
    samples: tuple[int, int, float],
    scales: tuple[float, float, float, float],
    arc: Floats,
) -> tuple[float, float, float]:
    """Return `best_twist` of plain tuples with the fields of its arguments.

    For calls from Python, once per tick and robot: numba's dispatcher takes 0.1 µs for a plain
    tuple and 0.7 to 1 µs for a `NamedTuple`.

    Args:
        pose: (x, y, yaw) [m], [rad] in map.
        twist: Fields of `Velocity`, the present one.
        path: (n, 2) [m] in map from the robot on, n > 1.
        inside: Fields of `StopConstraint`: where the robot must be able to stop.
        limits: Fields of `Limits`: those of the drive.
        samples: Fields of `Samples`: twists that are tried.
        scales: Fields of `Scales`: weights of the critics.

    Returns:
        (v [m/s], w [rad/s], cost).
    """
    return best_twist(
        Place(*pose),
        Velocity(*twist),
        path,
        StopConstraint(*inside),
        Limits(*limits),
        Samples(*samples),
        Scales(*scales),
        arc,
    )
