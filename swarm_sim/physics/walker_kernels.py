"""Numba kernels of the walkers: one step along their loops, and their distance from robots."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from swarm_common.model.records import FloatArray, IntArray
from swarm_common.process.numba_compat import njit
from swarm_sim.scene.polygon_kernels import distance, place

STANDING = 0.02  # [m/s] below which a robot stands
ELBOW_ROOM = 0.05  # [m] that a walker keeps from a robot that stands
ARC, DIRECTION, PAUSE, WAITED, VISITS = 0, 1, 2, 3, 4  # columns of a walker's state
SPEED, RADIUS, STEP, PATIENCE = 0, 1, 2, 3  # columns of a walker's traits


class RobotStates(NamedTuple):
    """Robots as walkers and vehicles meet them."""

    poses: FloatArray  # (n, 3) x, y [m], yaw [rad]
    speeds: FloatArray  # (n,) [m/s] ahead
    hulls: FloatArray  # (n, k, 2) [m] footprints in base_footprint
    radii: FloatArray  # (n,) [m] circumscribed


class Loops(NamedTuple):
    """Closed paths, one per walker or vehicle."""

    paths: FloatArray  # (m, k, 2) [m]; the last point of each is its first one again
    arcs: FloatArray  # (m, k) [m] length up to each point
    counts: IntArray  # (m,) points of each path
    pauses: FloatArray  # (m, p) [s] at the points, in order of visits


@njit(cache=True)
def disc_gap(hull: FloatArray, x: float, y: float, radius: float) -> float:
    """Return the distance [m] of a disc from a convex polygon; 0 if they meet.

    Args:
        hull: (k, 2) [m].
        x: [m] of the disc's centre.
        y: [m] of the disc's centre.
        radius: [m] of the disc.
    """
    point = np.empty((1, 2))
    point[0, 0], point[0, 1] = x, y
    return max(0.0, distance(hull, point) - radius)


@njit(cache=True)
def point_at(path: FloatArray, arcs: FloatArray, arc: float, out: FloatArray) -> int:
    """Write the point at an arc length of a closed path; return the index of its edge.

    Args:
        path: (k + 1, 2), of which the last point is the first one again.
        arcs: (k + 1,) length up to each point.
        arc: [m] from 0 to the whole length.
        out: (2,).
    """
    edge = 0
    while edge < len(arcs) - 2 and arcs[edge + 1] <= arc:
        edge += 1
    share = (arc - arcs[edge]) / (arcs[edge + 1] - arcs[edge])
    for axis in range(2):
        out[axis] = path[edge, axis] + share * (path[edge + 1, axis] - path[edge, axis])
    return edge


@njit(cache=True)
def next_corner(arcs: FloatArray, arc: float, direction: float) -> float:
    """Return the arc length [m] of the next point of a path, its whole length for the first one.

    Args:
        arcs: (k + 1,) [m] length up to each point.
        arc: [m] from where.
        direction: 1 forwards, -1 backwards.
    """
    if direction > 0.0:
        for k in range(1, len(arcs)):
            if arcs[k] > arc + 1e-9:
                return arcs[k]
        return arcs[-1]
    for k in range(len(arcs) - 1, -1, -1):
        if arcs[k] < arc - 1e-9:
            return arcs[k]
    return 0.0


@njit(cache=True)
def wait(state: FloatArray, period: float, patience: float) -> None:
    """Record in a walker's or vehicle's state that it waits; turn round when it has for long.

    Args:
        state: (5,); changed.
        period: [s] of the step.
        patience: [s] after which it turns round.
    """
    state[WAITED] += period
    if state[WAITED] > patience:
        state[WAITED], state[DIRECTION] = 0.0, -state[DIRECTION]


@njit(cache=True)
def go_on(
    state: FloatArray, arc: float, arcs: FloatArray, pauses: FloatArray, is_at_point: bool
) -> None:
    """Record in a walker's or vehicle's state how far it has come; at a point it pauses.

    Args:
        state: (5,); changed.
        arc: [m] along the closed path.
        arcs: (k + 1,) length up to each point.
        pauses: [s] at the points, in order of visits.
        is_at_point: Whether it has reached one.
    """
    if is_at_point:
        state[PAUSE] = pauses[int(state[VISITS]) % len(pauses)]
        state[VISITS] += 1.0
    if state[DIRECTION] > 0.0 and arc >= arcs[-1] - 1e-9:
        arc = 0.0
    elif state[DIRECTION] < 0.0 and arc <= 1e-9:
        arc = arcs[-1]
    state[ARC] = arc


@njit(cache=True)
def is_barred(here: FloatArray, ahead: FloatArray, radius: float, robots: RobotStates) -> bool:
    """Return whether a robot that stands is in the way of a walker's next step.

    Robots count as discs in which they can turn; one that is too near already bars nobody who
    walks away from it.

    Args:
        here: (2,) [m] where the walker is.
        ahead: (2,) [m] where its next step ends.
        radius: [m] of the walker.
        robots: All of them.
    """
    ex, ey = ahead[0] - here[0], ahead[1] - here[1]
    length = ex * ex + ey * ey
    for i in range(robots.poses.shape[0]):
        if abs(robots.speeds[i]) >= STANDING:
            continue
        dx, dy = robots.poses[i, 0] - here[0], robots.poses[i, 1] - here[1]
        along = min(1.0, max(0.0, (dx * ex + dy * ey) / length)) if length > 0.0 else 0.0
        nearest = math.hypot(dx - along * ex, dy - along * ey)
        reach = radius + ELBOW_ROOM + robots.radii[i]
        if nearest < reach and nearest < math.hypot(dx, dy) - 1e-9:
            return True
    return False


@njit(cache=True)
def walk(
    state: FloatArray,
    places: FloatArray,
    traits: FloatArray,
    loops: Loops,
    robots: RobotStates,
    touches: IntArray,
    period: float,
    step: int,
) -> bool:
    """Move all walkers by one physics step; return whether any touched a robot.

    A step that would touch a robot is not made, and counts as a contact.

    Args:
        state: (m, 5): arc length, direction, pause left, time waited, points visited; changed.
        places: (m, 2); changed.
        traits: (m, 4): speed, radius, step length, patience.
        loops: Loops along which they walk.
        robots: All of them.
        touches: (n, m) first step of contact, -1 for none; changed.
        period: [s] of the step.
        step: Its number within the control period.
    """
    hull = np.empty_like(robots.hulls[0])
    goal = np.empty(2)
    any_touch = False
    for w in range(len(state)):
        if state[w, PAUSE] > 0.0:
            state[w, PAUSE] -= period
            continue
        count = loops.counts[w]
        path, arcs = loops.paths[w, :count], loops.arcs[w, :count]
        direction = state[w, DIRECTION]
        corner = next_corner(arcs, state[w, ARC], direction)
        left = abs(corner - state[w, ARC])
        arc = state[w, ARC] + direction * min(left, traits[w, STEP])
        point_at(path, arcs, arc, goal)
        if is_barred(places[w], goal, traits[w, RADIUS], robots):
            wait(state[w], period, traits[w, PATIENCE])
            continue
        arc = state[w, ARC] + direction * min(left, traits[w, SPEED] * period)
        point_at(path, arcs, arc, goal)
        if _hits(goal, traits[w, RADIUS], robots, hull, touches[:, w], step):
            any_touch = True
            continue
        places[w], state[w, WAITED] = goal, 0.0
        go_on(state[w], arc, arcs, loops.pauses[w], left <= traits[w, SPEED] * period)
    return any_touch


@njit(cache=True)
def _hits(
    center: FloatArray,
    radius: float,
    robots: RobotStates,
    hull: FloatArray,
    touches: IntArray,
    step: int,
) -> bool:
    """Record which robots a walker at a place would touch; return whether there are any.

    Args:
        center: (2,) [m] of the walker.
        radius: [m] of the walker.
        robots: All of them.
        hull: (k, 2) scratch.
        touches: (n,) first step of contact, -1 for none; changed.
        step: Its number within the control period.
    """
    any_hit = False
    for i in range(robots.poses.shape[0]):
        x, y, yaw = robots.poses[i, 0], robots.poses[i, 1], robots.poses[i, 2]
        if math.hypot(x - center[0], y - center[1]) > radius + robots.radii[i]:
            continue
        place(robots.hulls[i], x, y, yaw, hull)
        if disc_gap(hull, center[0], center[1], radius) <= 0.0:
            if touches[i] < 0:
                touches[i] = step
            any_hit = True
    return any_hit
