"""A world's geometry after reading: bodies made of primitive shapes, and its named places."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swarm_common.sites import Sites
from swarm_sim.actors import WalkerSpec

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


Shape = Box | Cylinder | Sphere | Plane


@dataclass(frozen=True, slots=True)
class Part:
    """A collision shape of a body."""

    shape: Shape
    body_from_part: Transform


@dataclass(frozen=True, slots=True)
class Body:
    """One link of the world file.

    Attributes:
        name: ``model::link``, as Gazebo names it.
        world_from_body: Where it is at the start.
        parts: Its collision shapes.
        is_static: Whether it can never move.
        mass: [kg]; of no account for static bodies.
    """

    name: str
    world_from_body: Transform
    parts: tuple[Part, ...]
    is_static: bool = True
    mass: float = 1.0


@dataclass(frozen=True, slots=True)
class Scene:
    """What `worlds/<name>` describes.

    Attributes:
        name: Name of the folder or file, also that of the map.
        directory: Folder of the world file, for what it refers to.
        bodies: In file order.
        sites: From `sites.yaml` beside the world file; empty if there is none.
        walkers: From `actors.yaml` beside it.
    """

    name: str
    directory: Path
    bodies: tuple[Body, ...]
    sites: Sites = field(default_factory=Sites)
    walkers: tuple[WalkerSpec, ...] = ()


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
