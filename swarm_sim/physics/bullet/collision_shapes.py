"""Collision shapes of pybullet, of one or several of ours."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pybullet

from swarm_common.model.shapes import Box, Cylinder, Hull, Sphere, Transform, quaternion_of

TYPES = {
    Box: pybullet.GEOM_BOX,
    Cylinder: pybullet.GEOM_CYLINDER,
    Sphere: pybullet.GEOM_SPHERE,
    Hull: pybullet.GEOM_MESH,
}


def compound(client: int, shapes: Sequence[tuple[Any, Transform]]) -> int:
    """Return the id of one collision shape made of several; planes are left out.

    Args:
        shapes: Each with the transform (4, 4) that brings it into the frame of the whole.
    """
    solid = [(shape, transform) for shape, transform in shapes if type(shape) in TYPES]
    places = [position_quaternion(transform) for _, transform in solid]
    with tempfile.TemporaryDirectory() as folder:
        files = [_mesh_file(shape, Path(folder), i) for i, (shape, _) in enumerate(solid)]
        meshes = {"fileNames": files, "meshScales": [[1.0] * 3] * len(files)}
        return int(
            pybullet.createCollisionShapeArray(
                shapeTypes=[TYPES[type(shape)] for shape, _ in solid],
                halfExtents=[
                    [edge / 2 for edge in shape.size] if isinstance(shape, Box) else [0.0, 0.0, 0.0]
                    for shape, _ in solid
                ],
                radii=[getattr(shape, "radius", 0.0) for shape, _ in solid],
                lengths=[getattr(shape, "length", 0.0) for shape, _ in solid],
                collisionFramePositions=[position for position, _ in places],
                collisionFrameOrientations=[quaternion for _, quaternion in places],
                physicsClientId=client,
                **(meshes if any(files) else {}),
            )
        )


def _mesh_file(shape: Any, folder: Path, index: int) -> str:
    """Write a hull to a file for pybullet; return its path, empty for other shapes."""
    if not isinstance(shape, Hull):
        return ""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in shape.vertices]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in shape.faces]
    path = folder / f"{index}.obj"
    path.write_text("\n".join(lines), encoding="utf-8")
    return str(path)


def position_quaternion(transform: Transform) -> tuple[list[float], list[float]]:
    """Return position and unit quaternion x, y, z, w of a transform.

    Args:
        transform: (4, 4), rigid.
    """
    return transform[:3, 3].tolist(), list(quaternion_of(transform[:3, :3]))
