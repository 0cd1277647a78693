"""Bodies of pybullet that nothing pushes, the ground, obstacles, walkers; and collision groups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pybullet

from swarm_common.model.records import FloatArray
from swarm_common.model.shapes import Mesh, Transform
from swarm_describe.worlds.raw_triangles import tiles_between, triangles_of
from swarm_describe.worlds.scene import Body
from swarm_sim.physics.bullet.collision_shapes import add_multi_body, position_quaternion
from swarm_sim.scene.section import section_between

GROUND, WHEEL, ROBOT, OBSTACLE, LOOSE = 1, 2, 4, 8, 16  # collision groups
SOLID = OBSTACLE, ROBOT | LOOSE
WALL_FRICTION = 0.3
ORIGIN: Transform = np.eye(4)


def add_body(
    client: int,
    shape: int,
    groups: tuple[int, int],
    place: Transform = ORIGIN,
    friction: float = WALL_FRICTION,
) -> int:
    """Add a body that nothing pushes; return its id.

    Args:
        shape: Id of its collision shape.
        groups: Collision group of the body, and the groups that it meets.
    """
    position, quaternion = position_quaternion(place)
    body = int(
        pybullet.createMultiBody(
            0, shape, basePosition=position, baseOrientation=quaternion, physicsClientId=client
        )
    )
    _set_surface(client, body, groups, friction)
    return body


def _set_surface(client: int, body: int, groups: tuple[int, int], friction: float) -> None:
    pybullet.changeDynamics(body, -1, lateralFriction=friction, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(body, -1, *groups, physicsClientId=client)


def add_ground(client: int) -> int:
    """Add the ground plane; return its id."""
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_PLANE, planeNormal=[0, 0, 1], physicsClientId=client
    )
    return add_body(client, shape, (GROUND, WHEEL), friction=1.0)


def add_obstacle(client: int, body: Body) -> int:
    """Add a body of the scene, which stays where it is; return its id.

    Args:
        body: Without meshes and planes, see `pieces_of`.
    """
    shapes = [(part.shape, part.body_from_part) for part in body.parts]
    identifier = add_multi_body(client, shapes, position_quaternion(body.world_from_body))
    _set_surface(client, identifier, SOLID, WALL_FRICTION)
    return identifier


def let_robots_pass(client: int, bodies: Sequence[int]) -> None:
    """Let bodies meet only what can be pushed."""
    for body in bodies:
        pybullet.setCollisionFilterGroupMask(body, -1, OBSTACLE, LOOSE, physicsClientId=client)


def add_walker(client: int, radius: float, height: float) -> int:
    """Add an upright cylinder that robots can touch and that is moved by hand; return its id."""
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_CYLINDER, radius=radius, height=height, physicsClientId=client
    )
    return add_body(client, shape, (OBSTACLE, ROBOT))


def solid_bodies(bodies: Sequence[Body], low: float, high: float) -> list[Body]:
    """Return the bodies of which something lies between two heights.

    Of meshes each triangle counts, whatever their section shows.
    """
    return [
        body
        for body in bodies
        if section_between([body], low, high).names or len(mesh_tiles(body, low, high))
    ]


def mesh_tiles(body: Body, low: float, high: float) -> FloatArray:
    """Return bounds (k, 4) of squares that triangles of a body's meshes cover, see `tiles_between`.

    Args:
        body: Parts that are no meshes are left out.
    """
    meshes = tuple(part for part in body.parts if isinstance(part.shape, Mesh))
    return tiles_between(triangles_of([replace(body, parts=meshes)]), low, high)
