"""Mesh files (STL, DAE, OBJ and what else trimesh reads) as convex hulls."""

from __future__ import annotations

import functools
import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import MeshError
from swarm_common.model.shapes import FloatArray, Hull

MAX_FACES = 400  # of a hull; finer ones are approximated from their extreme corners
DIRECTIONS = 200  # in which extreme corners are looked for
THINNEST = 1e-4  # [m] that a flat mesh is given as thickness


def load_hull(path: Path, scale: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Hull:
    """Return the convex hull of the mesh in a file, scaled."""
    return hull_of(_corners(path.absolute()) * np.array(scale), str(path))


def hull_of(points: FloatArray, where: str) -> Hull:
    """Return the convex hull of points.

    Args:
        points: (n, 3) [m]; those of a mesh that is flat along an axis get a thickness of
            `THINNEST`.

    Returns:
        The hull; one of more than `MAX_FACES` faces is approximated from inside.
    """
    from scipy.spatial import ConvexHull, QhullError  # slow to import

    if len(points) < 4 or not np.isfinite(points).all():
        raise MeshError(f"{where}: {len(points)} corners span no body; expected 4 or more, finite")
    try:
        hull = ConvexHull(_thickened(points))
        if len(hull.simplices) > MAX_FACES:
            hull = ConvexHull(_extremes(hull.points[hull.vertices]))
    except (QhullError, ValueError) as cause:
        reason = str(cause).splitlines()[0] if str(cause) else "degenerate"
        raise MeshError(f"{where}: the mesh spans no body: {reason}") from None
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
def _corners(path: Path) -> FloatArray:
    """Return the corners (n, 3) of all parts of a mesh file."""
    import trimesh  # slow to import, and not needed for primitive shapes

    quiet_trimesh()

    if not path.is_file():
        raise MeshError(f"there is no mesh file {path}")
    try:
        mesh = trimesh.load(path, force="mesh")
        corners = np.asarray(mesh.vertices, np.float64)
    except Exception as cause:  # readers of a dozen formats raise whatever they run into
        raise MeshError(f"{path}: not a readable mesh: {type(cause).__name__}: {cause}") from cause
    if corners.ndim != 2 or corners.shape[0] == 0:
        raise MeshError(f"{path}: the mesh is empty")
    return corners


def quiet_trimesh() -> None:
    """Keep trimesh from printing exceptions that it handles (a missing texture, a bad file)."""
    logging.getLogger("trimesh").setLevel(logging.CRITICAL + 1)
