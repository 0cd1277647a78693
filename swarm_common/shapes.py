"""Collision shapes and where they sit: the vocabulary of world files and robot descriptions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Transform = FloatArray  # homogeneous (4, 4)


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
    """Convex body: the hull of a mesh.

    Attributes:
        vertices: Its corners in its frame.
        faces: Triangles of indices into them, counter-clockwise seen from outside.
    """

    vertices: tuple[tuple[float, float, float], ...]
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


Shape = Box | Cylinder | Sphere | Plane | Hull


@dataclass(frozen=True, slots=True)
class Part:
    """A collision shape of a body."""

    shape: Shape
    body_from_part: Transform


def transform_from_xyz_rpy(x: float, y: float, z: float, r: float, p: float, w: float) -> Transform:
    """Return the transform of an SDF or URDF pose: fixed-axis roll, pitch, yaw."""
    cr, sr, cp, sp, cw, sw = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(w), np.sin(w)
    return np.array(
        [
            [cw * cp, cw * sp * sr - sw * cr, cw * sp * cr + sw * sr, x],
            [sw * cp, sw * sp * sr + cw * cr, sw * sp * cr - cw * sr, y],
            [-sp, cp * sr, cp * cr, z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
