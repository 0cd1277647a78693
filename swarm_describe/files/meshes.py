"""Mesh files (STL, COLLADA, OBJ and what else trimesh reads) in metres, and their hulls."""

from __future__ import annotations

import functools
import logging
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import DescriptionError
from swarm_common.model.shapes import FloatArray, Hull, Mesh

MIN_EXTENT = 0.001  # [m] of a mesh along its longest side
MAX_EXTENT = 1000.0  # [m] in a world
MAX_OF_LINK = 20.0  # [m] on a robot
MIN_AREA = 1e-9  # [m²] of a triangle of a mesh that a scale makes flat
MAX_FACES = 500_000
# Of a file that is to have faces: STL, OBJ, COLLADA.
FACE = re.compile(rb"^\s*facet\b|^f\s|<(?:triangles|polylist|polygons|trifans|tristrips)\b", re.M)
MAX_HULL_FACES = 400  # finer hulls are approximated from their extreme corners
DIRECTIONS = 200  # in which extreme corners are looked for
THINNEST = 1e-4  # [m] that the hull of a flat mesh is given as thickness


def open_mesh(path: Path) -> tuple[Any, float]:
    """Return the scene of trimesh's in a file, and the length [m] of the file's unit.

    Only COLLADA states a unit; all others count as metres.
    """
    import trimesh  # slow to import, and most worlds and robots have no meshes

    # Else it prints exceptions that it handles: a missing texture, a bad file.
    logging.getLogger("trimesh").setLevel(logging.CRITICAL + 1)
    try:
        scene = trimesh.load_scene(path)
    except Exception as cause:  # whatever a reader of a dozen formats raises at a damaged file
        raise _unreadable(path, cause) from cause
    for item in scene.geometry.values():
        words = str(item.metadata.get("units", "")).split(" * ")
        if len(words) == 2 and words[1] == "meters":
            unit = float(words[0])
            return scene, unit if math.isfinite(unit) and unit > 0.0 else 1.0
    return scene, 1.0


def load_mesh(path: Path, scale: tuple[float, ...], submesh: str = "") -> Mesh:
    """Return the triangles of a file in metres.

    Args:
        submesh: Name of the only part of the file that is wanted; empty for all.
    """
    vertices, faces, unit = _triangles(path, path.stat().st_mtime_ns, submesh)
    if not len(faces):
        return Mesh(vertices, faces, str(path))
    scaled = _scaled(vertices, scale, unit, MAX_EXTENT, path)
    if 0.0 in scale:  # an upright triangle may be a line now
        a, b, c = (scaled[faces[:, k]] for k in range(3))
        faces = faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > MIN_AREA]
    if np.prod(scale) < 0.0:  # mirrored: turn the triangles round
        faces = faces[:, ::-1]
    return Mesh(scaled, faces, str(path))


def load_hull(path: Path, scale: tuple[float, ...]) -> Hull:
    """Return the convex hull of the mesh of a robot's link in a file, in metres."""
    vertices, _, unit = _contents(path.absolute(), path.stat().st_mtime_ns, "")
    return hull_of(_scaled(vertices, scale, unit, MAX_OF_LINK, path), str(path))


def hull_of(points: FloatArray, where: str) -> Hull:
    """Return the convex hull of points.

    Args:
        points: (n, 3) [m]; those of a mesh that is flat along an axis get a thickness of
            `THINNEST`.

    Returns:
        The hull; one of more than `MAX_HULL_FACES` faces is approximated from inside.
    """
    from scipy.spatial import ConvexHull, QhullError  # slow to import

    if len(points) < 4 or not np.isfinite(points).all():
        raise DescriptionError(
            f"{where}: {len(points)} corners span no body; expected 4 or more, finite"
        )
    try:
        hull = ConvexHull(_thickened(points))
        if len(hull.simplices) > MAX_HULL_FACES:
            hull = ConvexHull(_extremes(hull.points[hull.vertices]))
    except (QhullError, ValueError) as cause:
        reason = str(cause).splitlines()[0] if str(cause) else "degenerate"
        raise DescriptionError(f"{where}: the mesh spans no body: {reason}") from None
    return _packed(hull.points, hull.simplices, hull.equations)


def _packed(points: FloatArray, faces: NDArray[np.intc], equations: FloatArray) -> Hull:
    """Return a hull of the corners in use, its faces counter-clockwise from outside."""
    used, renumbered = np.unique(faces, return_inverse=True)
    triangles = renumbered.reshape(faces.shape)
    corners = points[used]
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    is_inward = (np.cross(b - a, c - a) * equations[:, :3]).sum(axis=1) < 0.0
    triangles[is_inward] = triangles[is_inward][:, ::-1]
    return Hull(
        tuple((float(x), float(y), float(z)) for x, y, z in corners),
        tuple((int(i), int(j), int(k)) for i, j, k in triangles),
    )


def _thickened(points: FloatArray) -> FloatArray:
    """Return points that are not all in one plane: a flat mesh gets a back."""
    spread = points.max(axis=0) - points.min(axis=0)
    if spread.min() >= THINNEST or (spread < THINNEST).sum() > 1:
        return points
    back = points.copy()
    back[:, int(np.argmin(spread))] += THINNEST
    return np.vstack([points, back])


def _extremes(corners: FloatArray) -> FloatArray:
    """Return the corners that are the furthest ones in some of many even directions."""
    index = np.arange(DIRECTIONS) + 0.5
    z = 1.0 - 2.0 * index / DIRECTIONS
    angle = np.pi * (1.0 + 5.0**0.5) * index  # Fibonacci lattice on the sphere
    flat = np.sqrt(1.0 - z * z)
    directions = np.vstack(
        [np.column_stack([flat * np.cos(angle), flat * np.sin(angle), z]), np.eye(3), -np.eye(3)]
    )
    furthest: FloatArray = corners[np.unique(np.argmax(directions @ corners.T, axis=1))]
    return furthest


@functools.lru_cache(maxsize=64)
def _contents(
    path: Path, _modified: int, submesh: str
) -> tuple[FloatArray, NDArray[np.int64], float]:
    """Return vertices [m], faces and unit of a file; read once while it does not change."""
    scene, unit = open_mesh(path)
    try:
        mesh = _flattened(scene, submesh, path)
        vertices = np.array(mesh.vertices, dtype=np.float64) * unit
        faces = np.array(mesh.faces, dtype=np.int64)
    except DescriptionError:
        raise
    except Exception as cause:  # of what is no surface, such as a cloud of points
        raise _unreadable(path, cause) from cause
    if not np.isfinite(vertices).all():
        raise DescriptionError(f"{path}: a vertex of the mesh is not a finite number")
    return vertices, faces, unit


@functools.lru_cache(maxsize=64)
def _triangles(
    path: Path, modified: int, submesh: str
) -> tuple[FloatArray, NDArray[np.int64], float]:
    """Return equal vertices [m] of a file as one, faces that have an area, and the unit."""
    vertices, faces, unit = _contents(path, modified, submesh)
    extent = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    if extent > 0.0:
        keys = np.round(vertices / extent * 1e7)
        _, first, merged = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        a, b, c = (faces := merged.ravel()[faces]).T
        vertices, faces = vertices[first], faces[(a != b) & (b != c) & (c != a)]
    if not len(faces) and FACE.search(path.read_bytes()):
        raise DescriptionError(f"{path}: the file speaks of faces, but none can be read")
    if len(faces) > MAX_FACES:
        raise DescriptionError(
            f"{path}: the mesh has {len(faces)} triangles; expected at most {MAX_FACES} for a "
            "collision: simplify it, or use boxes"
        )
    vertices.setflags(write=False)
    faces.setflags(write=False)
    return vertices, faces, unit


def _unreadable(path: Path, cause: Exception) -> DescriptionError:
    return DescriptionError(f"{path}: cannot read the mesh: {cause or type(cause).__name__}")


def _flattened(scene: Any, submesh: str, path: Path) -> Any:
    """Return one mesh of all, or of the one that is asked for."""
    if not submesh:
        return scene.to_mesh()
    names = sorted({*scene.geometry, *scene.graph.nodes_geometry})
    found = [name for name in names if name == submesh]
    found = found or [name for name in names if name.partition("-")[0] == submesh]
    if not found:
        raise DescriptionError(f"{path}: no submesh '{submesh}'; it has {', '.join(names)}")
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        if found[0] in (node, geometry):
            return scene.geometry[geometry].copy().apply_transform(transform)
    raise DescriptionError(f"{path}: the submesh '{submesh}' is not placed in the file's scene")


def _scaled(
    vertices: FloatArray, scale: tuple[float, ...], unit: float, most: float, path: Path
) -> FloatArray:
    """Return vertices times the scale; raise if that makes their extent implausible."""
    scaled: FloatArray = vertices * np.array(scale)
    sides = np.ptp(scaled, axis=0) if len(scaled) else np.full(3, MIN_EXTENT)
    if not MIN_EXTENT <= sides.max() <= most:
        size = " x ".join(f"{side:.4g}" for side in sides)
        factor = " ".join(f"{value:g}" for value in scale)
        stated = f"its unit is {unit:g} m" if unit != 1.0 else "it states no unit but metres"
        raise DescriptionError(
            f"{path}: the mesh is {sides.max():g} m long ({size}) with scale {factor}, and "
            f"{stated}; expected {MIN_EXTENT:g} to {most:g} m: the scale has to make metres of it, "
            "which is 0.001 0.001 0.001 for a file in millimetres"
        )
    return scaled
