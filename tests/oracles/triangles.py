"""Slow twin of everything that a world shows: rays into its raw triangles, by trimesh."""

from collections.abc import Iterable

import numpy as np
import trimesh
from numpy.typing import NDArray

from swarm_common.model.shapes import Box, Cylinder, Hull, Mesh, Part, Shape, Sphere
from swarm_describe.worlds.scene import Body

FloatArray = NDArray[np.float64]
TURN = 0.0123  # [rad] off the axes, so that no ray runs along a wall on the lattice


def body_of(mesh: trimesh.Trimesh, name: str = "soup::link", is_static: bool = True) -> Body:
    """Return a body that is a mesh as it is: nothing welded, nothing mended."""
    shape = Mesh(np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.int64), "soup")
    return Body(name, np.eye(4), (Part(shape, np.eye(4)),), is_static)


def raw(bodies: Iterable[Body]) -> trimesh.Trimesh:
    """Return the triangles of all bodies in the world."""
    meshes = []
    for body in bodies:
        for part in body.parts:
            mesh = _triangles(part.shape)
            if mesh is not None:
                mesh.apply_transform(body.world_from_body @ part.body_from_part)
                meshes.append(mesh)
    return trimesh.util.concatenate(meshes)


def hits(mesh: trimesh.Trimesh, origins: FloatArray, height: float, rays: int) -> FloatArray:
    """Return the points (n, 2) that level rays from origins (m, 2) hit first."""
    angles = TURN + 2.0 * np.pi * np.arange(rays) / rays
    directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(rays)])
    starts = np.column_stack([origins, np.full(len(origins), height)])
    points, _, _ = mesh.ray.intersects_location(
        np.repeat(starts, rays, axis=0), np.tile(directions, (len(starts), 1)), multiple_hits=False
    )
    return np.asarray(points)[:, :2]


def _triangles(shape: Shape) -> trimesh.Trimesh | None:
    if isinstance(shape, Mesh):
        return trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    if isinstance(shape, Hull):
        return trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    if isinstance(shape, Box):
        return trimesh.creation.box(shape.size)
    if isinstance(shape, Cylinder):
        return trimesh.creation.cylinder(shape.radius, shape.length, sections=256)
    if isinstance(shape, Sphere):
        return trimesh.creation.icosphere(subdivisions=5, radius=shape.radius)
    return None
