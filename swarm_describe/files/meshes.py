"""Reading of mesh files (.dae, .stl, .obj, ...) for collisions."""

from __future__ import annotations

import functools
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import WorldError
from swarm_common.model.shapes import FloatArray, Hull, Mesh
from swarm_describe.files.hulls import quiet_trimesh

MIN_EXTENT = 0.001  # [m] of a mesh along its longest side
MAX_EXTENT = 1000.0  # [m]
MIN_AREA = 1e-9  # [m²] of a triangle of a mesh that a scale makes flat
MAX_FACES = 500_000
# Of a file that is to have faces: STL, OBJ, COLLADA.
FACE = re.compile(rb"^\s*facet\b|^f\s|<(?:triangles|polylist|polygons|trifans|tristrips)\b", re.M)


def load_mesh(path: Path, scale: tuple[float, ...], submesh: str = "") -> Mesh:
    """Return the triangles of a file in metres.

    Args:
        submesh: Name of the only part of the file that is wanted; empty for all.
    """
    vertices, faces = _triangles(path, path.stat().st_mtime_ns, submesh)
    if not len(faces):
        return Mesh(vertices, faces, str(path))
    scaled = vertices * np.array(scale)
    extent = float(np.ptp(scaled, axis=0).max())
    if not MIN_EXTENT <= extent <= MAX_EXTENT:
        factor = " ".join(f"{value:g}" for value in scale)
        raise WorldError(
            f"{path}: the mesh is {extent:g} m long with <scale> {factor}; "
            f"expected {MIN_EXTENT:g} to {MAX_EXTENT:g} m{_advice(extent)}"
        )
    if 0.0 in scale:  # an upright triangle may be a line now
        a, b, c = (scaled[faces[:, k]] for k in range(3))
        faces = faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > MIN_AREA]
    if np.prod(scale) < 0.0:  # mirrored: turn the triangles round
        faces = faces[:, ::-1]
    return Mesh(scaled, faces, str(path))


def hull_of(mesh: Mesh) -> Hull:
    """Return the convex hull of a mesh."""
    import trimesh

    try:
        hull = trimesh.convex.convex_hull(mesh.vertices)
    except Exception as cause:  # whatever Qhull raises at flat or tiny things
        raise WorldError(f"{mesh.source}: the mesh has no volume; give it a thickness") from cause
    vertices = tuple((float(x), float(y), float(z)) for x, y, z in hull.vertices)
    return Hull(vertices, tuple((int(a), int(b), int(c)) for a, b, c in hull.faces))


@functools.lru_cache(maxsize=64)
def _triangles(path: Path, _modified: int, submesh: str) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return vertices [m] and faces of a file; read once while it does not change."""
    import trimesh  # slow to import, and most worlds have no meshes

    quiet_trimesh()

    try:
        scene = trimesh.load_scene(path)
        mesh = _flattened(scene, submesh, path)
    except WorldError:
        raise
    except Exception as cause:  # whatever a reader raises at a damaged file
        raise WorldError(
            f"{path}: cannot read the mesh: {cause or type(cause).__name__}"
        ) from cause
    vertices, faces = _welded(
        np.array(mesh.vertices, dtype=np.float64) * _metres(mesh, scene),
        np.array(mesh.faces, dtype=np.int64),
    )
    if not len(faces) and FACE.search(path.read_bytes()):
        raise WorldError(f"{path}: the file speaks of faces, but none can be read")
    if len(faces) > MAX_FACES:
        raise WorldError(
            f"{path}: the mesh has {len(faces)} triangles; expected at most {MAX_FACES} for a "
            "collision: simplify it, or use boxes"
        )
    if not np.isfinite(vertices).all():
        raise WorldError(f"{path}: a vertex of the mesh is not a finite number")
    vertices.setflags(write=False)
    faces.setflags(write=False)
    return vertices, faces


def _welded(vertices: FloatArray, faces: NDArray[np.int64]) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return a mesh in which equal vertices are one, and triangles without area are gone."""
    extent = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    if not math.isfinite(extent) or extent == 0.0:
        return vertices, faces
    keys = np.round(vertices / extent * 1e7)
    _, first, merged = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    faces = merged.ravel()[faces]
    a, b, c = faces.T
    return vertices[first], faces[(a != b) & (b != c) & (c != a)]


def _flattened(scene: Any, submesh: str, path: Path) -> Any:
    """Return one mesh of all, or of the one that is asked for."""
    if not submesh:
        return scene.to_mesh()
    names = sorted({*scene.geometry, *scene.graph.nodes_geometry})
    found = [name for name in names if name == submesh]
    found = found or [name for name in names if name.partition("-")[0] == submesh]
    if not found:
        raise WorldError(f"{path}: no submesh '{submesh}'; it has {', '.join(names)}")
    wanted = {found[0]}
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        if wanted & {node, geometry}:
            return scene.geometry[geometry].copy().apply_transform(transform)
    raise WorldError(f"{path}: the submesh '{submesh}' is not placed in the file's scene")


def _metres(mesh: Any, scene: Any) -> float:
    """Return the length of a file's unit, which only COLLADA states."""
    for item in (mesh, *scene.geometry.values()):
        words = str(item.metadata.get("units", "")).split(" * ")
        if len(words) == 2 and words[1] == "meters":
            factor = float(words[0])
            return factor if math.isfinite(factor) and factor > 0.0 else 1.0
    return 1.0


def _advice(extent: float) -> str:
    if MIN_EXTENT <= extent / 1000.0 <= MAX_EXTENT:
        return ": is the file in millimetres? then <scale> is 0.001 0.001 0.001"
    return ""
