"""Bodies of pybullet made of any number of our shapes, with wheels and casters if they have any."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
import pybullet

from swarm_common.model.errors import WorldError
from swarm_common.model.records import FloatArray
from swarm_common.model.shapes import Box, Cylinder, Hull, Sphere, Transform, quaternion_of

MOST_SHAPES = 16  # of a `createCollisionShapeArray`: it drops the others without a word
NO_OFFSET: FloatArray = np.zeros(3)
LOCK = 1e-9  # cosine of a pitch below which roll and yaw turn about the same axis
TYPES = {
    Box: pybullet.GEOM_BOX,
    Cylinder: pybullet.GEOM_CYLINDER,
    Sphere: pybullet.GEOM_SPHERE,
    Hull: pybullet.GEOM_MESH,
}
Placed = tuple[Any, Transform]  # a shape, and body_from_shape


@dataclass(frozen=True, slots=True, eq=False)
class BallLink:
    """A ball that hangs on a body: a driven wheel as the ground has it, or a caster."""

    radius: float  # [m]
    mass: float  # [kg]
    place: Transform  # body from ball
    axis: FloatArray | None = None  # on which it turns, in its frame; None if it is stiff


def add_multi_body(
    client: int,
    shapes: Sequence[Placed],
    place: tuple[Sequence[float], Sequence[float]],
    *,
    mass: float = 0.0,
    center: FloatArray = NO_OFFSET,
    balls: Sequence[BallLink] = (),
) -> int:
    """Add a body with all of its shapes; return its id.

    pybullet takes up to `MOST_SHAPES` of them as arguments, which is fast, and any number from a
    URDF.

    Args:
        shapes: In the body's frame; planes are left out.
        place: Position [m] and unit quaternion x, y, z, w of the body's frame in the world.
        mass: [kg] without the balls; nothing moves a body of 0 kg.
        center: (3,) [m] of mass, in the body's frame.
    """
    solid = [(shape, transform) for shape, transform in shapes if type(shape) in TYPES]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = [_mesh_file(shape, folder, i) for i, (shape, _) in enumerate(solid)]
        if len(solid) <= MOST_SHAPES:
            shape = _compound(client, solid, files)
            return _add_few(client, shape, place, mass, center, balls)
        path = folder / "body.urdf"
        lines = _urdf(solid, files, mass, center, balls)
        path.write_text("\n".join(lines), encoding="utf-8")
        position, quaternion = place
        return int(
            pybullet.loadURDF(
                str(path),
                basePosition=position,
                baseOrientation=quaternion,
                flags=pybullet.URDF_USE_IMPLICIT_CYLINDER,
                physicsClientId=client,
            )
        )


def _compound(client: int, solid: Sequence[Placed], files: Sequence[str]) -> int:
    """Return the id of one collision shape made of up to `MOST_SHAPES`."""
    places = [position_quaternion(transform) for _, transform in solid]
    meshes = {"fileNames": files, "meshScales": [[1.0] * 3] * len(files)}
    shape = int(
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
    if solid and shape < 0:
        raise WorldError("the physics engine refuses a shape; simplify it")
    return shape


def _add_few(
    client: int,
    shape: int,
    place: tuple[Sequence[float], Sequence[float]],
    mass: float,
    center: FloatArray,
    balls: Sequence[BallLink],
) -> int:
    """Add a body of one collision shape and its balls; return its id."""
    position, quaternion = place
    links: dict[str, Any] = {}
    if balls:
        count, places = len(balls), [position_quaternion(ball.place) for ball in balls]
        links = {
            "linkMasses": [ball.mass for ball in balls],
            "linkCollisionShapeIndices": [
                pybullet.createCollisionShape(
                    pybullet.GEOM_SPHERE, radius=ball.radius, physicsClientId=client
                )
                for ball in balls
            ],
            "linkVisualShapeIndices": [-1] * count,
            "linkPositions": [position for position, _ in places],
            "linkOrientations": [quaternion for _, quaternion in places],
            "linkInertialFramePositions": [[0.0, 0.0, 0.0]] * count,
            "linkInertialFrameOrientations": [[0.0, 0.0, 0.0, 1.0]] * count,
            "linkParentIndices": [0] * count,
            "linkJointTypes": [
                pybullet.JOINT_FIXED if ball.axis is None else pybullet.JOINT_REVOLUTE
                for ball in balls
            ],
            "linkJointAxis": [
                [0.0, 0.0, 1.0] if ball.axis is None else ball.axis.tolist() for ball in balls
            ],
        }
    return int(
        pybullet.createMultiBody(
            mass,
            shape,
            basePosition=position,
            baseOrientation=quaternion,
            baseInertialFramePosition=center.tolist(),
            physicsClientId=client,
            **links,
        )
    )


def _urdf(
    solid: Sequence[Placed],
    files: Sequence[str],
    mass: float,
    center: FloatArray,
    balls: Sequence[BallLink],
) -> Iterator[str]:
    """Yield the lines of a URDF; pybullet reads no lines of more than 8 kB."""
    yield '<robot name="body"><link name="base">'
    yield _inertial(mass, center)
    for (shape, transform), file in zip(solid, files, strict=True):
        yield f"<collision>{_origin(transform)}<geometry>{_geometry(shape, file)}</geometry>"
        yield "</collision>"
    yield "</link>"
    for index, ball in enumerate(balls):
        yield f'<link name="link_{index}">{_inertial(ball.mass, NO_OFFSET)}<collision><geometry>'
        yield f"{_geometry(Sphere(ball.radius), '')}</geometry></collision></link>"
        kind = "fixed" if ball.axis is None else "continuous"
        yield f'<joint name="joint_{index}" type="{kind}"><parent link="base"/>'
        yield f'<child link="link_{index}"/>{_origin(ball.place)}'
        if ball.axis is not None:
            yield f'<axis xyz="{_words(ball.axis.tolist())}"/>'
        yield "</joint>"
    yield "</robot>"


def _geometry(shape: Any, file: str) -> str:
    if isinstance(shape, Box):
        return f'<box size="{_words(shape.size)}"/>'
    if isinstance(shape, Cylinder):
        return f'<cylinder radius="{_words([shape.radius])}" length="{_words([shape.length])}"/>'
    if isinstance(shape, Sphere):
        return f'<sphere radius="{_words([shape.radius])}"/>'
    return f"<mesh filename={quoteattr(file)}/>"


def _inertial(mass: float, center: FloatArray) -> str:
    """Return the element; pybullet takes the inertia itself from the shapes."""
    return (
        f'<inertial><origin xyz="{_words(center)}"/><mass value="{float(mass)!r}"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def _origin(transform: Transform) -> str:
    """Return the element; pybullet's own angles are off by 1 mrad near a pitch of 90 degrees."""
    turn = transform[:3, :3]
    across = math.hypot(turn[0, 0], turn[1, 0])
    pitch = math.atan2(-turn[2, 0], across)
    if across > LOCK:
        roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    else:  # only their sum or difference counts
        roll, yaw = math.atan2(-turn[1, 2], turn[1, 1]), 0.0
    return f'<origin xyz="{_words(transform[:3, 3])}" rpy="{_words([roll, pitch, yaw])}"/>'


def _words(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)


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
    """Return position and unit quaternion x, y, z, w of a transform."""
    return transform[:3, 3].tolist(), list(quaternion_of(transform[:3, :3]))
