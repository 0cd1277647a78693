"""Layouts of fleet controls (VDMA Layout Interchange Format, LIF): written, and made worlds of.

A world's stations, places and circuits become nodes. Edges join neighbouring nodes between which a
robot fits straight on, in both directions; those of a circuit lead one way round. Parts of the
layout that no straight line joins are joined by the shortest edge all the same: robots of this
project plan their own way between nodes.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, QhullError

from swarm_common.files.layout_io import LayoutNode, TrackLayout, read_layout
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import FREE, Grid
from swarm_common.model.records import FloatArray, Pose, wrap_angle
from swarm_common.model.shapes import Box
from swarm_common.model.sites import Sites
from swarm_map.floor_plan import LIMIT, FloorPlan, Thing, rounded

MARGIN = 3.0  # [m] between the outermost nodes of a layout and the walls around them
THICKNESS = 0.15  # [m] of these
ROOM = 0.05  # [m] beside a robot on an edge
LARGEST_YAW = 3.141592  # [rad] of a heading that is written: no more than π when it is read


def load_layout(path: Path, wall_height: float, layout_id: str | None = None) -> FloorPlan:
    """Return the plan of an empty hall around a layout: its stations, its other nodes as places.

    Args:
        wall_height: [m]
        layout_id: Of the layout; None for the only one in the file.

    Raises:
        ConfigError: If it is none, or it has to be said which layout is meant.
    """
    layout, file = read_layout(path, layout_id)
    here = [node for node in layout.nodes if node.map_id == layout.map_id]
    nodes = {node.node_id: node for node in here}
    if len(nodes) != len(here):
        raise ConfigError(f"{path}: a nodeId occurs twice")
    stations, used = _stations(path, layout, nodes)
    places = [node.pose for node in nodes.values() if node.node_id not in used]
    poses = np.array([node.pose for node in nodes.values()])
    if not np.isfinite(poses).all() or np.abs(poses[:, :2]).max() > LIMIT:
        raise ConfigError(f"{path}: a node is not within {LIMIT:g} m of the origin")
    sites: dict[str, Any] = {"stations": stations} if stations else {}
    sites |= {"places": places} if places else {}
    notes = [f"{path} has no walls: the hall around it is empty"]
    if layout.map_id:
        notes.append(f"orders of a fleet control have the mapId '{layout.map_id}'")
    if left := len(layout.nodes) - len(here):
        notes.append(f"{left} nodes on other maps are left out")
    return FloorPlan(path.stem, _hall(poses, wall_height), sites, tuple(notes), layout=file)


def _stations(
    path: Path, layout: TrackLayout, nodes: dict[str, LayoutNode]
) -> tuple[dict[str, list[float]], set[str]]:
    """Return the stations by name, one for each of their nodes, and these nodes' ids."""
    stations: dict[str, list[float]] = {}
    used: set[str] = set()
    for station in layout.stations:
        several = len(station.interaction_node_ids) > 1
        for number, node_id in enumerate(station.interaction_node_ids, 1):
            if node_id not in nodes and node_id in {node.node_id for node in layout.nodes}:
                continue  # on another map
            if node_id not in nodes:
                raise ConfigError(f"{path}: station '{station.station_id}' has no node '{node_id}'")
            stations[station.station_id + (f"_{number}" if several else "")] = nodes[node_id].pose
            used.add(node_id)
    return stations, used


def _hall(poses: FloatArray, height: float) -> tuple[Thing, ...]:
    x0, y0 = poses[:, :2].min(axis=0) - MARGIN
    x1, y1 = poses[:, :2].max(axis=0) + MARGIN
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]
    return tuple(
        Thing(
            f"wall_{number}",
            Box((rounded(math.dist(start, end) + THICKNESS), THICKNESS, height)),
            rounded((start[0] + end[0]) / 2.0),
            rounded((start[1] + end[1]) / 2.0),
            yaw=math.atan2(end[1] - start[1], end[0] - start[0]),
        )
        for number, (start, end) in enumerate(pairwise(corners), 1)
    )


def layout_of(name: str, sites: Sites, grid: Grid, radius: float, robot: str) -> dict[str, Any]:
    """Return the layout of a world.

    Args:
        name: Name of the world; its map has this mapId.
        grid: Map of the world.
        radius: [m] of a robot.
        robot: Its model, as the only vehicle type.

    Raises:
        ConfigError: If the world has no place to make a node of.
    """
    nodes = {**sites.stations, **{f"place_{i}": pose for i, pose in enumerate(sites.places, 1)}}
    one_way: list[tuple[str, str]] = []
    for circuit, points in sites.circuits.items():
        names = [f"{circuit}_{number}" for number in range(1, len(points) + 1)]
        ring = zip(points, (*points[1:], points[0]), strict=True)
        yaws = [math.atan2(after[1] - at[1], after[0] - at[0]) for at, after in ring]
        nodes |= {n: Pose(*p, yaw) for n, p, yaw in zip(names, points, yaws, strict=True)}
        one_way += zip(names, (*names[1:], names[0]), strict=True)
    if not nodes:
        raise ConfigError(f"world {name} has no stations, places and circuits to make nodes of")
    edges = _edges(nodes, one_way, grid, radius + ROOM)
    return {
        "metaInformation": {
            "projectIdentification": name,
            "creator": "swarm-map",
            "exportTimestamp": datetime.now(UTC).isoformat(timespec="seconds"),
            "lifVersion": "1.0.0",
        },
        "layouts": [
            {
                "layoutId": name,
                "layoutVersion": "1",
                "nodes": [_node(node, pose, name, robot) for node, pose in nodes.items()],
                "edges": [_edge(start, end, robot) for start, end in edges],
                "stations": [_station(each, pose) for each, pose in sites.stations.items()],
            }
        ],
    }


def _heading(yaw: float) -> float:
    """Return a heading [rad] within ±π, also after rounding."""
    return min(max(rounded(wrap_angle(yaw)), -LARGEST_YAW), LARGEST_YAW)


def _node(node_id: str, pose: Pose, map_id: str, robot: str) -> dict[str, Any]:
    properties = {"vehicleTypeId": robot, "theta": _heading(pose.yaw)}
    return {
        "nodeId": node_id,
        "mapId": map_id,
        "nodePosition": {"x": pose.x, "y": pose.y},
        "vehicleTypeNodeProperties": [properties],
    }


def _edge(start: str, end: str, robot: str) -> dict[str, Any]:
    return {
        "edgeId": f"{start}__{end}",
        "startNodeId": start,
        "endNodeId": end,
        "vehicleTypeEdgeProperties": [{"vehicleTypeId": robot, "rotationAllowed": True}],
    }


def _station(name: str, pose: Pose) -> dict[str, Any]:
    place = {"x": pose.x, "y": pose.y, "theta": _heading(pose.yaw)}
    return {
        "stationId": name,
        "stationName": name,
        "interactionNodeIds": [name],
        "stationPosition": place,
    }


def _edges(
    nodes: dict[str, Pose], one_way: list[tuple[str, str]], grid: Grid, clearance: float
) -> list[tuple[str, str]]:
    names = list(nodes)
    points = np.array([(pose.x, pose.y) for pose in nodes.values()])
    is_free = distance_transform_edt(grid.cells == FREE) * grid.resolution >= clearance
    given = {frozenset(edge) for edge in one_way}
    pairs = [
        (i, j)
        for i, j in _neighbours(points)
        if frozenset((names[i], names[j])) not in given
        and _is_clear(points[i], points[j], grid, is_free)
    ]
    index = {name: number for number, name in enumerate(names)}
    known = [*pairs, *((index[start], index[end]) for start, end in one_way)]
    pairs += _bridges(points, known)
    both_ways = [(names[i], names[j]) for pair in pairs for i, j in (pair, pair[::-1])]
    return [*one_way, *both_ways]


def _neighbours(points: FloatArray) -> list[tuple[int, int]]:
    """Return the pairs of points that are neighbours in a Delaunay triangulation."""
    count = len(points)
    try:
        corners = Delaunay(points).simplices
    except (QhullError, ValueError):  # fewer than three, or all on a line
        order = np.lexsort((points[:, 1], points[:, 0]))
        return [(int(i), int(j)) for i, j in pairwise(order)] if count > 1 else []
    return sorted({(min(i, j), max(i, j)) for t in corners.tolist() for i in t for j in t if i < j})


def _is_clear(start: FloatArray, end: FloatArray, grid: Grid, is_free: NDArray[np.bool_]) -> bool:
    """Whether a robot fits along the line between two points; the ends do not count."""
    steps = max(2, math.ceil(math.dist(start, end) / grid.resolution))
    line = start + np.linspace(0.0, 1.0, steps + 1)[1:-1, None] * (end - start)
    return all(grid.contains(x, y) and bool(is_free[grid.cell_of(x, y)]) for x, y in line.tolist())


def _bridges(points: FloatArray, pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the shortest further pairs that make one whole of all points."""
    found: list[tuple[int, int]] = []
    count = len(points)
    apart = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    while True:
        ends = np.array([*pairs, *found], int).reshape(-1, 2)
        graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), (count, count))
        parts, label = connected_components(graph, directed=False)
        if parts == 1:
            return found
        others = np.where(label[:, None] == label[None], np.inf, apart)
        i, j = divmod(int(np.argmin(others)), count)
        found.append((i, j))
