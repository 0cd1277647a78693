"""Check of joint plans: which moves of several robots on a roadmap can be driven.

In one step each robot waits or moves to a neighbouring vertex. No two robots end a step at one
vertex, and no two change places (Stern et al. 2019). Robots may follow each other. A circle of
robots that all move on at once is a valid move of the literature, but robots with delays cannot
execute it: the dependency graph of such a plan has a circle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray


class FaultKind(StrEnum):
    """Rule that a plan breaks."""

    START = "start"  # a robot is elsewhere when the plan begins
    JUMP = "jump"  # a move to no neighbour
    SHARED = "shared"  # two robots at one vertex
    SWAP = "swap"  # two robots change places
    CIRCLE = "circle"  # three or more robots all move to the next one's place
    GOAL = "goal"  # a robot is elsewhere when the plan ends


@dataclass(frozen=True, slots=True)
class PlanFault:
    """The first rule that a plan breaks, and where."""

    kind: FaultKind  # the rule
    step: int  # row of the plan in which robots are where they must not be, from 0
    robots: tuple[int, ...]  # columns of the robots that break it, the lowest first
    # vertex of the first of these before the step; for START and GOAL where it has to be
    source: int
    target: int  # vertex of the first of these in the step


def first_fault(
    steps: NDArray[np.int32],
    neighbors: NDArray[np.int32],
    *,
    start: NDArray[np.int32] | None = None,
    goals: NDArray[np.int32] | None = None,
    may_rotate: bool = True,
) -> PlanFault | None:
    """Return the first fault of a plan; None if it can be driven.

    Args:
        steps: (k + 1, n) vertices of n robots, step by step.
        neighbors: (V, 4) of the roadmap, -1 where there is none.
        start: (n,) vertices where robots are; None where that is known.
        goals: (n,) vertices where the plan has to end; None for anywhere.
        may_rotate: Whether circles of robots may move on at once.
    """
    if start is not None and (fault := _difference(FaultKind.START, steps, 0, start)):
        return fault
    if fault := _shared(steps[0], steps[0], 0):
        return fault
    for step, (before, after) in enumerate(pairwise(steps), 1):
        fault = _jump(before, after, neighbors, step) or _shared(before, after, step)
        fault = fault or _exchange(before, after, step, may_rotate=may_rotate)
        if fault is not None:
            return fault
    return None if goals is None else _difference(FaultKind.GOAL, steps, len(steps) - 1, goals)


def sentence(fault: PlanFault, names: Sequence[str], cells: NDArray[np.int64]) -> str:
    """Return a fault in words, as part of a sentence.

    Args:
        names: Names of the robots, column by column.
        cells: (V, 2) column and row of each vertex, as whoever made the plan knows them.
    """
    source, target = (f"({x},{y})" for x, y in cells[[fault.source, fault.target]].tolist())
    first, *others = (names[robot] for robot in fault.robots)
    every = " and ".join((first, *others))
    match fault.kind:
        case FaultKind.START:
            return f"{first} begins at {target}; it is at {source}"
        case FaultKind.GOAL:
            return f"{first} ends at {target} in step {fault.step}; its goal is {source}"
        case FaultKind.JUMP:
            is_near = int(np.abs(cells[fault.source] - cells[fault.target]).sum()) == 1
            rule = "a thin wall is between them, which the map cannot show"
            if not is_near:
                rule = "a robot waits or goes to one of the four cells beside its own"
            return f"{first} goes from {source} to {target} in step {fault.step}; {rule}"
        case FaultKind.SHARED:
            return f"{every} are both at {target} in step {fault.step}"
        case FaultKind.SWAP:
            return f"{every} change places at {source} and {target} in step {fault.step}"
    return (
        f"{every} move on in a circle through {source} and {target} in step {fault.step}; robots "
        "with delays cannot do that at once"
    )


def _difference(
    kind: FaultKind, steps: NDArray[np.int32], step: int, expected: NDArray[np.int32]
) -> PlanFault | None:
    wrong = np.flatnonzero(steps[step] != expected)
    if not len(wrong):
        return None
    robot = int(wrong[0])
    return PlanFault(kind, step, (robot,), int(expected[robot]), int(steps[step, robot]))


def _shared(before: NDArray[np.int32], after: NDArray[np.int32], step: int) -> PlanFault | None:
    first_at: dict[int, int] = {}
    for robot, vertex in enumerate(after.tolist()):
        other = first_at.setdefault(vertex, robot)
        if other != robot:
            return PlanFault(FaultKind.SHARED, step, (other, robot), int(before[other]), vertex)
    return None


def _jump(
    before: NDArray[np.int32], after: NDArray[np.int32], neighbors: NDArray[np.int32], step: int
) -> PlanFault | None:
    is_near = (neighbors[before] == after[:, None]).any(axis=1)
    wrong = np.flatnonzero((before != after) & ~is_near)
    if not len(wrong):
        return None
    robot = int(wrong[0])
    return PlanFault(FaultKind.JUMP, step, (robot,), int(before[robot]), int(after[robot]))


def _exchange(
    before: NDArray[np.int32], after: NDArray[np.int32], step: int, *, may_rotate: bool
) -> PlanFault | None:
    """Return two robots that change places, or more that move on in a circle.

    Following "who stands where this robot goes" from a robot of a circle leads back to it.
    """
    standing = {vertex: robot for robot, vertex in enumerate(before.tolist())}
    for first in np.flatnonzero(before != after).tolist():
        robots, robot = [first], standing.get(int(after[first]), -1)
        while robot >= 0 and before[robot] != after[robot] and robot not in robots:
            robots.append(robot)
            robot = standing.get(int(after[robot]), -1)
        if robot != first or (may_rotate and len(robots) > 2):
            continue
        kind = FaultKind.SWAP if len(robots) == 2 else FaultKind.CIRCLE
        return PlanFault(kind, step, tuple(sorted(robots)), int(before[first]), int(after[first]))
    return None
