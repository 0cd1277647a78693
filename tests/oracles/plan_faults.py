"""What is wrong with the steps of a joint plan, by trying all groups of robots."""

import itertools
from collections.abc import Sequence


def faults_of_step(
    before: Sequence[int],
    after: Sequence[int],
    neighbors: Sequence[Sequence[int]],
    *,
    may_rotate: bool,
) -> set[str]:
    """Return the kinds of faults of one step."""
    found = set()
    robots = range(len(before))
    for robot in robots:
        if after[robot] != before[robot] and after[robot] not in neighbors[before[robot]]:
            found.add("jump")
    for a, b in itertools.combinations(robots, 2):
        if after[a] == after[b]:
            found.add("shared")
        if before[a] != before[b] and (after[a], after[b]) == (before[b], before[a]):
            found.add("swap")
    for size in range(3, len(before) + 1):
        for group in itertools.permutations(robots, size):
            ring = zip(group, (*group[1:], group[0]), strict=True)
            if not may_rotate and all(
                after[a] == before[b] and after[a] != before[a] for a, b in ring
            ):
                found.add("circle")
    return found


def faults_of_plan(
    steps: Sequence[Sequence[int]],
    neighbors: Sequence[Sequence[int]],
    start: Sequence[int],
    goals: Sequence[int],
    *,
    may_rotate: bool,
) -> tuple[int, set[str]]:
    """Return the first step that has faults, and their kinds; none for a plan to be driven."""
    if list(steps[0]) != list(start):
        return 0, {"start"}
    if len(set(steps[0])) < len(steps[0]):
        return 0, {"shared"}
    for step, (before, after) in enumerate(itertools.pairwise(steps), 1):
        if found := faults_of_step(before, after, neighbors, may_rotate=may_rotate):
            return step, found
    return len(steps) - 1, {"goal"} if list(steps[-1]) != list(goals) else set()
