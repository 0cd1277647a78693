"""Flat views of a scene: bodies between two heights as convex polygons and discs.

At one height this is what a LiDAR sees and a map shows; over a robot's height it is what the
robot can touch.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_common.model.shapes import Box, Cylinder, Hull, Mesh, Shape, Sphere, Transform
from swarm_describe.worlds.scene import Body

RIM_POINTS = 24  # corners that stand for the rim of a cylinder that is not upright
UPRIGHT = 1.0 - 1e-9


@dataclass(frozen=True, slots=True)
class Section:
    """Obstacles in the plane."""

    polygons: tuple[FloatArray, ...]  # convex, counter-clockwise, each (k, 2) [m]
    discs: FloatArray  # (m, 3): x, y, radius [m]
    names: tuple[str, ...]  # name of the body of each polygon, then of each disc

    def segments(self) -> FloatArray:
        """Return the polygons' edges (n, 4): x0, y0, x1, y1."""
        edges = [np.hstack([p, np.roll(p, -1, axis=0)]) for p in self.polygons]
        return np.vstack(edges) if edges else np.zeros((0, 4))

    def outlines(self, rim_points: int = RIM_POINTS) -> tuple[FloatArray, ...]:
        """Return polygons and, as polygons drawn around them, discs.

        Args:
            rim_points: Corners of the polygon that is drawn around a disc.
        """
        return self.polygons + tuple(_around_disc(disc, rim_points) for disc in self.discs)

    def bounds(self) -> tuple[float, float, float, float]:
        """Return x_min, y_min, x_max, y_max of all obstacles; zeros if there are none."""
        outlines = self.outlines()
        if not outlines:
            return 0.0, 0.0, 0.0, 0.0
        points = np.vstack(outlines)
        (x_min, y_min), (x_max, y_max) = points.min(axis=0), points.max(axis=0)
        return float(x_min), float(y_min), float(x_max), float(y_max)


def joined(*sections: Section) -> Section:
    """Return one section with the polygons and discs of several."""
    polygons = [(p, n) for s in sections for p, n in zip(s.polygons, s.names, strict=False)]
    discs = [n for s in sections for n in s.names[len(s.polygons) :]]
    return Section(
        tuple(polygon for polygon, _ in polygons),
        np.vstack([np.zeros((0, 3)), *(s.discs for s in sections)]),
        (*(name for _, name in polygons), *discs),
    )


def section_between(bodies: Iterable[Body], low: float, high: float) -> Section:
    """Return the bodies between two heights, seen from above, without planes (the ground).

    Args:
        bodies: At their places; the section is in their frame.
        high: [m] height of the upper end; may equal `low` for the cut of a plane.

    Returns:
        Polygons are convex; upright cylinders and spheres are discs.
    """
    polygons: list[FloatArray] = []
    discs: list[tuple[float, float, float]] = []
    polygon_names: list[str] = []
    disc_names: list[str] = []
    for body in bodies:
        for part in body.parts:
            world_from_part = body.world_from_body @ part.body_from_part
            if isinstance(part.shape, Mesh):
                from swarm_sim.scene.mesh_section import polygons_between  # needs slow imports

                pieces = polygons_between(part.shape, world_from_part, low, high)
                polygons.extend(pieces)
                polygon_names.extend([body.name] * len(pieces))
                continue
            disc = _disc(part.shape, world_from_part, low, high)
            if disc is not None:
                discs.append(disc)
                disc_names.append(body.name)
                continue
            polygon = _polygon(part.shape, world_from_part, low, high)
            if polygon is not None:
                polygons.append(polygon)
                polygon_names.append(body.name)
    return Section(
        tuple(polygons),
        np.array(discs, dtype=np.float64).reshape(-1, 3),
        tuple(polygon_names + disc_names),
    )


def _disc(
    shape: Shape, world_from_part: Transform, low: float, high: float
) -> tuple[float, float, float] | None:
    x, y, z = world_from_part[:3, 3]
    if isinstance(shape, Sphere):
        offset = max(low - z, z - high, 0.0)  # of the sphere's centre from the slab
        if offset < shape.radius:
            return float(x), float(y), float(np.sqrt(shape.radius**2 - offset**2))
    elif isinstance(shape, Cylinder) and abs(world_from_part[2, 2]) > UPRIGHT:
        if z - shape.length / 2 <= high and z + shape.length / 2 >= low:
            return float(x), float(y), shape.radius
    return None


def _polygon(
    shape: Shape, world_from_part: Transform, low: float, high: float
) -> FloatArray | None:
    if isinstance(shape, Box):
        half = np.array(shape.size) / 2
        corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * half
        edges = [(a, b) for a, b in combinations(range(8), 2) if (a ^ b) in (1, 2, 4)]
    elif isinstance(shape, Cylinder) and abs(world_from_part[2, 2]) <= UPRIGHT:
        rim = _around_disc(np.array([0.0, 0.0, shape.radius]), RIM_POINTS)
        z = np.full((RIM_POINTS, 1), shape.length / 2)
        corners = np.vstack([np.hstack([rim, -z]), np.hstack([rim, z])])
        ring = [*pairwise(range(RIM_POINTS)), (RIM_POINTS - 1, 0)]
        edges = [(i + k, j + k) for i, j in ring for k in (0, RIM_POINTS)]
        edges += [(i, i + RIM_POINTS) for i in range(RIM_POINTS)]
    elif isinstance(shape, Hull):
        corners, edges = np.array(shape.vertices), shape.edges()
    else:
        return None
    points = corners @ world_from_part[:3, :3].T + world_from_part[:3, 3]
    return _hull_between(points, edges, low, high)


def _hull_between(
    points: FloatArray, edges: list[tuple[int, int]], low: float, high: float
) -> FloatArray | None:
    """Return the outline, from above, of the part of a convex body inside a slab."""
    inside = [tuple(p[:2]) for p in points if low <= p[2] <= high]
    for a, b in edges:
        for level in (low, high):
            za, zb = points[a, 2] - level, points[b, 2] - level
            if za * zb < 0.0:
                share = za / (za - zb)
                inside.append(tuple(points[a, :2] + share * (points[b, :2] - points[a, :2])))
    hull = convex_hull(np.array(inside).reshape(-1, 2))
    return hull if len(hull) >= 3 else None


def convex_hull(points: FloatArray) -> FloatArray:
    """Return the corners of the convex hull, counter-clockwise (Andrew's monotone chain).

    Returns:
        (k, 2), rounded to 1e-9; fewer than 3 corners if all points lie on a line.
    """
    ordered = sorted({(round(float(x), 9), round(float(y), 9)) for x, y in points})
    if len(ordered) < 3:
        return np.array(ordered).reshape(-1, 2)

    def chain(sequence: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
        """Return one side of the hull, without its last corner.

        Args:
            sequence: The points from one end to the other, in order of x, then y.
        """
        hull: list[tuple[float, float]] = []
        for p in sequence:
            while len(hull) >= 2 and _turn(hull[-2], hull[-1], p) <= 1e-12:
                hull.pop()
            hull.append(p)
        return hull[:-1]

    return np.array(chain(ordered) + chain(reversed(ordered)))


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _around_disc(disc: FloatArray, count: int) -> FloatArray:
    angles = 2.0 * np.pi * np.arange(count) / count
    radius = disc[2] / np.cos(np.pi / count)
    outline: FloatArray = disc[:2] + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return outline
