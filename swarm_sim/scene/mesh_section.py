"""Part of a triangle mesh between two heights, as polygons, which LiDAR, map and robots meet.

`section.py` asks for the convex polygons of that part, seen from above, and joins them with those
of all other shapes; `swarm_sim/sensing/lidar.py` casts its rays on the result.

Any triangles will do: open, given twice, crossing each other, inside out. The shadow of every
triangle counts; seen edge on it is a thin wall. Points that are certainly inside are filled in
addition, so that a solid does not become a hollow shell. A mesh need not be closed, and its faces
may be turned either way: where the inside cannot be decided, a thin wall remains.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from swarm_common.model.records import FloatArray, IntArray
from swarm_common.model.shapes import Mesh, Transform
from swarm_sim.scene.mesh_kernels import crossings, roofed
from swarm_sim.scene.polygon_pieces import convex_pieces

SHEET = 0.002  # [m] on either side of a surface without thickness
DETAIL = 0.001  # [m] by which outlines are simplified
LATTICE = 1e-6  # [m] to which the corners of a cut are rounded, so that equal ones are found
NUDGE = 1.37e-7  # [m] off a height, so that no vertex lies exactly on it
DOT = 10.0 * LATTICE  # [m] of a line, there and back, that is no longer than a point
TINY = float(np.finfo(np.float64).tiny)
MIN_AREA = 1e-6  # [m²] of a polygon


class PlacedMesh:
    """A mesh at a place in the world.

    Attributes:
        points: Vertices (n, 3) in the world.
        faces: (m, 3).
        is_closed: (m,) whether a face belongs to a connected part without a rim.
    """

    def __init__(self, mesh: Mesh, world_from_part: Transform) -> None:
        """Place a mesh.

        Args:
            world_from_part: (4, 4); may mirror.
        """
        self.points = mesh.vertices @ world_from_part[:3, :3].T + world_from_part[:3, 3]
        self.faces = mesh.faces
        if np.linalg.det(world_from_part[:3, :3]) < 0.0:
            self.faces = self.faces[:, ::-1]
        self.is_closed = closed_faces(len(self.points), mesh.faces)

    def in_slab(self, low: float, high: float) -> FloatArray:
        """Return the corners (k, 3, 3) of the triangles of which something lies in a slab."""
        heights = self.points[self.faces, 2]
        is_near = (heights.max(axis=1) >= low) & (heights.min(axis=1) <= high)
        corners: FloatArray = self.points[self.faces[is_near]]
        return corners


def polygons_between(
    mesh: Mesh, world_from_part: Transform, low: float, high: float
) -> tuple[FloatArray, ...]:
    """Return convex polygons (k, 2), counter-clockwise, that cover the mesh inside the slab.

    Args:
        world_from_part: (4, 4); may mirror.
        high: [m] height of the upper end; may equal `low`.
    """
    return _polygons(mesh, tuple(np.ravel(world_from_part[:3]).tolist()), low, high)


@functools.lru_cache(maxsize=512)
def _polygons(
    mesh: Mesh, place: tuple[float, ...], low: float, high: float
) -> tuple[FloatArray, ...]:
    placed = _placed(mesh, place)
    inside = _inside(placed, (low + high) / 2.0 + NUDGE)
    shadows = _shadows(placed.in_slab(low - NUDGE, high + NUDGE), low - NUDGE, high + NUDGE)
    is_flat = shapely.area(shadows) <= LATTICE * shapely.length(shadows)
    # on a lattice, without which GEOS loses whole triangles among nearly equal edges
    union = shapely.union_all([inside, *shadows[~is_flat]], grid_size=LATTICE)
    parts = np.asarray(shapely.get_parts(union))
    parts = parts[shapely.get_dimensions(parts) == 2]
    polygons = _polygons_in(shapely.union_all(parts[~_are_thin(parts)]).simplify(DETAIL))
    # what is not covered so far, for any reason, becomes a thin wall
    # (the tip of a needle is narrower than the lattice)
    lines = np.concatenate([_outlines(shadows[_are_thin(shadows)]), _outlines(parts)])
    bars = _bars(_uncovered(lines, shapely.union_all(polygons)))
    return (*(piece for polygon in polygons for piece in convex_pieces(polygon)), *bars)


@functools.lru_cache(maxsize=128)
def _placed(mesh: Mesh, place: tuple[float, ...]) -> PlacedMesh:
    transform = np.eye(4)
    transform[:3] = np.reshape(place, (3, 4))
    return PlacedMesh(mesh, transform)


def _shadows(corners: FloatArray, low: float, high: float) -> NDArray[Any]:
    """Return the shadows of triangles (n, 3, 3) inside a slab: polygons, lines, points.

    The part of a triangle between two planes is the hull of its corners there and of where its
    edges meet the planes.
    """
    heights = corners[:, :, 2]
    is_in = (heights >= low) & (heights <= high)
    rows, points = [np.nonzero(is_in)[0]], [corners[is_in][:, :2]]
    for i, j in ((0, 1), (1, 2), (2, 0)):
        for level in (low, high):
            a, b = heights[:, i] - level, heights[:, j] - level
            cut = np.flatnonzero(a * b < 0.0)
            share = (a[cut] / (a[cut] - b[cut]))[:, None]
            rows.append(cut)
            points.append(corners[cut, i, :2] + share * (corners[cut, j, :2] - corners[cut, i, :2]))
    index = np.concatenate(rows)
    if not len(index):
        return np.zeros(0, dtype=object)
    order = np.argsort(index, kind="stable")
    _, groups = np.unique(index[order], return_inverse=True)
    points_of_each = shapely.multipoints(np.vstack(points)[order], indices=groups)
    shadows: NDArray[Any] = np.asarray(shapely.convex_hull(points_of_each))
    return shadows


def _are_thin(shapes: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which shapes are narrower in the mean than a surface without thickness is drawn."""
    thin: NDArray[np.bool_] = shapely.area(shapes) <= SHEET * shapely.length(shapes) / 4.0
    return thin


def _outlines(shapes: NDArray[Any]) -> NDArray[Any]:
    is_area = shapely.get_dimensions(shapes) == 2
    outlines = shapes.copy()
    outlines[is_area] = shapely.boundary(shapes[is_area])
    return outlines


def _uncovered(lines: NDArray[Any], area: Any) -> FloatArray:
    """Return the segments (n, 2, 2) of lines and points that are not in an area, or on its rim.

    A line so short that it might vanish on the lattice becomes a segment of length 0.
    """
    if not area.is_empty and len(lines):
        grown = area.buffer(DETAIL + SHEET / 2.0)
        shapely.prepare(grown)
        lines = lines[~shapely.covers(grown, lines)]
        lines = np.asarray(shapely.difference(lines, grown))
        lines = lines[~shapely.is_empty(lines)]
    if not len(lines):
        return np.zeros((0, 2, 2))
    is_dot = shapely.length(lines) <= DOT
    noded = shapely.union_all(lines[~is_dot], grid_size=LATTICE)
    merged = shapely.simplify(shapely.get_parts(shapely.line_merge(noded)), DETAIL)
    dots = shapely.get_coordinates(shapely.centroid(lines[is_dot]))
    dots = np.unique(np.round(dots / DETAIL) * DETAIL, axis=0)
    return np.concatenate([_segments(merged), np.stack([dots, dots], axis=1)])


def _segments(lines: NDArray[Any]) -> FloatArray:
    """Return the segments (n, 2, 2) [m] of lines."""
    coordinates, line = shapely.get_coordinates(lines, return_index=True)
    follows = np.flatnonzero(line[1:] == line[:-1])
    segments: FloatArray = np.stack([coordinates[follows], coordinates[follows + 1]], axis=1)
    return segments


def _bars(segments: FloatArray) -> list[FloatArray]:
    """Return a rectangle, counter-clockwise, around each segment (n, 2, 2); a square if a point."""
    along = segments[:, 1] - segments[:, 0]
    length = np.hypot(*along.T)[:, None]
    ahead = SHEET * np.where(length > 0.0, along / np.maximum(length, TINY), (1.0, 0.0))
    left = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    a, b = segments[:, 0] - ahead, segments[:, 1] + ahead
    return list(np.stack([a - left, b - left, b + left, a + left], axis=1))


def _inside(placed: PlacedMesh, level: float) -> Any:
    """Return the part of a plane at a height that is inside the closed parts.

    The lines in which the parts meet the plane divide it into cells. One of them is inside if the
    lines wind around it, or if it is inside by the odd number of lines on the way out of it, each
    counted as often as it is there, or once (solids whose faces are given twice, front and back);
    and if there is something of the parts below and above it: a ring of walls is no solid.
    """
    faces = placed.faces[placed.is_closed]
    segments = _cut(placed.points, faces, level)
    if not len(segments):
        return shapely.Polygon()
    lines = shapely.linestrings(np.round(segments / LATTICE) * LATTICE)
    noded = shapely.union_all(lines, grid_size=LATTICE)
    cells = np.asarray(shapely.get_parts(shapely.polygonize(shapely.get_parts(noded))))
    cells = cells[shapely.area(cells) > MIN_AREA]
    if not len(cells):
        return shapely.Polygon()
    within = shapely.get_coordinates(shapely.point_on_surface(cells))
    winding, count = crossings(within, segments)
    _, once = crossings(within, _even(_segments(shapely.get_parts(noded))))
    is_in = (winding != 0) | (count % 2 == 1) | (once % 2 == 1)
    cells, within = cells[is_in], within[is_in]
    is_in = roofed(within, level, placed.points, faces)
    return shapely.union_all(cells[is_in])


def _even(segments: FloatArray) -> FloatArray:
    """Return the segments (n, 2, 2) of those connected figures in which an even number meet."""
    if not len(segments):
        return segments
    keys = np.round(segments.reshape(-1, 2) / LATTICE).astype(np.int64)
    nodes, ends = np.unique(keys, axis=0, return_inverse=True)
    ends = ends.reshape(-1, 2)
    size = (len(nodes), len(nodes))
    links = coo_matrix((np.ones(len(ends), np.int8), ends.T), shape=size)
    labels = connected_components(links, directed=False)[1]
    is_odd = np.bincount(ends.ravel(), minlength=len(nodes)) % 2 == 1
    bad = np.unique(labels[is_odd])
    kept: FloatArray = segments[~np.isin(labels[ends[:, 0]], bad)]
    return kept


def _cut(points: FloatArray, faces: IntArray, level: float) -> FloatArray:
    """Return the segments (n, 2, 2) in which triangles meet a plane at a height.

    Each has the inner side of its triangle on its left.
    """
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
    a, b, c = (points[crossing[:, k]] for k in range(3))
    outward = np.cross(b - a, c - a)
    along = ends[:, 1] - ends[:, 0]
    is_reversed = along[:, 1] * outward[:, 0] - along[:, 0] * outward[:, 1] < 0.0
    ends[is_reversed] = ends[is_reversed][:, ::-1]
    segments: FloatArray = ends[(count == 2) & (ends[:, 0] != ends[:, 1]).any(axis=1)]
    return segments


def closed_faces(count: int, faces: IntArray) -> NDArray[np.bool_]:
    """Return for each face whether its connected part has no rim.

    Args:
        faces: (m, 3); equal vertices have equal indices.
    """
    edges = np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    links = coo_matrix((np.ones(len(edges), np.int8), edges.T), shape=(count, count))
    parts, labels = connected_components(links, directed=False)
    keys, uses = np.unique(edges[:, 0] * count + edges[:, 1], return_counts=True)
    has_rim = np.zeros(parts, np.bool_)
    has_rim[labels[keys[uses % 2 == 1] // count]] = True
    is_closed: NDArray[np.bool_] = ~has_rim[labels[faces[:, 0]]]
    return is_closed


def _polygons_in(area: Any) -> list[Any]:
    """Return the polygons in a geometry that are worth it."""
    parts = [shapely.buffer(part, 0.0) for part in shapely.get_parts(area)]
    return [
        polygon
        for part in parts
        for polygon in shapely.get_parts(part)
        if polygon.geom_type == "Polygon" and polygon.area > MIN_AREA
    ]
