"""Rigid bodies for pybullet: what a scene and a robot model become in the physics engine.

A robot stands on balls: each wheel touches the ground with a sphere of its radius, which rolls
without the 1 mm of excess that pybullet's cylinders have; the casters ahead of the axle, and
those behind it, are one ball without friction. For everything else the wheels count with their
true outline, as part of the body. Collision groups keep the two apart.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pybullet
from numpy.typing import NDArray

from swarm_common.errors import RobotModelError
from swarm_common.records import Pose, RobotSpec
from swarm_sim.robot_model import RigidGroup, RobotModel
from swarm_sim.scene import Body, Box, Cylinder, Hull, Part, Sphere, Transform
from swarm_sim.section import section_between

FloatArray = NDArray[np.float64]

GROUND, WHEEL, ROBOT, OBSTACLE = 1, 2, 4, 8  # collision groups
ON_GROUND = 0.002  # [m] a part of the body that reaches lower stands on the ground
ROTOR_INERTIA = 1e-3  # [kg m²] of the motor's rotor, seen through its gear; steadies the solver
WALL_FRICTION = 0.3
TYPES = {
    Box: pybullet.GEOM_BOX,
    Cylinder: pybullet.GEOM_CYLINDER,
    Sphere: pybullet.GEOM_SPHERE,
    Hull: pybullet.GEOM_MESH,
}


@dataclass(frozen=True, slots=True)
class RobotBody:
    """A robot in the engine.

    Attributes:
        body: pybullet's id.
        wheels: Joint indices: left, right.
        joint_names: Of the wheels, in the same order.
        base_from_center: Centre of mass in base_footprint.
    """

    body: int
    wheels: tuple[int, int]
    joint_names: tuple[str, str]
    base_from_center: FloatArray


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
    shape = _compound(client, [(p.shape, p.body_from_part) for p in body.parts])
    position, quaternion = _position_quaternion(body.world_from_body)
    identifier = int(
        pybullet.createMultiBody(
            0, shape, basePosition=position, baseOrientation=quaternion, physicsClientId=client
        )
    )
    pybullet.changeDynamics(identifier, -1, lateralFriction=WALL_FRICTION, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(identifier, -1, OBSTACLE, ROBOT, physicsClientId=client)
    return identifier


def add_walker(client: int, radius: float, height: float) -> int:
    """Add an upright cylinder that robots can touch and that is moved by hand; return its id."""
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_CYLINDER, radius=radius, height=height, physicsClientId=client
    )
    identifier = int(pybullet.createMultiBody(0, shape, physicsClientId=client))
    pybullet.changeDynamics(identifier, -1, lateralFriction=WALL_FRICTION, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(identifier, -1, OBSTACLE, ROBOT, physicsClientId=client)
    return identifier


def add_robot(client: int, model: RobotModel, spec: RobotSpec, pose: Pose) -> RobotBody:
    """Add a robot with two driven wheels, its base_footprint at a pose on the ground.

    Raises:
        RobotModelError: If the model has not exactly one wheel on either side.
    """
    base, left, right = _base_and_wheels(model, spec)
    casters, hull = _split_base(base)
    for wheel in (left, right):
        hull += [(p.shape, wheel.parent_from_group @ p.body_from_part) for p in wheel.parts]
    center = base.center
    body = int(
        pybullet.createMultiBody(
            base.mass,
            _compound(client, hull),
            basePosition=[pose.x, pose.y, 0.0],
            baseOrientation=pybullet.getQuaternionFromEuler([0.0, 0.0, pose.yaw]),
            baseInertialFramePosition=center.tolist(),
            physicsClientId=client,
            **_links(client, spec, (left, right), casters),
        )
    )
    _set_dynamics(client, body, base, (left, right), len(casters))
    return RobotBody(body, (0, 1), (left.joint, right.joint), center)


def set_asleep(client: int, robot: RobotBody, is_asleep: bool) -> None:
    """Let the engine leave a robot out that stands, or take it in again.

    A sleeping robot costs next to nothing; one that is run into wakes up by itself. A robot that
    is awake never falls asleep by itself: it might be creeping.
    """
    states = (
        (pybullet.ACTIVATION_STATE_ENABLE_SLEEPING, pybullet.ACTIVATION_STATE_SLEEP)
        if is_asleep
        else (pybullet.ACTIVATION_STATE_WAKE_UP, pybullet.ACTIVATION_STATE_DISABLE_SLEEPING)
    )
    for state in states:
        pybullet.changeDynamics(robot.body, -1, activationState=state, physicsClientId=client)


def _base_and_wheels(
    model: RobotModel, spec: RobotSpec
) -> tuple[RigidGroup, RigidGroup, RigidGroup]:
    base, *moving = model.groups
    wheels = sorted(moving, key=lambda group: -group.parent_from_group[1, 3])
    if spec.drive != "differential" or len(wheels) != 2 or any(g.parent != 0 for g in wheels):
        raise RobotModelError(
            f"robot '{spec.model}' has drive '{spec.drive}' and the moving joints "
            f"{[g.joint for g in moving]}; expected a differential drive with two wheels"
        )
    return base, wheels[0], wheels[1]


def _split_base(
    base: RigidGroup,
) -> tuple[list[tuple[FloatArray, float]], list[tuple[Any, Transform]]]:
    """Return balls (centre, radius) on which the base slides, and its other shapes."""
    casters: list[tuple[FloatArray, float]] = []
    hull: list[tuple[Any, Transform]] = []
    for part in base.parts:
        if isinstance(part.shape, Sphere) and _lowest(part) < ON_GROUND:
            casters.append((part.body_from_part[:3, 3], part.shape.radius))
        else:
            hull.append((part.shape, part.body_from_part))
    return _merged(casters), hull


def _merged(casters: Sequence[tuple[FloatArray, float]]) -> list[tuple[FloatArray, float]]:
    """Return one ball for the casters behind the axle and one for those ahead of it.

    Two wheels and one ball carry a robot as well as two wheels and two balls, at 3/4 of the cost.
    """
    merged = []
    for is_ahead in (False, True):
        balls = [ball for ball in casters if (ball[0][0] > 0.0) == is_ahead]
        if balls:
            center = np.mean([center for center, _ in balls], axis=0)
            merged.append((center, float(np.mean([radius for _, radius in balls]))))
    return merged


def _lowest(part: Part) -> float:
    radius = part.shape.radius if isinstance(part.shape, Sphere) else 0.0
    return float(part.body_from_part[2, 3]) - radius


def _links(
    client: int,
    spec: RobotSpec,
    wheels: tuple[RigidGroup, RigidGroup],
    casters: Sequence[tuple[FloatArray, float]],
) -> dict[str, Any]:
    """Return the arguments of createMultiBody for wheels and casters."""
    radii = [spec.wheel_radius] * 2 + [radius for _, radius in casters]
    centers = [wheel.parent_from_group[:3, 3] for wheel in wheels]
    centers += [center for center, _ in casters]
    turns = [_position_quaternion(wheel.parent_from_group)[1] for wheel in wheels]
    count = len(radii)
    shapes = [
        pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=r, physicsClientId=client)
        for r in radii
    ]
    return {
        "linkMasses": [wheel.mass for wheel in wheels] + [0.001] * len(casters),
        "linkCollisionShapeIndices": shapes,
        "linkVisualShapeIndices": [-1] * count,
        "linkPositions": [center.tolist() for center in centers],
        "linkOrientations": turns + [[0.0, 0.0, 0.0, 1.0]] * len(casters),
        "linkInertialFramePositions": [[0.0, 0.0, 0.0]] * count,
        "linkInertialFrameOrientations": [[0.0, 0.0, 0.0, 1.0]] * count,
        "linkParentIndices": [0] * count,
        "linkJointTypes": [pybullet.JOINT_REVOLUTE] * 2 + [pybullet.JOINT_FIXED] * len(casters),
        "linkJointAxis": [w.axis.tolist() for w in wheels] + [[0.0, 0.0, 1.0]] * len(casters),
    }


def _set_dynamics(
    client: int,
    body: int,
    base: RigidGroup,
    wheels: tuple[RigidGroup, RigidGroup],
    casters: int,
) -> None:
    def change(link: int, **values: Any) -> None:
        pybullet.changeDynamics(body, link, physicsClientId=client, **values)

    # Damping concerns the whole robot: in a call with anything else it diverts that to the base.
    change(-1, linearDamping=0.0, angularDamping=0.0)
    change(-1, localInertiaDiagonal=np.diag(base.inertia).tolist(), lateralFriction=WALL_FRICTION)
    pybullet.setCollisionFilterGroupMask(body, -1, ROBOT, ROBOT | OBSTACLE, physicsClientId=client)
    for link in range(2 + casters):
        friction = 1.0 if link < 2 else 0.0
        change(link, lateralFriction=friction, rollingFriction=0.0, spinningFriction=0.0)
        pybullet.setCollisionFilterGroupMask(body, link, WHEEL, GROUND, physicsClientId=client)
    for link, wheel in enumerate(wheels):
        inertia = np.diag(wheel.inertia) + ROTOR_INERTIA * np.abs(wheel.axis)
        change(link, localInertiaDiagonal=inertia.tolist(), jointDamping=0.0)


def _compound(client: int, shapes: Sequence[tuple[Any, Transform]]) -> int:
    """Return the id of one collision shape made of several; planes are left out."""
    solid = [(shape, transform) for shape, transform in shapes if type(shape) in TYPES]
    places = [_position_quaternion(transform) for _, transform in solid]
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
    """Write a hull where pybullet reads it from; return the file, empty for other shapes."""
    if not isinstance(shape, Hull):
        return ""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in shape.vertices]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in shape.faces]
    path = folder / f"{index}.obj"
    path.write_text("\n".join(lines), encoding="utf-8")
    return str(path)


def _position_quaternion(transform: Transform) -> tuple[list[float], list[float]]:
    """Return position and unit quaternion x, y, z, w of a transform."""
    m = transform[:3, :3]
    w = math.sqrt(max(0.0, 1.0 + m[0, 0] + m[1, 1] + m[2, 2])) / 2.0
    x = math.copysign(math.sqrt(max(0.0, 1.0 + m[0, 0] - m[1, 1] - m[2, 2])) / 2, m[2, 1] - m[1, 2])
    y = math.copysign(math.sqrt(max(0.0, 1.0 - m[0, 0] + m[1, 1] - m[2, 2])) / 2, m[0, 2] - m[2, 0])
    z = math.copysign(math.sqrt(max(0.0, 1.0 - m[0, 0] - m[1, 1] + m[2, 2])) / 2, m[1, 0] - m[0, 1])
    return transform[:3, 3].tolist(), [x, y, z, w]


def solid_bodies(bodies: Sequence[Body], low: float, high: float) -> list[Body]:
    """Return the bodies of which something lies between two heights."""
    return [body for body in bodies if section_between([body], low, high).names]
