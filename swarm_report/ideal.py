"""How long each robot's goals would take it alone: shortest ways at full speed, and its services.

Turning and accelerating take no time, so it is a lower bound.
"""

from __future__ import annotations

from collections import defaultdict
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from swarm_common.model.errors import SwarmError
from swarm_common.model.records import FloatArray, Pose
from swarm_describe.robots.loading import load_robot
from swarm_mission.way_table import WayTable
from swarm_report.run import RunData

SERVICES = ("pausing", "charging")


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
    ways: dict[float, WayTable] = {}
    times = {}
    for robot, places in stops.items():
        model = _model(models.get(run.robots[robot]))
        if model is None:
            continue
        radius, speed = model
        path = np.array([series.poses[0, robot, :2], *places]).tolist()
        if np.isfinite(path).all():
            if radius not in ways:
                ways[radius] = WayTable(run.grid, radius, run.grid.resolution)
            way = ways[radius]
            length = sum(way.left(Pose(x, y, 0.0), *a) for a, (x, y) in pairwise(path))
            times[run.robots[robot]] = length / speed + pauses[robot]
    return times


def _model(name: Any) -> tuple[float, float] | None:
    """Return inner radius [m] and full speed [m/s] of a model; None if it is not found."""
    try:
        spec = load_robot(str(name))
    except (SwarmError, OSError):
        return None
    return round(spec.inscribed_radius, 3), spec.max_vel_x
