"""Bare numba kernels for long robots: where the polygon fits, and what a twist would touch.

A polygon is a set of discs (k, 3): x, y in base_footprint and the clearance that is needed there,
see `oblong.cover`.
Args of more than one kernel:
    clearance: (h, w) [m] from walls.
    discs: (k, 3) x, y, radius [m] in base_footprint.
    fits: (h, w) bits of the axes on which the polygon fits.
    room: [m] from which the robot can turn.
    x: [m] in map.
    y: [m] in map.
    yaw: [rad] in map.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Field, Floats, Frame, Place, sample
from swarm_nav.planning.search_kernels import MOVES

AXES = np.array([0, 1, 4, 5, 8, 9, 10, 11], np.int64)  # moves that stand for a line, both ways
OPPOSITE = np.array([2, 3, 7, 6, 14, 15, 12, 13], np.int64)  # the moves back along these
NO_AXIS = -1
ROLLOUT_STEP = 0.05  # [s] between the poses that are looked at

Bits = NDArray[np.uint8]


class Band(NamedTuple):
    """Clearances [m] between which a node may be part of a slot."""

    tight: float
    room: float


class NearObstacles(NamedTuple):
    """Obstacles near a long robot, besides walls."""

    points: NDArray[np.float64]  # (n, 2) [m] in map, of obstacles
    corners: NDArray[np.float64]  # (m, 2) [m] in base_footprint, of the robot
    gap: float  # [m] to keep from the obstacles


class TwistChange(NamedTuple):
    """A change of twist, [m/s] and [rad/s]."""

    v: float  # wanted
    w: float
    v_now: float
    w_now: float


class Ramp(NamedTuple):
    """Rates at which twists change, [m/s²], [rad/s²] and [s]."""

    v_acc: float
    w_acc: float
    period: float  # after which braking begins


@njit(cache=True)
def slack(field: Field, discs: Floats, x: float, y: float, yaw: float) -> float:
    """Return the smallest clearance [m] of discs (k, 3) at a pose, less what each needs.

    It is negative if the polygon is too near to a wall.
    """
    cos = math.cos(yaw)
    sin = math.sin(yaw)
    best = 1e9
    for k in range(discs.shape[0]):
        px = x + cos * discs[k, 0] - sin * discs[k, 1]
        py = y + sin * discs[k, 0] + cos * discs[k, 1]
        best = min(best, sample(field.distance, field.frame, px, py) - discs[k, 2])
    return best


@njit(cache=True)
def fits_along(field: Field, discs: Floats, x: float, y: float, yaw: float) -> bool:
    """Return True if the polygon fits with either end ahead.

    Args:
        yaw: [rad] of the axis, in map.
    """
    return slack(field, discs, x, y, yaw) >= 0.0 and slack(field, discs, x, y, yaw + math.pi) >= 0.0


@njit(cache=True)
def fitting_axes(
    clearance: Floats, lattice: Frame, field: Field, discs: Floats, limits: Band, fits: Bits
) -> None:
    """Fill `fits` (h, w): bit a says that the polygon fits along `AXES[a]`.

    Args:
        clearance: (h, w) [m] of the lattice; nodes outside of the limits have no bits.
        discs: (k, 3) of the polygon.
        fits: To fill.
    """
    for r in range(fits.shape[0]):
        y = lattice.origin_y + (r + 0.5) * lattice.step
        for c in range(fits.shape[1]):
            fits[r, c] = 0
            if not limits.tight <= clearance[r, c] < limits.room:
                continue
            x = lattice.origin_x + (c + 0.5) * lattice.step
            for a in range(8):
                move = MOVES[AXES[a]]
                if fits_along(field, discs, x, y, math.atan2(move[0], move[1])):
                    fits[r, c] |= 1 << a


@njit(cache=True)
def steps_to_room(
    clearance: Floats, room: float, fits: Bits, r: int, c: int, axis: int, sign: int
) -> int:
    """Return the steps along an axis from node (r, c) to the first with room to turn, or -1.

    Args:
        r: Row of the node.
        c: Column of the node.
        axis: Index into `AXES`.
        sign: 1 along the axis, -1 against it.
    """
    move = MOVES[AXES[axis]]
    steps = 0
    while True:
        r += sign * move[0]
        c += sign * move[1]
        steps += 1
        if r < 0 or c < 0 or r >= fits.shape[0] or c >= fits.shape[1]:
            return -1
        if clearance[r, c] >= room:
            return steps
        if not fits[r, c] & (1 << axis):
            return -1


@njit(cache=True)
def choose_axes(clearance: Floats, room: float, fits: Bits, axes: NDArray[np.int8]) -> None:
    """Fill `axes` (h, w) int8: the line on which a node is passed straight, `NO_AXIS` for none.

    Of the axes along which the polygon fits all the way from room to room the shortest counts.

    Args:
        axes: (h, w) receives the lines.
    """
    for r in range(fits.shape[0]):
        for c in range(fits.shape[1]):
            axes[r, c] = NO_AXIS
            if fits[r, c] == 0:
                continue
            shortest = 1e9
            for a in range(8):
                if not fits[r, c] & (1 << a):
                    continue
                ahead = steps_to_room(clearance, room, fits, r, c, a, 1)
                back = steps_to_room(clearance, room, fits, r, c, a, -1)
                move = MOVES[AXES[a]]
                length = (ahead + back) * math.hypot(move[0], move[1])
                if ahead > 0 and back > 0 and length < shortest:
                    shortest = length
                    axes[r, c] = a


@njit(cache=True)
def add_straight_moves(
    axes: NDArray[np.int8], room: NDArray[np.bool_], moves: NDArray[np.uint32]
) -> None:
    """Open the moves along the axes of slots, between these and into the room.

    Args:
        axes: (h, w) line of each slot, `NO_AXIS` elsewhere.
        room: (h, w) where the robot can turn.
        moves: (h, w) bits of the moves between such nodes; changed.
    """
    for r in range(axes.shape[0]):
        for c in range(axes.shape[1]):
            a = axes[r, c]
            if a == NO_AXIS:
                continue
            for way in range(2):
                m = AXES[a] if way == 0 else OPPOSITE[a]
                i = r + MOVES[m, 0]
                j = c + MOVES[m, 1]
                if room[i, j] or axes[i, j] == a:
                    back = OPPOSITE[a] if way == 0 else AXES[a]
                    moves[r, c] |= 1 << m
                    moves[i, j] |= 1 << back


@njit(cache=True)
def obstacle_slack(points: Floats, corners: Floats, x: float, y: float, yaw: float) -> float:
    """Return the distance [m] of points (n, 2) from a convex polygon (m, 2) at a pose; 0 inside.

    Args:
        points: (n, 2) [m] in map.
        corners: (m, 2) [m] of the polygon in base_footprint, counter-clockwise.
    """
    cos = math.cos(yaw)
    sin = math.sin(yaw)
    best = 1e9
    n = corners.shape[0]
    for k in range(points.shape[0]):
        dx = points[k, 0] - x
        dy = points[k, 1] - y
        px = cos * dx + sin * dy
        py = cos * dy - sin * dx
        is_inside = True
        nearest = 1e18
        for j in range(n):
            ax = corners[j, 0]
            ay = corners[j, 1]
            bx = corners[(j + 1) % n, 0] - ax
            by = corners[(j + 1) % n, 1] - ay
            if bx * (py - ay) - by * (px - ax) < 0.0:
                is_inside = False
            t = ((px - ax) * bx + (py - ay) * by) / (bx * bx + by * by)
            t = min(max(t, 0.0), 1.0)
            nearest = min(nearest, (ax + t * bx - px) ** 2 + (ay + t * by - py) ** 2)
        best = min(best, 0.0 if is_inside else math.sqrt(nearest))
    return best


@njit(cache=True)
def worst_slack(
    field: Field,
    discs: Floats,
    around: NearObstacles,
    pose: Place,
    twist: TwistChange,
    limits: Ramp,
) -> tuple[float, float]:
    """Return the slack [m] now and the smallest on the way: one period of a twist, then braking.

    The twist is reached linearly within the period; then it ramps down to rest. Poses are looked
    at every `ROLLOUT_STEP`.

    Args:
        discs: (k, 3) of the polygon, for walls.
    """
    points, corners, gap = around.points, around.corners, around.gap
    x, y, yaw = pose.x, pose.y, pose.yaw
    v, w, v_now, w_now = twist.v, twist.w, twist.v_now, twist.w_now
    v_acc, w_acc, period = limits.v_acc, limits.w_acc, limits.period
    now = min(slack(field, discs, x, y, yaw), obstacle_slack(points, corners, x, y, yaw) - gap)
    worst = 1e9
    time = 0.0
    end = period + max(abs(v) / v_acc, abs(w) / w_acc)
    while time < end:
        time += ROLLOUT_STEP
        share = min(1.0, time / period)
        rest = max(0.0, time - period)
        speed = v_now + (v - v_now) * share
        rate = w_now + (w - w_now) * share
        speed = math.copysign(max(0.0, abs(speed) - v_acc * rest), speed)
        rate = math.copysign(max(0.0, abs(rate) - w_acc * rest), rate)
        middle = yaw + 0.5 * rate * ROLLOUT_STEP
        x += speed * ROLLOUT_STEP * math.cos(middle)
        y += speed * ROLLOUT_STEP * math.sin(middle)
        yaw += rate * ROLLOUT_STEP
        worst = min(worst, slack(field, discs, x, y, yaw))
        worst = min(worst, obstacle_slack(points, corners, x, y, yaw) - gap)
    return now, worst
