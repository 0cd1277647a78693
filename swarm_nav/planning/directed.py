"""Directed zones on the lattice: moves that lead off their direction are closed, or dear."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, wrap_angle
from swarm_common.model.zones import DirectedZone
from swarm_nav.planning.distance_kernels import Frame
from swarm_nav.planning.search_kernels import MOVES

SLACK = 1e-6  # [rad]
NARROW = 0.49  # steps beside a zone in which its nodes are: a narrow one has some, too


class Directions(NamedTuple):
    """Directed zones on a lattice."""

    zones: tuple[DirectedZone, ...]
    frame: Frame  # where the nodes lie


def direct_moves(moves: NDArray[np.uint32], directions: Directions) -> NDArray[np.uint32]:
    """Return the moves from each node of a lattice, with the directions of zones.

    A zone counts for each move that begins or ends in it, or passes it.

    Args:
        moves: (h, w), see `search_kernels.Ground`.

    Returns:
        (h, w).
    """
    directed = moves.copy()
    for zone in directions.zones:
        inside = nodes_in((zone,), directions.frame, moves.shape, NARROW)
        for m, off in enumerate(_off_direction(zone)):
            if off <= zone.free_off + SLACK:
                continue
            touches = _touched_by(inside, *MOVES[m].tolist())
            if off > zone.most_off + SLACK:
                directed[touches] &= ~np.uint32(1 << m)
            else:
                directed[touches] |= np.uint32(1 << (16 + m))
    return directed


def _off_direction(zone: DirectedZone) -> list[float]:
    """Return the angle [rad] of each move off the direction of a zone."""
    ways = [math.atan2(dr, dc) for dr, dc in MOVES.tolist()]
    off = [abs(wrap_angle(way - zone.direction)) for way in ways]
    return [min(angle, math.pi - angle) for angle in off] if zone.is_two_way else off


def nodes_in(
    zones: tuple[DirectedZone, ...], frame: Frame, shape: tuple[int, ...], margin: float
) -> NDArray[np.bool_]:
    """Return the nodes (h, w) in zones, or near them.

    Args:
        shape: (h, w) of the lattice.
        margin: Steps beside a zone that count as it.
    """
    import shapely

    areas = [shapely.Polygon(zone.points).buffer(margin * frame.step) for zone in zones]
    area = shapely.union_all(areas)
    shapely.prepare(area)
    x = frame.origin_x + (np.arange(shape[1]) + 0.5) * frame.step
    y = frame.origin_y + (np.arange(shape[0]) + 0.5) * frame.step
    return np.asarray(shapely.contains_xy(area, *np.meshgrid(x, y)))


def straightened(zones: tuple[DirectedZone, ...]) -> tuple[DirectedZone, ...]:
    """Return zones through which no way zigzags: of those of two ways only one line is open."""
    return tuple(
        replace(zone, most_off=min(zone.free_off, zone.most_off)) if zone.is_two_way else zone
        for zone in zones
    )


def turns_back(points: FloatArray, zones: tuple[DirectedZone, ...]) -> bool:
    """Return whether a way zigzags through a zone of two ways, which leads it across both.

    Args:
        points: (n, 2) [m] in map, nodes.
    """
    import shapely

    steps, middles = np.diff(points, axis=0), 0.5 * (points[1:] + points[:-1])
    for zone in zones:
        if not zone.is_two_way or zone.most_off + SLACK > 0.5 * math.pi:
            continue
        inside = shapely.contains_xy(shapely.Polygon(zone.points), *middles.T)
        east, north = math.cos(zone.direction), math.sin(zone.direction)
        ahead = steps[:, 0] * east + steps[:, 1] * north > 0.0
        if (inside[1:] & inside[:-1] & (ahead[1:] != ahead[:-1])).any():
            return True
    return False


def _touched_by(inside: NDArray[np.bool_], dr: int, dc: int) -> NDArray[np.bool_]:
    """Return the nodes (h, w) whose move by rows and columns begins, ends or passes inside."""
    passed = [(dr, dc)]
    if abs(dr) == 2:
        passed += [(dr // 2, 0), (dr // 2, dc)]
    elif abs(dc) == 2:
        passed += [(0, dc // 2), (dr, dc // 2)]
    height, width = inside.shape
    padded = np.pad(inside, 2)
    touched = inside.copy()
    for rows, columns in passed:
        touched |= padded[2 + rows : 2 + rows + height, 2 + columns : 2 + columns + width]
    return touched
