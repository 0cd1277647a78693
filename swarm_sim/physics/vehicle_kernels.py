"""Numba kernel of vehicles on scripted paths: drive, turn on the spot, wait for standing robots."""

from __future__ import annotations

import math

import numpy as np

from swarm_common.model.records import FloatArray, IntArray
from swarm_common.process.numba_compat import njit
from swarm_sim.physics.walker_kernels import (
    ARC,
    DIRECTION,
    PAUSE,
    STANDING,
    WAITED,
    Loops,
    RobotStates,
    go_on,
    next_corner,
    point_at,
    wait,
)
from swarm_sim.scene.polygon_kernels import overlap, place

ELBOW_ROOM = 0.1  # [m] that a vehicle keeps from a robot that stands
ALIGNED = 1e-6  # [rad]
SPEED, TURN, STEP, PATIENCE, LENGTH, WIDTH = 0, 1, 2, 3, 4, 5  # columns of its traits


@njit(cache=True)
def outline(pose: FloatArray, front: float, back: float, half: float, out: FloatArray) -> None:
    """Write the corners of a rectangle around a pose.

    Args:
        pose: (3,) x, y [m], yaw [rad].
        front: [m] ahead.
        back: [m] behind.
        half: [m] to either side.
        out: (4, 2) receives the corners.
    """
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for k in range(4):
        along = front if k in (1, 2) else -back
        aside = half if k >= 2 else -half
        out[k, 0] = pose[0] + cos * along - sin * aside
        out[k, 1] = pose[1] + sin * along + cos * aside


@njit(cache=True)
def heading_at(path: FloatArray, arcs: FloatArray, arc: float, direction: float) -> float:
    """Return the direction of travel [rad] on a closed path when leaving an arc length.

    Args:
        path: (k + 1, 2) [m], of which the last point is the first one again.
        arcs: (k + 1,) [m] length up to each point.
        arc: [m] from where.
        direction: 1 forwards, -1 backwards.
    """
    probe = arc + direction * 1e-6
    if probe < 0.0:
        probe += arcs[-1]
    elif probe >= arcs[-1]:
        probe -= arcs[-1]
    point = np.empty(2)
    edge = point_at(path, arcs, probe, point)
    dx, dy = path[edge + 1, 0] - path[edge, 0], path[edge + 1, 1] - path[edge, 1]
    return math.atan2(direction * dy, direction * dx)


@njit(cache=True)
def meets(corners: FloatArray, robots: RobotStates, touches: IntArray, step: int) -> bool:
    """Return whether a rectangle meets robots; note which in `touches`.

    Args:
        corners: (4, 2).
        robots: All of them.
        touches: (n,) first step of contact, -1 for none; changed.
        step: Its number within the control period.
    """
    x, y = 0.5 * (corners[0, 0] + corners[2, 0]), 0.5 * (corners[0, 1] + corners[2, 1])
    reach = 0.5 * math.hypot(corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1])
    hull = np.empty_like(robots.hulls[0])
    found = False
    for i in range(robots.poses.shape[0]):
        rx, ry, yaw = robots.poses[i, 0], robots.poses[i, 1], robots.poses[i, 2]
        if math.hypot(rx - x, ry - y) > reach + robots.radii[i]:
            continue
        place(robots.hulls[i], rx, ry, yaw, hull)
        if overlap(corners, hull):
            found = True
            if touches[i] < 0:
                touches[i] = step
    return found


@njit(cache=True)
def bars(roomy: FloatArray, present: FloatArray, bare: FloatArray, robots: RobotStates) -> bool:
    """Return whether a robot that stands is in the way of a vehicle.

    One that is too near already bars only what would run into it, so that the vehicle gets away.

    Args:
        roomy: (4, 2) where it goes next, with elbow room.
        present: (4, 2) where it is, with elbow room.
        bare: (4, 2) where it goes next, without.
        robots: All of them.
    """
    hull = np.empty_like(robots.hulls[0])
    for i in range(robots.poses.shape[0]):
        if abs(robots.speeds[i]) >= STANDING:
            continue
        place(robots.hulls[i], robots.poses[i, 0], robots.poses[i, 1], robots.poses[i, 2], hull)
        if overlap(roomy, hull) and (overlap(bare, hull) or not overlap(present, hull)):
            return True
    return False


@njit(cache=True)
def drive(
    state: FloatArray,
    poses: FloatArray,
    traits: FloatArray,
    loops: Loops,
    robots: RobotStates,
    touches: IntArray,
    period: float,
    step: int,
) -> bool:
    """Move all vehicles by one physics step; return whether any touched a robot.

    A step that would touch a robot is not made, and counts as a contact.

    Args:
        state: (m, 5): arc length, direction, pause left, time waited, points visited; changed.
        poses: (m, 3); changed.
        traits: (m, 6): speed, turn speed, step length, patience, length, width.
        loops: Loops along which they drive.
        robots: All of them.
        touches: (n, m) first step of contact, -1 for none; changed.
        period: [s] of the step.
        step: Its number within the control period.
    """
    corners, goal, spot = np.empty((4, 2)), np.empty(3), np.empty(2)
    present, bare = np.empty((4, 2)), np.empty((4, 2))
    any_touch = False
    for v in range(len(state)):
        if state[v, PAUSE] > 0.0:
            state[v, PAUSE] -= period
            continue
        count = loops.counts[v]
        path, arcs = loops.paths[v, :count], loops.arcs[v, :count]
        half, side = 0.5 * traits[v, LENGTH], 0.5 * traits[v, WIDTH]
        direction, arc = state[v, DIRECTION], state[v, ARC]
        left = abs(next_corner(arcs, arc, direction) - arc)
        turn = heading_at(path, arcs, arc, direction) - poses[v, 2]
        turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
        is_reverse = abs(turn) > 0.5 * math.pi + 1e-9
        if is_reverse:  # drives backwards rather than turn round
            turn -= math.copysign(math.pi, turn)
        goal[:] = poses[v]
        length = 0.0
        if abs(turn) > ALIGNED:
            most = traits[v, TURN] * period
            goal[2] += min(most, max(-most, turn))
        else:
            length = min(left, traits[v, SPEED] * period)
            point_at(path, arcs, arc + direction * length, spot)
            goal[0], goal[1] = spot[0], spot[1]
        ahead = half + (min(left, traits[v, STEP]) if length > 0.0 else 0.0)
        front, back = (half, ahead) if is_reverse else (ahead, half)
        room = 0.0 if is_reverse else ELBOW_ROOM
        outline(goal, front + room, back + ELBOW_ROOM - room, side + ELBOW_ROOM, corners)
        outline(poses[v], half + ELBOW_ROOM, half + ELBOW_ROOM, side + ELBOW_ROOM, present)
        outline(goal, front, back, side, bare)
        if bars(corners, present, bare, robots):
            wait(state[v], period, traits[v, PATIENCE])
            continue
        outline(goal, half, half, side, corners)
        if meets(corners, robots, touches[:, v], step):
            any_touch = True
            continue
        poses[v], state[v, WAITED] = goal, 0.0
        if length == 0.0:
            continue
        is_at_point = left <= traits[v, SPEED] * period
        go_on(state[v], arc + direction * length, arcs, loops.pauses[v], is_at_point)
    return any_touch
