"""A roadmap from a map: a square lattice of places, a robot apart, with lanes as costs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from swarm_central.roadmap_kernels import costs_to
from swarm_common.model.errors import SwarmError
from swarm_common.model.grid import KEEPOUT
from swarm_common.model.records import FloatArray
from swarm_nav.planning.terrain import HALL_DISTANCE, KEEPOUT_COST, Terrain

EAST, NORTH, WEST, SOUTH = range(4)
STEPS = ((1, 0), (0, 1), (-1, 0), (0, -1))  # (columns, rows) by direction
SHIFTS = 12  # offsets of the lattice that are tried along each axis
STATION_WEIGHT = 12.0  # vertices that a station on the lattice is worth
MOST_NEAR = 16  # vertices that are looked at for a point
ZONE_SAMPLES = 6  # places along a way where the costs of zones are read
NO_WAY = np.float32(1e9)  # [s] where there is none


class RoadmapError(SwarmError):
    """The map has no roadmap that robots of this size can use."""


class Timing(NamedTuple):
    """Durations of moves [s]."""

    quarter: float  # turn by 90 degrees
    half: float  # turn by 180 degrees
    wait: float  # one step of standing


class Costs(NamedTuple):
    """The graph in arrays, as kernels read it; V vertices, 4 directions."""

    neighbors: NDArray[np.int32]  # (V, 4) vertex in each direction, -1 where there is none
    edges: NDArray[np.float32]  # (V, 4) [s] of driving there, lanes included
    turns: NDArray[np.float32]  # (4, 4) [s] from one heading to another
    wait: np.float32  # [s] of one step of standing


@dataclass(frozen=True, slots=True)
class Roadmap:
    """Places where robots may stop, and straight ways between neighbours."""

    points: FloatArray  # (V, 2) [m] in map
    cells: NDArray[np.int64]  # (V, 2) column and row of each vertex on the lattice
    costs: Costs  # for kernels
    parking: NDArray[np.bool_]  # (V,) whether a robot that waits stands out of the lanes
    spacing: float  # [m] of the lattice

    def in_reach(self, x: float, y: float, terrain: Terrain, room: float) -> NDArray[np.int64]:
        """Return the vertices near a point to which a straight line is clear, the nearest first.

        Args:
            x: [m] in map.
            y: [m] in map.
            terrain: The map.
            room: [m] that the line keeps from walls, or as much as the point has.
        """
        gaps = np.hypot(self.points[:, 0] - x, self.points[:, 1] - y)
        near = np.argsort(gaps, kind="stable")[:MOST_NEAR]
        start = np.array((x, y))
        room = min(room, terrain.clearance(x, y) - 0.02)
        shares = np.linspace(0.0, 1.0, 9)
        clear = [
            all(
                terrain.clearance(*place) >= room
                for place in start + shares[:, None] * (self.points[vertex] - start)
            )
            for vertex in near
        ]
        return near[np.array(clear, np.bool_)]

    def costs_to(self, targets: NDArray[np.int64], closed: NDArray[np.bool_]) -> FloatArray:
        """Return the time (V, 4) [s] to the nearest target, by vertex and heading at the start.

        Args:
            closed: (V,) vertices that nobody may enter.
        """
        found: FloatArray = costs_to(targets, closed, *self.costs)
        return found


def build_roadmap(
    terrain: Terrain,
    spacing: float,
    room: float,
    timing: Timing,
    speed: float,
    stations: FloatArray,
    reach: float,
) -> Roadmap:
    """Return the roadmap whose offset gives most vertices, and stations within reach.

    Args:
        terrain: The map; its lanes and zones become costs.
        spacing: [m] between neighbours.
        room: [m] that a vertex and the ways between vertices keep from walls.
        speed: [m/s]
        stations: (k, 2) [m] in map; may be empty.
        reach: [m] from a vertex at which a station counts as on it.

    Raises:
        RoadmapError: If the map has no two neighbouring places.
    """
    shifts = np.arange(SHIFTS) * spacing / SHIFTS
    best, most = None, -math.inf
    for dx in shifts:
        for dy in shifts:
            axes = _axes(terrain, spacing, dx, dy)
            links = _links(terrain, axes, spacing, room)
            inside, value = _linked(links)
            value += STATION_WEIGHT * _near(axes, inside, stations, reach)
            if value > most:
                best, most = (axes, links, inside), value
    assert best is not None
    if best[2].sum() < 2:
        raise RoadmapError(
            f"the map has no two places {spacing:g} m apart with {room:g} m to every wall"
        )
    return _compose(terrain, *best, spacing, timing, speed)


def _axes(terrain: Terrain, spacing: float, dx: float, dy: float) -> tuple[FloatArray, FloatArray]:
    grid = terrain.grid
    return (
        np.arange(grid.origin_x + dx, grid.origin_x + grid.width * grid.resolution, spacing),
        np.arange(grid.origin_y + dy, grid.origin_y + grid.height * grid.resolution, spacing),
    )


def _clear(terrain: Terrain, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the distance [m] to walls on a lattice (rows, columns)."""
    frame = terrain.frame
    columns = np.clip(((x - frame.origin_x) / frame.step).astype(int), 0, terrain.grid.width - 1)
    rows = np.clip(((y - frame.origin_y) / frame.step).astype(int), 0, terrain.grid.height - 1)
    return terrain.distance[np.ix_(rows, columns)]


def _links(
    terrain: Terrain, axes: tuple[FloatArray, FloatArray], spacing: float, room: float
) -> NDArray[np.bool_]:
    """Return (rows, columns, 2): whether the way east and the way north is free."""
    x, y = axes
    parts = max(2, math.ceil(spacing / 0.1))
    east = np.full((len(y), len(x)), True)
    north = east.copy()
    for part in range(parts + 1):
        step = spacing * part / parts
        east &= _clear(terrain, x + step, y) >= room
        north &= _clear(terrain, x, y + step) >= room
    east[:, -1] = False
    north[-1, :] = False
    return np.stack((east, north), axis=-1)


def _linked(links: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], float]:
    """Return (rows, columns) which vertices have a neighbour, and the mean size of their parts.

    The mean is over vertices: two rooms are worth more with the door between them than without.
    """
    height, width = links.shape[:2]
    index = np.arange(height * width).reshape(height, width)
    east, north = links[:, :-1, 0], links[:-1, :, 1]
    first = np.concatenate((index[:, :-1][east], index[:-1][north]))
    second = np.concatenate((index[:, 1:][east], index[1:][north]))
    graph = coo_matrix((np.ones(len(first)), (first, second)), shape=(index.size, index.size))
    _, labels = connected_components(graph, directed=False)
    sizes = np.bincount(labels)
    inside = (sizes[labels] > 1).reshape(height, width)
    sizes = sizes[sizes > 1].astype(np.float64)
    return inside, float((sizes**2).sum() / max(1.0, sizes.sum()))


def _near(
    axes: tuple[FloatArray, FloatArray],
    inside: NDArray[np.bool_],
    stations: FloatArray,
    reach: float,
) -> float:
    rows, columns = np.nonzero(inside)
    x, y = axes[0][columns], axes[1][rows]
    gaps = [np.hypot(x - px, y - py).min() for px, py in stations.tolist()] if len(x) else []
    return float(sum(gap <= reach for gap in gaps)) - float(sum(gap > 3 * reach for gap in gaps))


def _compose(
    terrain: Terrain,
    axes: tuple[FloatArray, FloatArray],
    links: NDArray[np.bool_],
    inside: NDArray[np.bool_],
    spacing: float,
    timing: Timing,
    speed: float,
) -> Roadmap:
    rows, columns = np.nonzero(inside)
    points = np.column_stack((axes[0][columns], axes[1][rows]))
    number = np.full(inside.shape, -1, np.int32)
    number[rows, columns] = np.arange(len(points))
    neighbors = np.full((len(points), 4), -1, np.int32)
    for direction, (dc, dr) in enumerate(STEPS):
        for vertex, (row, column) in enumerate(zip(rows, columns, strict=True)):
            low_row, low_column = row + min(dr, 0), column + min(dc, 0)
            if low_row < 0 or low_column < 0 or not links[low_row, low_column, abs(dr)]:
                continue
            neighbors[vertex, direction] = number[row + dr, column + dc]
    edges = _edge_times(terrain, points, neighbors, spacing / speed)
    turns = np.array(
        [
            [(0.0, timing.quarter, timing.half, timing.quarter)[(b - a) % 4] for b in range(4)]
            for a in range(4)
        ],
        np.float32,
    )
    lattice = terrain.lattice
    parked = _on_lattice(terrain, points, lattice.clearance) > HALL_DISTANCE
    if not parked.any():
        parked[:] = True
    costs = Costs(neighbors, edges, turns, np.float32(timing.wait))
    return Roadmap(points, np.column_stack((columns, rows)), costs, parked, spacing)


def _edge_times(
    terrain: Terrain, points: FloatArray, neighbors: NDArray[np.int32], time: float
) -> NDArray[np.float32]:
    """Return (V, 4) [s]: dear against the lane, as for our planner's paths."""
    lattice = terrain.lattice
    edges = np.full(neighbors.shape, NO_WAY, np.float32)
    for direction, unit in enumerate(STEPS):
        ways = np.flatnonzero(neighbors[:, direction] >= 0)
        middle = 0.5 * (points[ways] + points[neighbors[ways, direction]])
        along = _on_lattice(terrain, middle, lattice.heading) @ np.array(unit, np.float32)
        lane = _on_lattice(terrain, middle, lattice.lane)
        zones = _zone_costs(terrain, points[ways], points[neighbors[ways, direction]])
        edges[ways, direction] = time * (1.0 + 0.5 * lane * (1.0 - along) + zones)
    return edges


def _zone_costs(terrain: Terrain, starts: FloatArray, ends: FloatArray) -> FloatArray | float:
    """Return the mean extra cost (n,) per metre of learned lanes and keepout zones along ways."""
    grid = terrain.grid
    if grid.keepout is None:
        return 0.0
    shares = np.linspace(0.0, 1.0, ZONE_SAMPLES)
    places = starts[:, None] + shares[:, None] * (ends - starts)[:, None]
    cells = ((places - (grid.origin_x, grid.origin_y)) / grid.resolution).astype(int)
    rows = np.clip(cells[..., 1], 0, grid.height - 1)
    columns = np.clip(cells[..., 0], 0, grid.width - 1)
    costs: FloatArray = grid.keepout[rows, columns].mean(axis=1) * KEEPOUT_COST / (KEEPOUT - 1)
    return costs


def _on_lattice(terrain: Terrain, points: FloatArray, layer: NDArray[np.generic]) -> FloatArray:
    """Return a layer of the planner's lattice at points (n, 2) [m] in map."""
    frame = terrain.lattice.frame
    columns = np.floor((points[:, 0] - frame.origin_x) / frame.step).astype(int)
    rows = np.floor((points[:, 1] - frame.origin_y) / frame.step).astype(int)
    values: FloatArray = layer[
        np.clip(rows, 0, layer.shape[0] - 1), np.clip(columns, 0, layer.shape[1] - 1)
    ]
    return values


def grid_roadmap(passable: NDArray[np.bool_]) -> Roadmap:
    """Return the roadmap of a grid of cells, 1 s per move and turns for nothing.

    Args:
        passable: (rows, columns), row 0 at the lowest y.
    """
    rows, columns = np.nonzero(passable)
    number = np.full(passable.shape, -1, np.int32)
    number[rows, columns] = np.arange(len(rows))
    padded = np.pad(number, 1, constant_values=-1)
    neighbors = np.column_stack(
        [padded[rows + 1 + dr, columns + 1 + dc] for dc, dr in STEPS]
    ).astype(np.int32)
    edges = np.where(neighbors >= 0, np.float32(1.0), NO_WAY).astype(np.float32)
    costs = Costs(neighbors, edges, np.zeros((4, 4), np.float32), np.float32(1.0))
    cells = np.column_stack((columns, rows))
    return Roadmap(cells.astype(np.float64), cells, costs, np.ones(len(rows), np.bool_), 1.0)
