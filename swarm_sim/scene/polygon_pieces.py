"""Polygons with holes as convex pieces."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from swarm_common.model.records import FloatArray

Point = tuple[float, float]
DETAIL = 0.001  # [m] by which a piece with too many corners is simplified at first
MAX_CORNERS = 32  # of a piece
DENT = 0.0005  # [m] mean depth of dents in a polygon that counts as convex
MARGIN = 1e-9  # [m²] of an area, for rounding
DEPTH = 0.005  # [m] depth of the deepest of them, and of the parts cut off a piece's corners


def convex_pieces(polygon: Any) -> list[FloatArray]:
    """Return convex polygons (k, 2), counter-clockwise, that make up a polygon with holes.

    The triangles of a triangulation are joined as long as they stay convex (after Hertel and
    Mehlhorn).

    Returns:
        Each with at most `MAX_CORNERS` corners; dents of a few millimetres are filled.
    """
    if _is_convex(polygon):
        return _rings(shapely.convex_hull(polygon))
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    triangles = shapely.orient_polygons(triangles[shapely.area(triangles) > 0.0])
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    rings = {
        index: [(x, y) for x, y in triangle] for index, triangle in enumerate(corners.tolist())
    }
    owners = {edge: index for index, ring in rings.items() for edge in _edges(ring)}
    for index in list(rings):
        if index in rings:
            _grow(index, rings, owners)
    hulls = [shapely.convex_hull(shapely.Polygon(ring)) for ring in rings.values()]
    return [piece for hull in hulls for piece in _rings(hull)]


def _grow(
    index: int, rings: dict[int, list[Point]], owners: dict[tuple[Point, Point], int]
) -> None:
    """Join one of the rings with its neighbours as long as it stays convex."""
    has_grown = True
    while has_grown:
        has_grown = False
        for a, b in _edges(rings[index]):
            other = owners.get((b, a), index)
            if other == index:
                continue
            joined = _joined(rings[index], rings[other], a, b)
            if not _is_nearly_convex(joined):
                continue
            for edge in (*_edges(rings[index]), *_edges(rings[other])):
                owners.pop(edge, None)
            del rings[other]
            rings[index] = joined
            owners.update(dict.fromkeys(_edges(joined), index))
            has_grown = True
            break


def _edges(ring: list[Point]) -> list[tuple[Point, Point]]:
    return list(zip(ring, [*ring[1:], ring[0]], strict=True))


def _joined(ring: list[Point], other: list[Point], a: Point, b: Point) -> list[Point]:
    """Return two rings as one; the first goes from a to b, the other back."""
    start, back = ring.index(b), other.index(a)
    joined = [*ring[start:], *ring[:start], *[*other[back:], *other[:back]][1:-1]]
    index = 0
    while len(joined) > 3 and index < len(joined):  # there and back along a second common edge
        if joined[index - 1] == joined[(index + 1) % len(joined)]:
            gone = {index, (index + 1) % len(joined)}
            joined = [point for k, point in enumerate(joined) if k not in gone]
            index = 0
        else:
            index += 1
    return joined


def _is_nearly_convex(ring: list[Point]) -> bool:
    points = np.array(ring)
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    if (cross >= 0.0).all():
        turns = np.arctan2(cross, (before * after).sum(axis=1)).sum() / (2.0 * np.pi)
        return bool(turns < 1.5)  # a ring that goes round twice overlaps itself
    return _is_convex(shapely.Polygon(ring))


def _is_convex(polygon: Any) -> bool:
    hull = shapely.convex_hull(polygon)
    dents = hull.area - polygon.area
    if (
        not -MARGIN <= dents < DENT * hull.length
    ):  # what overlaps itself has more area than its hull
        return False
    corners = shapely.points(shapely.get_coordinates(polygon))  # a dent is deepest at a corner
    return bool((shapely.distance(corners, shapely.boundary(hull)) <= DEPTH).all())


def _rings(polygon: Any) -> list[FloatArray]:
    """Return the corners of a convex polygon; of one with too many, of several pieces of it."""
    simple, tolerance = polygon, 1.5 * DETAIL
    while shapely.get_num_coordinates(simple) > MAX_CORNERS + 1 and tolerance <= DEPTH:
        simple = shapely.simplify(polygon, tolerance)
        tolerance *= 1.5
    corners = np.array(shapely.orient_polygons(simple).exterior.coords)[:-1, :2]
    if len(corners) <= MAX_CORNERS:
        return [corners]
    step = MAX_CORNERS - 2
    starts = range(1, len(corners) - 1, step)  # a fan around the first corner
    return [np.vstack([corners[:1], corners[k : k + step + 1]]) for k in starts]
