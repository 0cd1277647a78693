"""What of a triangle mesh lies between two heights, from above, as convex polygons.

Closed parts of a mesh count as solid, open ones (walls of single sheets) as thin sheets.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from swarm_sim.scene import Mesh, Transform

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
SHEET = 0.002  # [m] on either side of a surface without thickness
DETAIL = 0.001  # [m] by which outlines are simplified
MAX_CORNERS = 32  # of a piece
NUDGE = 1.37e-7  # [m] off a height, so that no vertex lies exactly on it
MIN_AREA = 1e-6  # [m²] of a polygon
DENT = 0.0005  # [m] mean depth of dents in a polygon that counts as convex


class Placed:
    """A mesh at a place in the world.

    Attributes:
        points: Vertices (n, 3) in the world.
        solids: Faces of each closed part.
        sheets: Faces (m, 3) of all other parts.
    """

    def __init__(self, mesh: Mesh, world_from_part: Transform) -> None:
        self.points = mesh.vertices @ world_from_part[:3, :3].T + world_from_part[:3, 3]
        self.solids, self.sheets = parts_of(len(self.points), mesh.faces)

    def in_slab(self, faces: IntArray, low: float, high: float) -> IntArray:
        """Return the faces of which something lies between two heights."""
        heights = self.points[faces, 2]
        near: IntArray = faces[(heights.max(axis=1) >= low) & (heights.min(axis=1) <= high)]
        return near


def polygons_between(
    mesh: Mesh, world_from_part: Transform, low: float, high: float
) -> tuple[FloatArray, ...]:
    """Return convex polygons (k, 2), counter-clockwise, that cover what lies in the slab."""
    return _polygons(mesh, tuple(np.ravel(world_from_part[:3]).tolist()), low, high)


@functools.lru_cache(maxsize=512)
def _polygons(
    mesh: Mesh, place: tuple[float, ...], low: float, high: float
) -> tuple[FloatArray, ...]:
    placed = _placed(mesh, place)
    areas = list(_fillings(placed, (low + high) / 2.0 + NUDGE))
    for faces, is_solid in [(placed.sheets, False), *((solid, True) for solid in placed.solids)]:
        near = placed.in_slab(faces, low, high)
        if len(near):
            slab = (low - NUDGE, high + NUDGE)
            areas.append(_shadow(placed.points[near], slab, is_solid))
    union = shapely.union_all(areas).simplify(DETAIL)
    return tuple(piece for polygon in _polygons_in(union) for piece in convex_pieces(polygon))


@functools.lru_cache(maxsize=128)
def _placed(mesh: Mesh, place: tuple[float, ...]) -> Placed:
    transform = np.eye(4)
    transform[:3] = np.reshape(place, (3, 4))
    return Placed(mesh, transform)


def _shadow(corners: FloatArray, slab: tuple[float, float], is_solid: bool) -> Any:
    """Return the area under the parts of triangles (n, 3, 3) inside the slab."""
    low, high = slab
    inside = ((corners[:, :, 2] >= low) & (corners[:, :, 2] <= high)).all(axis=1)
    shapes = [_flat(corners[inside, :, :2], is_solid)]
    for triangle in corners[~inside]:
        clipped = _clipped(triangle, low, high)
        if len(clipped) >= 2:
            shapes.append(_flat(clipped[None, :, :2], is_solid))
    return shapely.union_all(np.concatenate(shapes))


def _flat(corners: FloatArray, is_solid: bool) -> NDArray[Any]:
    """Return the hull of each row of corners (n, k, 2); sheets get some thickness."""
    count, size = corners.shape[:2]
    if not count:
        return np.zeros(0, dtype=object)
    points = shapely.multipoints(corners.reshape(-1, 2), indices=np.repeat(np.arange(count), size))
    hulls = np.asarray(shapely.convex_hull(points), dtype=object)
    flat = shapely.area(hulls) < MIN_AREA
    if is_solid:  # what is inside counts anyway
        return np.asarray(hulls[~flat])
    hulls[flat] = shapely.buffer(hulls[flat], SHEET, cap_style="square", join_style="mitre")
    return hulls


def _clipped(triangle: FloatArray, low: float, high: float) -> FloatArray:
    """Return the part of a polygon (n, 3) inside the slab (Sutherland and Hodgman)."""
    points = list(triangle)
    for level, sign in ((low, 1.0), (high, -1.0)):
        kept: list[FloatArray] = []
        for index, b in enumerate(points):
            a = points[index - 1]
            da, db = sign * (a[2] - level), sign * (b[2] - level)
            if da * db < 0.0:
                kept.append(a + da / (da - db) * (b - a))
            if db >= 0.0:
                kept.append(b)
        points = kept
    return np.array(points).reshape(-1, 3)


def _fillings(placed: Placed, level: float) -> Iterator[Any]:
    """Return what a plane cuts out of the closed parts."""
    for faces in placed.solids:
        lines = _cut(placed.points, faces, level)
        if not len(lines):
            continue
        merged = shapely.line_merge(shapely.multilinestrings(shapely.linestrings(lines)))
        area: Any = shapely.Polygon()
        for line in shapely.get_parts(merged):
            if line.is_ring and len(line.coords) >= 4:  # rings inside rings are holes
                area = area.symmetric_difference(shapely.Polygon(line).buffer(0.0))
        if not area.is_empty:
            yield area


def _cut(points: FloatArray, faces: IntArray, level: float) -> FloatArray:
    """Return the segments (n, 2, 2) in which triangles meet a plane at a height."""
    above = points[faces, 2] > level
    crossing = faces[above.any(axis=1) & ~above.all(axis=1)]
    ends = np.zeros((len(crossing), 2, 2))
    count = np.zeros(len(crossing), np.int64)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        a, b = np.sort(crossing[:, [i, j]], axis=1).T  # alike from both sides of an edge
        za, zb = points[a, 2] - level, points[b, 2] - level
        cut = (za > 0.0) != (zb > 0.0)
        share = (za[cut] / (za[cut] - zb[cut]))[:, None]
        at = points[a[cut], :2] + share * (points[b[cut], :2] - points[a[cut], :2])
        rows = np.flatnonzero(cut)
        ends[rows, np.minimum(count[rows], 1)] = np.round(at, 9)
        count[rows] += 1
    segments: FloatArray = ends[(count == 2) & (ends[:, 0] != ends[:, 1]).any(axis=1)]
    return segments


def parts_of(count: int, faces: IntArray) -> tuple[list[IntArray], IntArray]:
    """Return the faces of each connected part of a mesh that has no rim, and all other faces.

    Args:
        count: Number of vertices.
        faces: (m, 3); equal vertices have equal indices.
    """
    edges = np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    links = coo_matrix((np.ones(len(edges), np.int8), edges.T), shape=(count, count))
    labels = connected_components(links, directed=False)[1][faces[:, 0]]
    solids, sheets = [], np.zeros(len(faces), np.bool_)
    for label in np.unique(labels):
        own = labels == label
        _, uses = np.unique(edges[np.tile(own, 3)], axis=0, return_counts=True)
        if (uses % 2 == 0).all():
            solids.append(faces[own])
        else:
            sheets |= own
    return solids, faces[sheets]


def _polygons_in(area: Any) -> list[Any]:
    """Return the polygons in a geometry that are worth it."""
    parts = [shapely.buffer(part, 0.0) for part in shapely.get_parts(area)]
    return [
        polygon
        for part in parts
        for polygon in shapely.get_parts(part)
        if polygon.geom_type == "Polygon" and polygon.area > MIN_AREA
    ]


def convex_pieces(polygon: Any) -> list[FloatArray]:
    """Return convex polygons (k, 2), counter-clockwise, that make up a polygon with holes.

    The triangles of a triangulation are joined as long as they stay convex (after Hertel and
    Mehlhorn).
    """
    if _is_convex(polygon):
        return [_ring(shapely.convex_hull(polygon))]
    pieces = [
        part
        for part in shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
        if part.area > 0.0
    ]
    index = 0
    while index < len(pieces):
        piece = pieces[index]
        for other in range(index + 1, len(pieces)):
            if not shapely.touches(piece, pieces[other]):
                continue
            joined = shapely.union(piece, pieces[other])
            if joined.geom_type == "Polygon" and _is_convex(joined):
                pieces[index] = shapely.convex_hull(joined)
                del pieces[other]
                break
        else:
            index += 1
    return [_ring(piece) for piece in pieces]


def _is_convex(polygon: Any) -> bool:
    hull = shapely.convex_hull(polygon)
    return bool(hull.area - polygon.area < DENT * hull.length)


def _ring(polygon: Any) -> FloatArray:
    tolerance = DETAIL
    while shapely.get_num_coordinates(polygon) > MAX_CORNERS + 1:
        tolerance *= 1.5
        polygon = shapely.simplify(polygon, tolerance)
    corners: FloatArray = np.array(shapely.orient_polygons(polygon).exterior.coords)[:-1, :2]
    return corners
