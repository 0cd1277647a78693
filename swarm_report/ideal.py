"""How long each robot's goals would take it alone: shortest ways at full speed, and its services.

The ways are shortest paths on the map, kept clear of walls by the robot's inner radius (Dijkstra
1959, eight neighbours a cell). Turning and accelerating take no time, so it is a lower bound.
"""

from __future__ import annotations

from collections import defaultdict
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt, zoom
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from swarm_common.model.errors import SwarmError
from swarm_common.model.grid import FREE, Grid
from swarm_common.model.records import FloatArray
from swarm_describe.robots.loading import load_robot
from swarm_report.run import RunData

MOST_CELLS = 40_000  # of the grid that is searched
SERVICES = ("pausing", "charging")
STEPS = ((1, 0), (0, 1), (1, 1), (1, -1))


@lru_cache(maxsize=8)
def ideal_times(run: RunData) -> dict[str, float]:
    """Return by robot the seconds [s] that its reached goals would take it alone.

    Empty without map, time series or goals; robots whose model is not found are left out.
    """
    if run.grid is None or run.series is None or not len(run.series.times):
        return {}
    stops: dict[int, list[FloatArray]] = defaultdict(list)
    series = run.series
    for goal in run.goals:
        if goal.outcome == "reached":
            sample = min(int(np.searchsorted(series.times, goal.time)), len(series.times) - 1)
            stops[goal.robot].append(series.poses[sample, goal.robot, :2])
    models = {robot["name"]: robot.get("model") for robot in run.config.get("robots", [])}
    pauses: dict[int, float] = defaultdict(float)
    for span in run.spans:
        if span.state in SERVICES:
            pauses[span.robot] += span.length
    ways: dict[float, _Ways] = {}
    times = {}
    for robot, places in stops.items():
        model = _model(models.get(run.robots[robot]))
        if model is None:
            continue
        radius, speed = model
        if radius not in ways:
            ways[radius] = _Ways(run.grid, radius)
        search = ways[radius]
        path = [series.poses[0, robot, :2], *places]
        length = sum(search.length(a, b) for a, b in pairwise(path))
        if np.isfinite(length):
            times[run.robots[robot]] = length / speed + pauses[robot]
    return times


def _model(name: Any) -> tuple[float, float] | None:
    """Return inner radius [m] and full speed [m/s] of a model; None if it is not found."""
    try:
        spec = load_robot(str(name))
    except (SwarmError, OSError):
        return None
    corners = np.asarray(spec.footprint)
    after = np.roll(corners, -1, axis=0)
    edges = after - corners
    areas = corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]
    return round(float(np.min(np.abs(areas) / np.hypot(*edges.T))), 3), spec.max_vel_x


class _Ways:
    """Shortest ways on a map for robots of a radius; each goal is searched for once."""

    def __init__(self, grid: Grid, radius: float) -> None:
        shrink = min(1.0, (MOST_CELLS / grid.cells.size) ** 0.5)
        free = zoom((grid.cells == FREE).astype(float), shrink, order=1) > 0.5
        self._size = grid.resolution * grid.cells.shape[1] / free.shape[1]
        self._origin = np.array([grid.origin_x, grid.origin_y])
        clear = distance_transform_edt(free) * self._size > radius
        self._number = np.full(clear.shape, -1)
        self._number[clear] = np.arange(int(clear.sum()))
        rows, columns = np.nonzero(clear)
        self._tree = cKDTree(np.column_stack([columns, rows])) if len(rows) else None
        starts, ends, lengths = [], [], []
        for down, right in STEPS:
            one = self._number[max(0, -down) :, max(0, -right) :]
            other = self._number[max(0, down) :, max(0, right) :]
            height, width = (min(a, b) for a, b in zip(one.shape, other.shape, strict=True))
            one, other = one[:height, :width], other[:height, :width]
            both = (one >= 0) & (other >= 0)
            starts.append(one[both])
            ends.append(other[both])
            lengths.append(np.full(int(both.sum()), self._size * np.hypot(down, right)))
        shape = (len(rows), len(rows))
        weights = np.concatenate(lengths), (np.concatenate(starts), np.concatenate(ends))
        self._graph = coo_matrix(weights, shape).tocsr()
        self._from: dict[int, FloatArray] = {}

    def length(self, start_map: FloatArray, end_map: FloatArray) -> float:
        """Return the length of the way [m]; inf where there is none."""
        if self._tree is None or not (np.isfinite(start_map).all() and np.isfinite(end_map).all()):
            return float("inf")
        start, end = (int(self._tree.query(self._cell(place))[1]) for place in (start_map, end_map))
        if end not in self._from and start in self._from:
            start, end = end, start
        if end not in self._from:
            self._from[end] = dijkstra(self._graph, directed=False, indices=end)
        found = float(self._from[end][start])
        straight = float(np.hypot(*(end_map - start_map)))
        return straight if found == 0.0 else max(straight, found)

    def _cell(self, place_map: FloatArray) -> FloatArray:
        cell: FloatArray = (place_map - self._origin) / self._size - 0.5
        return cell
