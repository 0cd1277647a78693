"""The paths that a robot tells a fleet control; of version 3.0."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timedelta

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_vda5050.messages import IntermediatePath, PathPoint, PlannedPath

MOST_POINTS = 50  # of a path that is told


def planned_path(points_map: FloatArray, nodes: Sequence[str]) -> PlannedPath | None:
    """Return a way as a NURBS of degree 1; None of fewer than two points.

    Args:
        points_map: (n, 2) [m]
        nodes: Ids of the nodes that it passes.
    """
    points = _thinned(points_map)
    if len(points) < 2:
        return None
    knots = [0.0, *np.linspace(0.0, 1.0, len(points)).tolist(), 1.0]
    controls = [{"x": round(x, 3), "y": round(y, 3)} for x, y in points.tolist()]
    trajectory = {"degree": 1, "knotVector": knots, "controlPoints": controls}
    return PlannedPath(trajectory=trajectory, traversed_nodes=tuple(nodes))


def intermediate_path(
    points_map: FloatArray, speed: float, now: datetime
) -> IntermediatePath | None:
    """Return the next piece of a way, with the time at which the robot is at each point.

    Args:
        points_map: (n, 2) [m], from the robot on.
        speed: [m/s] that it drives.
        now: Time of the first point.
    """
    points = _thinned(points_map)
    if len(points) < 2:
        return None
    ways = np.concatenate((np.zeros(1), np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    return IntermediatePath(
        polyline=tuple(
            PathPoint(x=round(x, 3), y=round(y, 3), eta=_text(now + timedelta(seconds=way / speed)))
            for (x, y), way in zip(points.tolist(), ways.tolist(), strict=True)
        )
    )


def _thinned(points_map: FloatArray) -> FloatArray:
    """Return a way with its ends and fewer points between them."""
    if len(points_map) <= MOST_POINTS:
        return points_map
    kept = np.linspace(0, len(points_map) - 1, MOST_POINTS).round().astype(int)
    thinned: FloatArray = points_map[kept]
    return thinned


def _text(time: datetime) -> str:
    return time.isoformat(timespec="milliseconds").replace("+00:00", "Z")
