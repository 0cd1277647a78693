"""Goals of robots that change places or roam: drawn for the whole swarm from one seed.

No two robots are sent to the same place at the same time, so each operator draws for the whole
swarm and takes its own robot's share.
"""

from __future__ import annotations

import functools
import random
from collections.abc import Sequence

from swarm_common.model.records import Pose

TRIES = 50  # draws of a place before a robot takes the farthest free one


def opposite(count: int) -> list[int]:
    """Return the robot whose place each robot takes if all cross to the far side of a ring.

    Returns:
        Index of the partner of each robot, from 0.
    """
    return [(index + count // 2) % count for index in range(count)]


def other_groups(count: int, groups: int, seed: str) -> list[int]:
    """Return the robot whose place each robot takes if all move to a random other group's.

    Robot k belongs to group k mod `groups`. Where groups of unequal size leave no other way, a
    robot takes a place of its own group.

    Returns:
        Index of the partner of each robot, from 0.
    """
    rng = random.Random(seed)
    partners = list(range(count))
    rng.shuffle(partners)
    order = list(range(count))
    for index in range(count):
        if partners[index] % groups != index % groups:
            continue
        rng.shuffle(order)
        for other in order:
            if (
                partners[other] % groups != index % groups
                and partners[index] % groups != other % groups
            ):
                partners[index], partners[other] = partners[other], partners[index]
                break
    return partners


@functools.lru_cache(maxsize=16)
def roaming(
    homes: tuple[Pose, ...], places: tuple[Pose, ...], rounds: int, distance: float, seed: str
) -> tuple[tuple[int, ...], ...]:
    """Return the place (index) of each robot in each round, different ones in a round.

    Args:
        places: At least as many as robots.
        rounds: Places that each robot is sent to.
        distance: [m] at least from a robot's last place to its next, where one is free.
    """
    rng = random.Random(seed)
    last: Sequence[Pose] = homes
    result = []
    for _ in range(rounds):
        chosen = _one_round(last, places, distance, rng)
        last = [places[index] for index in chosen]
        result.append(tuple(chosen))
    return tuple(result)


def _one_round(
    last: Sequence[Pose], places: Sequence[Pose], distance: float, rng: random.Random
) -> list[int]:
    free = list(range(len(places)))
    chosen = [0] * len(last)
    robots = list(range(len(last)))
    rng.shuffle(robots)
    for robot in robots:
        pick = max(free, key=lambda index: last[robot].distance(places[index]))
        for _ in range(TRIES):
            candidate = rng.choice(free)
            if last[robot].distance(places[candidate]) >= distance:
                pick = candidate
                break
        free.remove(pick)
        chosen[robot] = pick
    return chosen
