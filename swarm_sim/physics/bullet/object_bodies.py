"""Concave meshes, things that can be pushed, and vehicles, for pybullet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pybullet
from numpy.typing import NDArray

from swarm_common.model.errors import WorldError
from swarm_common.model.records import FloatArray
from swarm_common.model.shapes import Mesh, Plane, Transform, transform_from_xyz_rpy
from swarm_describe.worlds.scene import GROUND_GAP, Body
from swarm_sim.physics.bullet.collision_shapes import add_multi_body, position_quaternion
from swarm_sim.physics.bullet.fixed_bodies import (
    GROUND,
    LOOSE,
    OBSTACLE,
    ROBOT,
    SOLID,
    add_body,
    add_obstacle,
)
from swarm_sim.physics.objects import Objects
from swarm_sim.scene.mesh_section import SHEET

CHUNK = 20_000  # triangles of a mesh in one body
OVERLAP = 0.01  # [m] by which something loose may reach into something else while it stands
SLIP = 0.1  # [m] by which it may at the start: it is pushed out then
PARTING_STEPS = 200  # of physics in which it has to be
CONTACT_DISTANCE = 8  # field of a contact point
FLOOR = 500.0  # [m] from the origin to the edge of the ground for loose bodies
NARROW = 1e-4  # [m] below which a triangle may have no width in Bullet's single precision
ROLLING = 0.002  # [m] coefficient of rolling friction, so that what rolls comes to rest


def pieces_of(body: Body) -> Iterator[Body]:
    """Yield a body without its planes, concave meshes as bodies of their own.

    Yields:
        Bodies that `add_piece` takes; those of meshes have a single part.
    """
    plain = tuple(part for part in body.parts if not isinstance(part.shape, Mesh | Plane))
    if plain:
        yield replace(body, parts=plain)
    for part in body.parts:
        if isinstance(part.shape, Mesh):
            yield replace(body, parts=(part,))


def add_piece(client: int, piece: Body) -> list[int]:
    """Add what `pieces_of` returns, which stays where it is; return its ids."""
    shape = piece.parts[0].shape
    if not isinstance(shape, Mesh):
        return [add_obstacle(client, piece)]
    place = piece.world_from_body @ piece.parts[0].body_from_part
    heights = shape.vertices @ place[2, :3] + place[2, 3]
    faces = shape.faces[heights[shape.faces].max(axis=1) > GROUND_GAP]  # the rest is ground
    vertices, faces = _with_ribbons(shape.vertices, faces)
    return [
        _add_mesh(client, shape.source, vertices, faces[first : first + CHUNK], place)
        for first in range(0, len(faces), CHUNK)
    ]


def _with_ribbons(
    vertices: FloatArray, faces: NDArray[np.int64]
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Add two crossed ribbons along each needle of a mesh, as thick as a surface is drawn.

    Args:
        vertices: (n, 3) [m].
        faces: (m, 3) indices of their corners.

    Returns:
        Vertices (n + 8 k, 3) and faces (m + 4 k, 3) for k needles.
    """
    corners = vertices[faces]
    edges = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(edges, axis=2)
    longest = lengths.argmax(axis=1)
    length = lengths.max(axis=1)
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)  # twice the triangle's
    needles = np.flatnonzero((area < NARROW * length) & (length > 0.0))
    start, along = corners[needles, longest[needles]], edges[needles, longest[needles]]
    ahead = along / length[needles, None]
    axis = np.eye(3)[np.abs(ahead).argmin(axis=1)]
    left = np.cross(ahead, axis)
    left *= SHEET / np.linalg.norm(left, axis=1)[:, None]
    up = np.cross(ahead, left)
    ribbons = [
        np.stack([start + side, start - side, start + along + side, start + along - side], axis=1)
        for side in (left, up)
    ]
    added = np.concatenate(ribbons).reshape(-1, 3)
    first = len(vertices) + 4 * np.arange(len(added) // 4)[:, None]
    strips = (first + np.array([0, 1, 2, 1, 3, 2])).reshape(-1, 3)
    return np.concatenate([vertices, added]), np.concatenate([faces, strips])


def _add_mesh(
    client: int, source: str, vertices: FloatArray, faces: NDArray[np.int64], place: Transform
) -> int:
    used, indices = np.unique(faces, return_inverse=True)
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_MESH,
        vertices=vertices[used].tolist(),
        indices=indices.ravel().tolist(),
        flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
        physicsClientId=client,
    )
    if shape < 0:
        raise WorldError(f"{source}: the physics engine refuses the mesh; simplify it")
    return add_body(client, shape, SOLID, place)


class BulletObjects:
    """The bodies of `Objects`: loose ones follow physics, vehicles their script."""

    def __init__(self, client: int, objects: Objects) -> None:
        """Add the bodies of all objects."""
        self._client = client
        self._objects = objects
        self._has_floor = False
        self._centers: list[FloatArray] = []
        self._loose: list[int] = []
        for body in objects.loose:
            self.add(body)
        self._vehicles = [add_obstacle(client, body) for body in objects.vehicles.bodies()]
        for vehicle in self._vehicles:
            pybullet.setCollisionFilterGroupMask(
                vehicle, -1, OBSTACLE, ROBOT, physicsClientId=client
            )

    @property
    def ids(self) -> list[int]:
        """Engine's ids of the bodies in the order of `Objects.names`."""
        return self._loose + self._vehicles

    def add(self, body: Body) -> None:
        """Add a body behind the loose ones; a static one stays where it is."""
        if not body.is_static and not self._has_floor:
            _add_floor(self._client)
            self._has_floor = True
        center = np.zeros(3) if body.is_static else _center(body)
        make = add_obstacle if body.is_static else add_loose
        self._centers.append(center)
        self._loose.append(make(self._client, body))

    def remove(self, index: int) -> None:
        """Remove a loose body; those that stood on it fall."""
        pybullet.removeBody(self._loose.pop(index), physicsClientId=self._client)
        del self._centers[index]
        self._wake()

    def part(self, others: Sequence[tuple[int, str]]) -> None:
        """Push loose bodies out of bodies that they overlap by centimetres; refuse deeper overlaps.

        Bodies move without gathering speed, so that nothing is thrown about.
        """
        if self._deepest(others) <= OVERLAP:
            return
        for _ in range(PARTING_STEPS):
            pybullet.stepSimulation(physicsClientId=self._client)
            for body in self._loose:
                pybullet.resetBaseVelocity(body, [0.0] * 3, [0.0] * 3, self._client)
            if self._deepest(others) <= OVERLAP:
                break
        self.read()

    def _deepest(self, others: Sequence[tuple[int, str]]) -> float:
        """Return by how much [m] something loose reaches into something else at most."""
        deepest = 0.0
        loose = list(zip(self._loose, self._objects.names, strict=False))
        for index, (body, name) in enumerate(loose):
            for other, what in [*dict.fromkeys(others), *loose[index + 1 :]]:
                points = pybullet.getClosestPoints(
                    body, other, 0.0, -1, -1, physicsClientId=self._client
                )
                for point in points or ():
                    deepest = max(deepest, -point[CONTACT_DISTANCE])
                    if point[CONTACT_DISTANCE] < -SLIP:
                        x, y, _ = point[5]
                        raise WorldError(
                            f"'{name}' reaches {-point[CONTACT_DISTANCE]:.2f} m into '{what}' at "
                            f"({x:.2f}, {y:.2f}); move it, or make it static"
                        )
        return deepest

    def put(self, index: int, place: Transform) -> None:
        """Put a loose body elsewhere, where it comes to rest."""
        body, center = self._loose[index], self._centers[index]
        position, quaternion = position_quaternion(place)
        position = (place[:3, 3] + place[:3, :3] @ center).tolist()
        self._wake()
        pybullet.resetBasePositionAndOrientation(body, position, quaternion, self._client)
        pybullet.resetBaseVelocity(body, [0.0] * 3, [0.0] * 3, self._client)
        self._objects.place(index, place)

    def _wake(self) -> None:
        for body in self._loose:
            pybullet.changeDynamics(
                body,
                -1,
                activationState=pybullet.ACTIVATION_STATE_WAKE_UP,
                physicsClientId=self._client,
            )

    def place_vehicles(self) -> None:
        """Move the vehicles' bodies to where the vehicles are."""
        for body, vehicle in zip(self._vehicles, self._objects.vehicles.bodies(), strict=True):
            position, quaternion = position_quaternion(vehicle.world_from_body)
            pybullet.resetBasePositionAndOrientation(body, position, quaternion, self._client)

    def read(self) -> None:
        """Update where the loose bodies are."""
        for index, (body, center) in enumerate(zip(self._loose, self._centers, strict=True)):
            position, quaternion = pybullet.getBasePositionAndOrientation(body, self._client)
            place = np.eye(4)
            rotation = np.reshape(pybullet.getMatrixFromQuaternion(quaternion), (3, 3))
            place[:3, :3] = rotation
            place[:3, 3] = np.array(position) - rotation @ center
            self._objects.place(index, place)


def _add_floor(client: int) -> None:
    """Add a ground for loose bodies: boxes stand on a box by four contacts, on a plane by fewer."""
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[FLOOR, FLOOR, 1.0], physicsClientId=client
    )
    place = transform_from_xyz_rpy(0.0, 0.0, -1.0, 0.0, 0.0, 0.0)
    add_body(client, shape, (GROUND, LOOSE), place, friction=1.0)


def _center(body: Body) -> FloatArray:
    """Return the middle of a body's parts, which counts as its centre of mass."""
    center: FloatArray = np.mean([part.body_from_part[:3, 3] for part in body.parts], axis=0)
    return center


def add_loose(client: int, body: Body) -> int:
    """Add a body that can be pushed; return its id."""
    identifier = add_multi_body(
        client,
        [(part.shape, part.body_from_part) for part in body.parts],
        position_quaternion(body.world_from_body),
        mass=body.mass,
        center=_center(body),
    )
    pybullet.changeDynamics(
        identifier,
        -1,
        lateralFriction=body.friction,
        rollingFriction=ROLLING,
        spinningFriction=ROLLING,
        activationState=pybullet.ACTIVATION_STATE_ENABLE_SLEEPING,
        physicsClientId=client,
    )
    pybullet.setCollisionFilterGroupMask(
        identifier, -1, LOOSE, GROUND | ROBOT | OBSTACLE | LOOSE, physicsClientId=client
    )
    return identifier
