"""Bodies of pybullet that nothing pushes, the ground, obstacles, walkers; and collision groups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pybullet

from swarm_common.model.records import FloatArray
from swarm_sim.physics.bullet_shapes import compound, position_quaternion
from swarm_sim.scene.raw_triangles import tiles_between, triangles_of
from swarm_sim.scene.scene import Body, Mesh
from swarm_sim.scene.section import section_between

GROUND, WHEEL, ROBOT, OBSTACLE, LOOSE = 1, 2, 4, 8, 16  # collision groups
WALL_FRICTION = 0.3


def add_ground(client: int) -> int:
    """Add the ground plane; return its id."""
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_PLANE, planeNormal=[0, 0, 1], physicsClientId=client
    )
    ground = int(pybullet.createMultiBody(0, shape, physicsClientId=client))
    pybullet.changeDynamics(ground, -1, lateralFriction=1.0, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(ground, -1, GROUND, WHEEL, physicsClientId=client)
    return ground


def add_obstacle(client: int, body: Body) -> int:
    """Add a body of the scene, which stays where it is; return its id."""
    shape = compound(client, [(p.shape, p.body_from_part) for p in body.parts])
    position, quaternion = position_quaternion(body.world_from_body)
    identifier = int(
        pybullet.createMultiBody(
            0, shape, basePosition=position, baseOrientation=quaternion, physicsClientId=client
        )
    )
    pybullet.changeDynamics(identifier, -1, lateralFriction=WALL_FRICTION, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(
        identifier, -1, OBSTACLE, ROBOT | LOOSE, physicsClientId=client
    )
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
    identifier = int(pybullet.createMultiBody(0, shape, physicsClientId=client))
    pybullet.changeDynamics(identifier, -1, lateralFriction=WALL_FRICTION, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(identifier, -1, OBSTACLE, ROBOT, physicsClientId=client)
    return identifier


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
    """Return where triangles of a body's meshes are between two heights; see `tiles_between`."""
    meshes = tuple(part for part in body.parts if isinstance(part.shape, Mesh))
    return tiles_between(triangles_of([replace(body, parts=meshes)]), low, high)
