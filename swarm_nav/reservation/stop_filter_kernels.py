"""Bare numba kernels of the stop filter: where does a twist lead if the robot brakes after it?"""

from __future__ import annotations

import math

from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Floats, Frame, sample
from swarm_nav.reservation.tube_kernels import nearest_on

STEP = 0.05  # [s] between the poses of a rollout that are checked
RETURN = 0.999  # of its distance from the held space, left of one that is larger than tolerated
LONGEST = 400  # steps of a rollout
SHARES = (1.0, 0.5, 0.25)  # of a twist that are tried before the robot brakes


@njit(cache=True)
def towards(now: float, wish: float, most: float) -> float:
    """Return a speed that changes by at most `most` towards another one.

    Args:
        now: [m/s] or [rad/s].
        wish: Likewise.
        most: Likewise, not negative.
    """
    return min(max(wish, now - most), now + most)


@njit(cache=True)
def gap_to_line(points: Floats, first: int, last: int, x: float, y: float) -> float:
    """Return the distance [m] of a place to the polyline between two points of a path.

    Args:
        points: (n, 2) [m] in map.
        first: Index where the polyline begins.
        last: Index where it ends; with `first` it is one point.
        x: [m] in map.
        y: [m] in map.
    """
    near_x, near_y = nearest_on(points, first, last, x, y)
    return math.hypot(near_x - x, near_y - y)


@njit(cache=True)
def room(field: Floats, frame: Frame, hits: Floats, spare: float, x: float, y: float) -> float:
    """Return the distance [m] of a place to mapped walls, or to LiDAR hits less `spare`.

    Args:
        field: (h, w) [m], distances to walls.
        frame: Of the field.
        hits: (k, 2) [m] in map.
        spare: [m] by which hits must be farther than walls.
        x: [m] in map.
        y: [m] in map.
    """
    best = 1e20
    for k in range(hits.shape[0]):
        best = min(best, (hits[k, 0] - x) ** 2 + (hits[k, 1] - y) ** 2)
    return min(sample(field, frame, x, y), math.sqrt(best) - spare)


@njit(cache=True)
def is_admitted(pose, now, wish, drive, held, around):
    """Whether the robot stays in its held space and off walls if it brakes after a twist.

    Within the period each speed changes towards the wish as fast as the drive can; then each goes
    to zero. The whole way is checked. A robot that is too far off, or too near to a wall, may not
    get farther off or nearer, and must end nearer to its held space.

    Args:
        pose: (x, y, yaw) [m], [rad] in map.
        now: (vx, vy, w) [m/s], [rad/s] in base_footprint.
        wish: Likewise.
        drive: (x, y [m/s²], w [rad/s²]) accelerations, and the period [s] of the wish.
        held: Path (n, 2) [m] in map, indices of its first and last held point, and the tolerated
            distance [m].
        around: Field, frame, hits and spare of `room`, and the least room [m].
    """
    x, y, yaw = pose
    vx, vy, w = now
    goal_x, goal_y, goal_w = wish
    x_acc, y_acc, w_acc, period = drive
    points, first, last, tolerance = held
    field, frame, hits, spare, floor = around
    gap_now = gap_to_line(points, first, last, x, y)
    farthest = max(tolerance, gap_now) + 1e-9
    nearest = min(floor, room(field, frame, hits, spare, x, y) - 1e-9)
    gap = gap_now
    for k in range(LONGEST):
        if k * STEP >= period - 1e-9:
            goal_x = goal_y = goal_w = 0.0
            if vx == 0.0 and vy == 0.0:
                break
        next_x = towards(vx, goal_x, x_acc * STEP)
        next_y = towards(vy, goal_y, y_acc * STEP)
        next_w = towards(w, goal_w, w_acc * STEP)
        middle = yaw + 0.25 * (w + next_w) * STEP
        ahead = 0.5 * (vx + next_x) * STEP
        aside = 0.5 * (vy + next_y) * STEP
        x += ahead * math.cos(middle) - aside * math.sin(middle)
        y += ahead * math.sin(middle) + aside * math.cos(middle)
        yaw += 0.5 * (w + next_w) * STEP
        vx, vy, w = next_x, next_y, next_w
        gap = gap_to_line(points, first, last, x, y)
        if gap > farthest or room(field, frame, hits, spare, x, y) < nearest:
            return False
    return gap <= max(tolerance, RETURN * gap_now)


@njit(cache=True)
def largest_share(pose, now, wish, drive, held, around):
    """Return the largest of `SHARES` of a twist that is admitted, 0.0 if none is.

    Args:
        pose: Arguments of `is_admitted`, as plain tuples.
        now: Likewise.
        wish: Likewise.
        drive: Likewise.
        held: Likewise.
        around: Likewise.
    """
    for share in SHARES:
        if is_admitted(
            pose, now, (share * wish[0], share * wish[1], share * wish[2]), drive, held, around
        ):
            return share
    return 0.0
