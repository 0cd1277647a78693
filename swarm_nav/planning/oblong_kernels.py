"""Bare numba kernels for long robots: where the polygon fits, and what a twist would touch.

A polygon is a set of discs (k, 3): x, y in base_footprint and the clearance that is needed there,
see `oblong.cover`. field = (distance, frame): distances to walls and their (origin_x, origin_y,
resolution).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from swarm_nav.planning.distance_kernels import sample
from swarm_nav.planning.search_kernels import MOVES

AXES = np.array([0, 1, 4, 5, 8, 9, 10, 11], np.int64)  # moves that stand for a line, both ways
OPPOSITE = np.array([2, 3, 7, 6, 14, 15, 12, 13], np.int64)  # the moves back along these
NO_AXIS = -1
ROLLOUT_STEP = 0.05  # [s] between the poses that are looked at


@njit(cache=True)
def slack(field, discs, x, y, yaw):
    """Smallest clearance of the polygon at a pose minus the required one; negative: too near."""
    distance, frame = field
    cos = math.cos(yaw)
    sin = math.sin(yaw)
    best = 1e9
    for k in range(discs.shape[0]):
        px = x + cos * discs[k, 0] - sin * discs[k, 1]
        py = y + sin * discs[k, 0] + cos * discs[k, 1]
        best = min(best, sample(distance, frame[0], frame[1], frame[2], px, py) - discs[k, 2])
    return best


@njit(cache=True)
def fits_along(field, discs, x, y, yaw):
    """Whether the polygon fits with either end ahead."""
    return slack(field, discs, x, y, yaw) >= 0.0 and slack(field, discs, x, y, yaw + math.pi) >= 0.0


@njit(cache=True)
def fitting_axes(clearance, lattice, field, discs, limits, fits):
    """Fill `fits` (h, w) uint8: bit a says that the polygon fits along `AXES[a]`.

    lattice = (origin_x, origin_y, step); limits = (tight, room): only nodes with a clearance
    between the two are looked at.
    """
    for r in range(fits.shape[0]):
        y = lattice[1] + (r + 0.5) * lattice[2]
        for c in range(fits.shape[1]):
            fits[r, c] = 0
            if not limits[0] <= clearance[r, c] < limits[1]:
                continue
            x = lattice[0] + (c + 0.5) * lattice[2]
            for a in range(8):
                move = MOVES[AXES[a]]
                if fits_along(field, discs, x, y, math.atan2(move[0], move[1])):
                    fits[r, c] |= 1 << a


@njit(cache=True)
def steps_to_room(clearance, room, fits, node, axis, sign):
    """Steps along an axis from a node to the first one with room to turn, -1 if there is none."""
    r, c = node
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
def choose_axes(clearance, room, fits, axes):
    """Fill `axes` (h, w) int8: the line on which a node is passed straight, `NO_AXIS` for none.

    Of the axes along which the polygon fits all the way from room to room the shortest counts.
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
                ahead = steps_to_room(clearance, room, fits, (r, c), a, 1)
                back = steps_to_room(clearance, room, fits, (r, c), a, -1)
                move = MOVES[AXES[a]]
                length = (ahead + back) * math.hypot(move[0], move[1])
                if ahead > 0 and back > 0 and length < shortest:
                    shortest = length
                    axes[r, c] = a


@njit(cache=True)
def add_straight_moves(base, axes, room, moves):
    """Open the moves (h, w) uint16 along the axes of slots, between these and into the room.

    `room` (h, w) bool says where the robot can turn; `moves` holds the moves between such nodes.
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
def obstacle_slack(points, corners, x, y, yaw):
    """Smallest distance of points (n, 2) from a convex polygon at a pose; 0 inside."""
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
def worst_slack(field, discs, around, pose, twist, limits):
    """Return (slack now, smallest slack on the way): one period of a twist, then braking.

    around = (obstacles (n, 2), corners (m, 2), gap [m] to keep from obstacles). twist = (v, w,
    v_now, w_now); limits = (v_acc, w_acc, period).
    """
    points, corners, gap = around
    x, y, yaw = pose
    v, w, v_now, w_now = twist
    v_acc, w_acc, period = limits
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
