"""Bare numba kernels of the stop filter: where does a twist lead if the robot brakes after it?

Args of more than one kernel:
    drive: See `is_admitted`.
    now: See `is_admitted`.
    points: Path (n, 2) [m] in map.
    pose: See `is_admitted`.
    x: [m] in map.
    y: [m] in map.
"""

from __future__ import annotations

import math

from swarm_common.process.numba_compat import njit
from swarm_nav.planning.distance_kernels import Floats, Frame, sample
from swarm_nav.reservation.tube_kernels import nearest_on

STEP = 0.05  # [s] between the poses of a rollout that are checked
RETURN = 0.999  # of its distance from the held space, left of one that is larger than tolerated
LONGEST = 400  # steps of a rollout
SHARES = (0.5, 0.25)  # of a twist that are tried before the robot brakes
SNAP = 1.0 - 1e-6  # of a segment, from which on its end is meant


@njit(cache=True)
def towards(now: float, wish: float, most: float) -> float:
    """Return a speed that changes by at most `most` towards another one.

    Args:
        now: Present speed, [m/s] or [rad/s].
        wish: Wanted speed, [m/s] or [rad/s].
        most: Largest change, [m/s] or [rad/s], not negative.
    """
    return min(max(wish, now - most), now + most)


@njit(cache=True)
def gap_to_line(points: Floats, first: int, last: int, x: float, y: float) -> float:
    """Return the distance [m] of a place to the polyline between two points of a path.

    Args:
        points: (n, 2) [m] in map.
        first: Index where the polyline begins.
        last: Index where it ends; with `first` it is one point.
    """
    near_x, near_y = nearest_on(points, first, last, x, y)
    return math.hypot(near_x - x, near_y - y)


@njit(cache=True)
def room(field: Floats, frame: Frame, hits: Floats, spare: float, x: float, y: float) -> float:
    """Return the distance [m] of a place to mapped walls, or to LiDAR hits less `spare`.

    Args:
        field: (h, w) [m], distances to walls.
        hits: (k, 2) [m] in map.
        spare: [m] by which hits must be farther than walls.
    """
    best = 1e20
    for k in range(hits.shape[0]):
        best = min(best, (hits[k, 0] - x) ** 2 + (hits[k, 1] - y) ** 2)
    return min(sample(field, frame, x, y), math.sqrt(best) - spare)


@njit(cache=True)
def advance(x, y, yaw, vx, vy, w, goal, drive):
    """Return pose and twist after `STEP`, in which each speed changes towards its goal.

    Args:
        x: [m] in map, the pose.
        y: [m] likewise.
        yaw: [rad] likewise.
        vx: [m/s] in base_footprint, the twist.
        vy: [m/s] likewise.
        w: [rad/s] likewise.
        goal: (vx, vy, w), likewise.
        drive: (x, y [m/s²], w [rad/s²]) accelerations.
    """
    next_x = towards(vx, goal[0], drive[0] * STEP)
    next_y = towards(vy, goal[1], drive[1] * STEP)
    next_w = towards(w, goal[2], drive[2] * STEP)
    middle = yaw + 0.25 * (w + next_w) * STEP
    ahead = 0.5 * (vx + next_x) * STEP
    aside = 0.5 * (vy + next_y) * STEP
    x += ahead * math.cos(middle) - aside * math.sin(middle)
    y += ahead * math.sin(middle) + aside * math.cos(middle)
    return x, y, yaw + 0.5 * (w + next_w) * STEP, next_x, next_y, next_w


@njit(cache=True)
def is_admitted(pose, now, wish, drive, held, around):
    """Whether the robot stays in its held space and off walls if it brakes after a twist.

    Within the period each speed changes towards the wish as fast as the drive can; then each goes
    to zero. The whole way is checked. A robot that is too far off, or too near to a wall, may not
    get farther off or nearer, and must end nearer to its held space.

    Args:
        pose: (x, y, yaw) [m], [rad] in map.
        now: (vx, vy, w) [m/s], [rad/s] in base_footprint.
        wish: Wanted (vx, vy, w) [m/s], [rad/s] in base_footprint.
        drive: (x, y [m/s²], w [rad/s²]) accelerations, and the period [s] of the wish.
        held: Path (n, 2) [m] in map, indices of its first and last held point, and the tolerated
            distance [m].
        around: Field, frame, hits and spare of `room`, and the least room [m].
    """
    x, y, yaw = pose
    vx, vy, w = now
    period = drive[3]
    points, first, last, tolerance = held
    field, frame, hits, spare, floor = around
    gap_now = gap_to_line(points, first, last, x, y)
    farthest = max(tolerance, gap_now) + 1e-9
    nearest = min(floor, room(field, frame, hits, spare, x, y) - 1e-9)
    gap = gap_now
    goal = wish
    for k in range(LONGEST):
        if k * STEP >= period - 1e-9:
            goal = (0.0, 0.0, 0.0)
            if vx == 0.0 and vy == 0.0:
                break
        x, y, yaw, vx, vy, w = advance(x, y, yaw, vx, vy, w, goal, drive)
        gap = gap_to_line(points, first, last, x, y)
        if gap > farthest or room(field, frame, hits, spare, x, y) < nearest:
            return False
    return gap <= max(tolerance, RETURN * gap_now)


@njit(cache=True)
def brakes_within(pose, now, drive, points, first, last, farthest):
    """Whether the robot, if it brakes now, is and stays in a part of its held space.

    Args:
        first: Index of the first point of the part.
        last: Index of the last one.
        farthest: [m] from it that counts as in it.
    """
    x, y, yaw = pose
    vx, vy, w = now
    for _ in range(LONGEST):
        if gap_to_line(points, first, last, x, y) > farthest + 1e-9:
            return False
        if vx == 0.0 and vy == 0.0:
            break
        x, y, yaw, vx, vy, w = advance(x, y, yaw, vx, vy, w, (0.0, 0.0, 0.0), drive)
    return True


@njit(cache=True)
def last_to_keep(pose, now, drive, held, last):
    """Return the first point from `last` on up to which the robot can brake, or the last held one.

    Args:
        held: See `is_admitted`.
        last: Index of the last point that is to stay held.
    """
    points, first, stop, tolerance = held
    farthest = max(tolerance, gap_to_line(points, first, stop, pose[0], pose[1]))
    while last < stop and not brakes_within(pose, now, drive, points, first, last, farthest):
        last += 1
    return last


@njit(cache=True)
def tail_on(points, tail, ahead, x, y):
    """Return where on the held path the robot is.

    Args:
        tail: Index of its first held point.
        ahead: Index of a held point that the robot has not passed yet, not before `tail`.
        x: [m] in map, of the robot.
        y: [m] likewise.

    Returns:
        Index of the last point before that place, or at it, and the place (x, y).
    """
    for k in range(ahead - 1, tail - 1, -1):
        ax = points[k + 1, 0] - points[k, 0]
        ay = points[k + 1, 1] - points[k, 1]
        share = ((x - points[k, 0]) * ax + (y - points[k, 1]) * ay) / max(ax * ax + ay * ay, 1e-12)
        if share > SNAP:
            return k + 1, points[k + 1, 0], points[k + 1, 1]
        if share > 0.0:
            return k, points[k, 0] + share * ax, points[k, 1] + share * ay
    return tail, points[tail, 0], points[tail, 1]


@njit(cache=True)
def release_and_admit(pose, now, wish, drive, held, around):
    """Give up the space behind that braking does not need; admit the largest share of a twist.

    The first held point follows the robot along the path, unless the robot could then not brake
    within what is left.

    Args:
        wish: See `is_admitted`.
        held: Path (n, 2) [m] in map, whose first held point is moved; indices of that point, of
            the point nearest to the robot and of the last held one; the tolerated distance [m].
        around: See `is_admitted`.

    Returns:
        Index of the first held point, and the largest of `SHARES` that is admitted, 0.0 if none is.
    """
    points, tail, near, stop, tolerance = held
    farthest = max(tolerance, gap_to_line(points, tail, stop, pose[0], pose[1]))
    first, x, y = tail_on(points, tail, min(near + 1, stop), pose[0], pose[1])
    old_x, old_y = points[first, 0], points[first, 1]
    points[first, 0], points[first, 1] = x, y
    left = (points, first, stop, tolerance)
    is_near = gap_to_line(points, first, stop, pose[0], pose[1]) <= farthest
    if is_near and is_admitted(pose, now, wish, drive, left, around):
        return first, 1.0
    if not brakes_within(pose, now, drive, points, first, stop, farthest):
        points[first, 0], points[first, 1] = old_x, old_y
        first = tail
        left = (points, first, stop, tolerance)
        if is_admitted(pose, now, wish, drive, left, around):
            return first, 1.0
    for share in SHARES:
        part = (share * wish[0], share * wish[1], share * wish[2])
        if is_admitted(pose, now, part, drive, left, around):
            return first, share
    return first, 0.0
