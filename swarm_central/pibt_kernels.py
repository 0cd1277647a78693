"""PIBT: one step of all robots by priority inheritance with backtracking.

Okumura, Machida, Défago, Tamura 2022. With turning costs a robot prefers the neighbour from which
it arrives soonest. Where `may_rotate` is false no circle of robots moves on at once, since robots
with delays cannot execute that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from swarm_central.roadmap import Costs

OCCUPIED = np.float32(0.05)  # [s] by which a free place is preferred


class JointStep(NamedTuple):
    """One step of n robots on V vertices, filled in by `step`."""

    at: NDArray[np.int32]  # (n,) vertices now
    headings: NDArray[np.int32]  # (n,) directions now
    next: NDArray[np.int32]  # (n,) vertices after the step; -1 undecided, else fixed before
    now: NDArray[np.int32]  # (V,) robot at each vertex, -1 for none
    then: NDArray[np.int32]  # (V,) robot that will be there, -1 for none


class Wishes(NamedTuple):
    """Goals of the robots, and the costs of the ways to them."""

    fields: NDArray[np.floating]  # (k, V, 4) [s] to go, by vertex and heading
    goals: NDArray[np.int32]  # (n,) row of `fields` of each robot
    closed: NDArray[np.bool_]  # (V,) vertices that nobody may enter and everybody leaves
    noise: NDArray[np.float32]  # (n, 5) [s] added to the five choices


@njit(cache=True)
def step(
    order: NDArray[np.int64], moves: JointStep, costs: Costs, wishes: Wishes, may_rotate: bool
) -> bool:
    """Decide for all robots; what is fixed before stays.

    Args:
        order: (n,) robots by priority, the first first.
        moves: Filled in.
        costs: Costs [s] of the roadmap's moves.
        wishes: Goals of the robots, and the costs of the ways to them.
        may_rotate: Whether a circle of robots may move on at once.

    Returns:
        False if a fixed move cannot be.
    """
    moves.now[:] = -1
    moves.then[:] = -1
    for robot in range(len(moves.at)):
        moves.now[moves.at[robot]] = robot
    for robot in range(len(moves.at)):
        target = moves.next[robot]
        if target < 0:
            continue
        if moves.then[target] >= 0:
            return False
        other = moves.now[target]
        if other >= 0 and other != robot and moves.next[other] == moves.at[robot]:
            return False
        moves.then[target] = robot
    for robot in order:
        if moves.next[robot] < 0:
            _decide(robot, moves, costs, wishes, may_rotate)
    for robot in range(len(moves.at)):
        if moves.then[moves.next[robot]] != robot:
            return False
    return True


@njit(cache=True)
def _decide(first: int, moves: JointStep, costs: Costs, wishes: Wishes, may_rotate: bool) -> None:
    """Choose the best place that is free or can be made free; whoever finds none stays.

    The recursion of the paper, with its stack in arrays: numba cannot cache recursive functions.
    """
    count = len(moves.at)
    stack = np.empty(count, np.int32)
    targets = np.empty((count, 5), np.int32)
    choices = np.empty((count, 5), np.int64)
    tried = np.zeros(count, np.int32)
    depth = 0
    stack[0] = first
    choices[0] = _ranked(first, moves, costs, wishes, targets[0])
    while depth >= 0:
        robot = stack[depth]
        here = moves.at[robot]
        if tried[depth] == 5:
            moves.next[robot] = here
            moves.then[here] = robot
            depth -= 1
            continue
        target = targets[depth, choices[depth, tried[depth]]]
        tried[depth] += 1
        if target < 0 or moves.then[target] >= 0:
            continue
        other = moves.now[target]
        if other >= 0 and other != robot:
            if moves.next[other] == here:
                continue
            if not may_rotate and _closes_circle(robot, other, moves):
                continue
        moves.then[target] = robot
        moves.next[robot] = target
        if other < 0 or other == robot or moves.next[other] >= 0:
            return
        depth += 1
        stack[depth] = other
        tried[depth] = 0
        choices[depth] = _ranked(other, moves, costs, wishes, targets[depth])


@njit(cache=True)
def _ranked(
    robot: int, moves: JointStep, costs: Costs, wishes: Wishes, targets: NDArray[np.int32]
) -> NDArray[np.int64]:
    """Write the five targets of a robot, and return their order by the time to its goal."""
    values = np.empty(5, np.float32)
    here, heading = moves.at[robot], moves.headings[robot]
    field = wishes.fields[wishes.goals[robot]]
    for direction in range(4):
        target = costs.neighbors[here, direction]
        targets[direction] = target
        if target < 0 or (wishes.closed[target] and not wishes.closed[here]):
            targets[direction] = -1
            values[direction] = np.float32(np.inf)
            continue
        values[direction] = (
            costs.turns[heading, direction]
            + costs.edges[here, direction]
            + field[target, direction]
            + wishes.noise[robot, direction]
        )
        if moves.now[target] >= 0:
            values[direction] += OCCUPIED
    targets[4] = here
    values[4] = field[here, heading] + costs.wait + wishes.noise[robot, 4]
    if wishes.closed[here]:
        values[4] += np.float32(1e6)
    return np.argsort(values)


@njit(cache=True)
def _closes_circle(robot: int, other: int, moves: JointStep) -> bool:
    """Whether robots from `other` on move into each other's places up to this robot's."""
    while True:
        target = moves.next[other]
        if target < 0 or target == moves.at[other]:
            return False
        other = moves.now[target]
        if other < 0:
            return False
        if other == robot:
            return True


@njit(cache=True)
def roll_out(
    order: NDArray[np.int64],
    start: NDArray[np.int32],
    headings: NDArray[np.int32],
    locked: NDArray[np.bool_],
    places: NDArray[np.int32],
    costs: Costs,
    wishes: Wishes,
    steps: int,
) -> NDArray[np.int32]:
    """Return (steps + 1, n) vertices of all robots, step by step.

    Args:
        order: Robots by priority, the first first.
        start: (n,) vertices, all different.
        headings: (n,) directions.
        locked: (n,) robots that stay.
        places: (n,) vertices where robots stay once they are there; -1 for none.
        costs: Costs [s] of the roadmap's moves.
        wishes: Goals of the robots, and the costs of the ways to them.
        steps: Number of steps.
    """
    count, vertices = len(start), costs.neighbors.shape[0]
    plan = np.empty((steps + 1, count), np.int32)
    plan[0] = start
    headings = headings.copy()
    locked = locked.copy()
    now, then = np.empty(vertices, np.int32), np.empty(vertices, np.int32)
    for t in range(steps):
        following = np.full(count, -1, np.int32)
        for robot in range(count):
            if locked[robot] or (t > 0 and plan[t, robot] == places[robot]):
                following[robot] = plan[t, robot]
        moves = JointStep(plan[t], headings, following, now, then)
        step(order, moves, costs, wishes, False)
        plan[t + 1] = following
        for robot in range(count):
            for direction in range(4):
                if costs.neighbors[plan[t, robot], direction] == following[robot]:
                    headings[robot] = direction
    return plan
