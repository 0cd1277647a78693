"""Collision shapes and where they sit: the vocabulary of world files and robot descriptions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Transform = FloatArray  # homogeneous (4, 4)
Color = tuple[float, float, float, float]  # red, green, blue, opacity from 0 to 1


@dataclass(frozen=True, slots=True)
class Box:
    """Box centred on its frame; `size` along x, y, z."""

    size: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Cylinder centred on its frame, axis along z."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Sphere:
    """Sphere centred on its frame."""

    radius: float


@dataclass(frozen=True, slots=True)
class Plane:
    """Half space below the plane through the frame's origin with this normal."""

    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Hull:
    """Convex body: the hull of a mesh."""

    vertices: tuple[tuple[float, float, float], ...]  # its corners in its frame
    # triangles of indices into them, counter-clockwise seen from outside
    faces: tuple[tuple[int, int, int], ...]

    def edges(self) -> list[tuple[int, int]]:
        """Return each edge once, as the indices of its ends."""
        return sorted(
            {
                (min(a, b), max(a, b))
                for face in self.faces
                for a, b in zip(face, (*face[1:], face[0]), strict=True)
            }
        )


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangles in the part's frame; need be neither convex nor closed."""

    vertices: FloatArray  # (n, 3) [m], scale applied
    faces: NDArray[np.int64]  # (m, 3) indices of vertices
    source: str = ""  # file that they come from, or what they stand for


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A mesh that is only to be seen: where it is and by how much it is scaled."""

    path: Path
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    submesh: str = ""


Shape = Box | Cylinder | Sphere | Plane | Hull | Mesh


@dataclass(frozen=True, slots=True)
class Part:
    """A collision shape of a body."""

    shape: Shape
    body_from_part: Transform


@dataclass(frozen=True, slots=True)
class Visual:
    """Appearance of a body."""

    shape: Shape | MeshFile  # a mesh is not loaded
    body_from_visual: Transform  # where it is
    # None where the file says nothing, and for meshes that bring their own
    color: Color | None = None


def transform_from_xyz_rpy(x: float, y: float, z: float, r: float, p: float, w: float) -> Transform:
    """Return the transform (4, 4) of an SDF or URDF pose: fixed-axis roll, pitch, yaw.

    Args:
        r: [rad] roll, about the x axis, first.
        p: [rad] pitch, about the y axis.
        w: [rad] yaw, about the z axis, last.
    """
    cr, sr, cp, sp, cw, sw = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(w), np.sin(w)
    return np.array(
        [
            [cw * cp, cw * sp * sr - sw * cr, cw * sp * cr + sw * sr, x],
            [sw * cp, sw * sp * sr + cw * cr, sw * sp * cr - cw * sr, y],
            [-sp, cp * sr, cp * cr, z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def inverse_of(transform: Transform) -> Transform:
    """Return the inverse of a rigid transform, by sums whose last bits no processor changes."""
    turn, place = transform[:3, :3], transform[:3, 3]
    inverse = np.eye(4)
    inverse[:3, :3] = turn.T
    inverse[:3, 3] = -(turn * place[:, None]).sum(axis=0)
    return inverse


def rotation_of(x: float, y: float, z: float, w: float) -> FloatArray:
    """Return the rotation (3, 3) of a unit quaternion."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of(rotation: FloatArray) -> tuple[float, float, float, float]:
    """Return the unit quaternion x, y, z, w of a rotation.

    Args:
        rotation: (3, 3) orthogonal, of determinant 1.
    """
    m = rotation
    w = math.sqrt(max(0.0, 1.0 + m[0, 0] + m[1, 1] + m[2, 2])) / 2.0
    x = math.sqrt(max(0.0, 1.0 + m[0, 0] - m[1, 1] - m[2, 2])) / 2.0
    y = math.sqrt(max(0.0, 1.0 - m[0, 0] + m[1, 1] - m[2, 2])) / 2.0
    z = math.sqrt(max(0.0, 1.0 - m[0, 0] - m[1, 1] + m[2, 2])) / 2.0
    return (
        math.copysign(x, m[2, 1] - m[1, 2]),
        math.copysign(y, m[0, 2] - m[2, 0]),
        math.copysign(z, m[1, 0] - m[0, 1]),
        w,
    )
