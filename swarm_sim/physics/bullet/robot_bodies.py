"""Rigid bodies of robots for pybullet.

A robot stands on balls: each wheel touches the ground with a sphere of its radius, which rolls
without the 1 mm of excess that pybullet's cylinders have; the casters ahead of the axle, and those
behind it, are one ball without friction (`supports`). For everything else the wheels count
with their true outline, as part of the body. Collision groups keep the two apart. The four wheels
of a skid-steer or omnidirectional drive slide without friction, and what they or their rollers do
to the ground together is a force on the body (`push`): contacts that slip and roll at once would
need many more solver iterations to be as accurate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pybullet

from swarm_common.model.errors import RobotModelError
from swarm_common.model.records import FloatArray, Pose, RobotSpec
from swarm_common.model.shapes import Transform
from swarm_describe.robots.description import RigidGroup, RobotModel
from swarm_sim.physics.bullet.collision_shapes import BallLink, add_multi_body
from swarm_sim.physics.bullet.fixed_bodies import (
    GROUND,
    LOOSE,
    OBSTACLE,
    ROBOT,
    WALL_FRICTION,
    WHEEL,
)
from swarm_sim.physics.bullet.supports import Supports, find_supports

ROTOR_INERTIA = 1e-3  # [kg m²] of the motor's rotor, seen through its gear; steadies the solver
ROTOR_SHARE = 1.0 / 40.0  # of the robot's mass per wheel: wheels of heavy robots have more
TRACTION = 0.6  # of a robot's weight that four wheels can push with
PUSH_ARM = 0.1  # [m] from the centre at which they push when it turns
GRAVITY = 9.81  # [m/s²]
CASTER_MASS = 0.001  # [kg]
MOTOR_TORQUE = 1.4  # [N m] least stall torque of a wheel's motor
CONTACT_LINK, CONTACT_FORCE = 3, 9  # fields of a contact point: of the first body, normal [N]
STRENGTH = (0.8, 0.7)  # of acc_lim_x and acc_lim_theta that the motors of a heavy robot reach


@dataclass(frozen=True, slots=True)
class RobotBody:
    """A robot in the engine."""

    body: int  # pybullet's id
    wheels: tuple[int, ...]  # joint indices: the left ones from front to rear, then the right ones
    joint_names: tuple[str, ...]  # of the wheels, in the same order
    signs: FloatArray  # of each joint's turning when the wheel rolls forwards
    base_from_center: FloatArray  # centre of mass of the body in base_footprint
    mass: float  # [kg] with wheels
    inertia: float  # [kg m²] about the upright axis through the centre of mass, with wheels
    torque: float  # [N m] stall torque of each wheel's motor


@dataclass(frozen=True, slots=True)
class Stance:
    """A robot's tilt and wheel loads."""

    tilt: float  # [rad] of its upright axis
    # [N] that each driven wheel carries, in the order of `RobotBody.wheels`
    wheel_loads: FloatArray


def add_robot(client: int, model: RobotModel, spec: RobotSpec, pose: Pose) -> RobotBody:
    """Add a robot on its driven wheels, its base_footprint at a pose on the ground; return it."""
    base, wheels = base_and_wheels(model, spec)
    supports = find_supports(base, wheels, spec)
    center = base.center
    turn = pybullet.getQuaternionFromEuler([0.0, 0.0, pose.yaw])
    body = add_multi_body(
        client,
        touchable(supports, wheels),
        ([pose.x, pose.y, 0.0 - supports.level], turn),
        mass=base.mass,
        center=center,
        balls=_balls(spec, wheels, supports),
    )
    _set_dynamics(client, body, base, wheels, len(supports.balls), spec)
    axes = np.array([wheel.parent_from_group[:3, :3] @ wheel.axis for wheel in wheels])
    axes = axes.reshape(-1, 3)
    mass = base.mass + sum(wheel.mass for wheel in wheels)
    arms = [np.hypot(*(w.parent_from_group[:2, 3] - center[:2])) for w in wheels]
    inertia = base.inertia[2, 2] + sum(w.mass * a * a for w, a in zip(wheels, arms, strict=True))
    return RobotBody(
        body,
        tuple(range(len(wheels))),
        tuple(wheel.joint for wheel in wheels),
        np.where(axes[:, 1] < 0.0, -1.0, 1.0),
        center,
        mass,
        inertia,
        _torque(mass, inertia, len(wheels), spec),
    )


def _torque(mass: float, inertia: float, wheels: int, spec: RobotSpec) -> float:
    """Return the stall torque [N m] of each of a robot's motors, in proportion to its weight."""
    ahead = STRENGTH[0] * mass * spec.acc_lim_x
    turning = STRENGTH[1] * inertia * spec.acc_lim_theta / (spec.wheel_separation / 2.0)
    return max(MOTOR_TORQUE, max(ahead, turning) * spec.wheel_radius / max(1, wheels))


def push(client: int, robot: RobotBody, speeds: FloatArray, period: float) -> None:
    """Apply what a skid-steer or omnidirectional drive does to the ground in one step.

    Args:
        speeds: vx [m/s], wz [rad/s], vy [m/s] (3,) of base_footprint that the drive aims at.
    """
    position, (qx, qy, qz, qw) = pybullet.getBasePositionAndOrientation(robot.body, client)
    linear, angular = pybullet.getBaseVelocity(robot.body, client)
    yaw = math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
    cos, sin = math.cos(yaw), math.sin(yaw)
    vx, wz, vy = speeds.tolist()
    ahead, aside = vx - wz * robot.base_from_center[1], vy + wz * robot.base_from_center[0]
    lack_x = cos * ahead - sin * aside - linear[0]
    lack_y = sin * ahead + cos * aside - linear[1]
    force = robot.mass * math.hypot(lack_x, lack_y) / period
    share = min(1.0, TRACTION * GRAVITY * robot.mass / force) if force > 0.0 else 0.0
    most = TRACTION * GRAVITY * robot.mass * PUSH_ARM
    torque = min(most, max(-most, robot.inertia * (wz - angular[2]) / period))
    gain = share * robot.mass / period
    pybullet.applyExternalForce(
        robot.body, -1, [gain * lack_x, gain * lack_y, 0.0], position, pybullet.WORLD_FRAME, client
    )
    pybullet.applyExternalTorque(robot.body, -1, [0.0, 0.0, torque], pybullet.WORLD_FRAME, client)


def stance(client: int, robot: RobotBody, ground: int) -> Stance:
    """Return a robot's tilt and wheel loads on a ground body, at the end of the last step.

    Args:
        ground: pybullet's id of the body that carries it.
    """
    loads = np.zeros(pybullet.getNumJoints(robot.body, client))
    for point in pybullet.getContactPoints(robot.body, ground, physicsClientId=client) or ():
        if point[CONTACT_LINK] >= 0:
            loads[point[CONTACT_LINK]] += point[CONTACT_FORCE]
    _, (x, y, _, _) = pybullet.getBasePositionAndOrientation(robot.body, client)
    upright = 1.0 - 2.0 * (x * x + y * y)
    driven = len(robot.wheels)
    return Stance(math.acos(max(-1.0, min(1.0, upright))), loads[:driven])


def put(client: int, robot: RobotBody, pose: FloatArray) -> None:
    """Put a robot upright at a pose (3,), where it stands; its wheels keep their angles."""
    (_, _, height), _ = pybullet.getBasePositionAndOrientation(robot.body, client)
    x, y, yaw = pose.tolist()
    cos, sin = math.cos(yaw), math.sin(yaw)
    ahead, left = robot.base_from_center[:2].tolist()
    place = [x + cos * ahead - sin * left, y + sin * ahead + cos * left, height]
    turn = pybullet.getQuaternionFromEuler([0.0, 0.0, yaw])
    pybullet.resetBasePositionAndOrientation(robot.body, place, turn, client)
    pybullet.resetBaseVelocity(robot.body, [0.0] * 3, [0.0] * 3, client)
    for wheel in robot.wheels:
        angle = pybullet.getJointState(robot.body, wheel, client)[0]
        pybullet.resetJointState(robot.body, wheel, angle, 0.0, client)


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


def base_and_wheels(model: RobotModel, spec: RobotSpec) -> tuple[RigidGroup, list[RigidGroup]]:
    """Return the body of a robot, and its driven wheels in the order of the specification."""
    base, *moving = model.groups
    by_joint = {group.joint: group for group in moving if group.parent == 0}
    names = (*spec.wheels_left, *spec.wheels_right)
    if sorted(by_joint) != sorted(names) or len(by_joint) != len(moving):
        raise RobotModelError(
            f"robot '{spec.model}' has drive '{spec.drive}' on the joints {list(names)}, but its "
            f"description has the moving joints {[g.joint for g in moving]}"
        )
    return base, [by_joint[name] for name in names]


def touchable(supports: Supports, wheels: Sequence[RigidGroup]) -> list[tuple[Any, Transform]]:
    """Return the shapes of a robot that others can touch, in base_footprint."""
    turning = [
        (part.shape, wheel.parent_from_group @ part.body_from_part)
        for wheel in wheels
        for part in wheel.parts
    ]
    return [*supports.hull, *turning]


def _balls(spec: RobotSpec, wheels: Sequence[RigidGroup], supports: Supports) -> list[BallLink]:
    """Return the links of a robot: its wheels, then its casters."""
    balls = []
    for wheel, center in zip(wheels, supports.wheels, strict=True):
        place = wheel.parent_from_group.copy()
        place[:3, 3] = center
        balls.append(BallLink(spec.wheel_radius, wheel.mass, place, wheel.axis))
    for center, radius in supports.balls:
        place = np.eye(4)
        place[:3, 3] = center
        balls.append(BallLink(radius, CASTER_MASS, place))
    return balls


def _set_dynamics(
    client: int,
    body: int,
    base: RigidGroup,
    wheels: Sequence[RigidGroup],
    casters: int,
    spec: RobotSpec,
) -> None:
    def change(link: int, **values: Any) -> None:
        """Change dynamics of the robot.

        Args:
            link: Index of a wheel or caster; -1 for the base.
        """
        pybullet.changeDynamics(body, link, physicsClientId=client, **values)

    # Damping concerns the whole robot: in a call with anything else it diverts that to the base.
    change(-1, linearDamping=0.0, angularDamping=0.0)
    change(-1, localInertiaDiagonal=np.diag(base.inertia).tolist(), lateralFriction=WALL_FRICTION)
    pybullet.setCollisionFilterGroupMask(
        body, -1, ROBOT, ROBOT | OBSTACLE | LOOSE, physicsClientId=client
    )
    driven, radius = len(wheels), spec.wheel_radius
    for link in range(driven + casters):
        friction = 1.0 if link < driven and spec.drive == "differential" else 0.0
        change(link, lateralFriction=friction, rollingFriction=0.0, spinningFriction=0.0)
        pybullet.setCollisionFilterGroupMask(body, link, WHEEL, GROUND, physicsClientId=client)
    mass = base.mass + sum(wheel.mass for wheel in wheels)
    least = ROTOR_SHARE * mass * radius**2 / max(1, driven)
    for link, wheel in enumerate(wheels):
        rotor = max(ROTOR_INERTIA, least - float(wheel.axis @ wheel.inertia @ wheel.axis))
        inertia = np.diag(wheel.inertia) + rotor * np.abs(wheel.axis)
        change(link, localInertiaDiagonal=inertia.tolist(), jointDamping=0.0)
