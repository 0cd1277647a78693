"""Slow twins of entry control and of the single-lane passages."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float]
Frame = tuple[float, float, float]


def cell_of(frame: Frame, point: Point) -> tuple[int, int]:
    """Return (row, column) of the cell that holds a point."""
    return (
        math.floor((point[1] - frame[1]) / frame[2]),
        math.floor((point[0] - frame[0]) / frame[2]),
    )


def is_inside(region: NDArray[np.bool_], frame: Frame, point: Point) -> bool:
    """Return whether a point lies in a cell of the region."""
    row, column = cell_of(frame, point)
    rows, columns = region.shape
    return 0 <= row < rows and 0 <= column < columns and bool(region[row, column])


@dataclass(frozen=True)
class Neighbor:
    """What the gate sees of a robot; `has_goal` is false for one that is through."""

    place: Point
    gate_tick: int
    blocked: int
    rank: tuple[int, int]  # the seniority, and the id counted down
    has_goal: bool
    is_gone: bool
    holds: bool


def count_ahead(
    region: NDArray[np.bool_],
    frame: Frame,
    robots: list[Neighbor],
    own: tuple[int, int],
    patience: int,
    mouth: Point,
    distance: float,
) -> tuple[int, int, bool, int]:
    """Return how many are admitted or nearer, not blocked; how many hold inside; if none is higher.

    And the id of the highest of them and of those inside; of equal ones the smaller.
    """
    counted, coming, waiting, is_highest = [], 0, 0, True
    for robot in robots:
        inside = is_inside(region, frame, robot.place)
        if not inside and robot.gate_tick == 0:
            continue
        above = robot.rank > own
        is_highest &= not (above and robot.has_goal and not robot.is_gone)
        is_nearer = math.dist(robot.place, mouth) < distance
        goes_first = robot.blocked <= patience and (robot.gate_tick == 1 or is_nearer)
        waiting += inside and robot.holds
        coming += not inside and goes_first
        if inside or goes_first:
            counted.append(robot.rank)
    return coming, waiting, is_highest, -max(counted)[1] if counted else 0


def components(mask: NDArray[np.bool_]) -> list[frozenset[tuple[int, int]]]:
    """Return the 8-connected components of a mask, in order of their first cell."""
    rest = {(int(i), int(j)) for i, j in np.argwhere(mask)}
    found = []
    while rest:
        group, edge = set(), {min(rest)}
        while edge:
            group |= edge
            edge = {(i + di, j + dj) for i, j in edge for di in (-1, 0, 1) for dj in (-1, 0, 1)} & (
                rest - group
            )
        rest -= group
        found.append(frozenset(group))
    return found


def part_of(groups: list[frozenset[tuple[int, int]]], frame: Frame, point: Point) -> int:
    """Return the number, from 1, of the group of cells in which a point lies, 0 for none."""
    cell = cell_of(frame, point)
    return next((k for k, group in enumerate(groups, 1) if cell in group), 0)
