"""Which joints drive a robot, and what follows from where its wheels are."""

from __future__ import annotations

import re
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_common.errors import RobotModelError
from swarm_common.gazebo_tags import DriveTags
from swarm_common.outline import bounds
from swarm_common.robot_model import RigidGroup, RobotModel
from swarm_common.shapes import Cylinder, FloatArray, Sphere

LEVEL = 0.9  # cosine to the y axis from which a joint's axis counts as that of a wheel
GROUND = 0.02  # [m] that a wheel may end above the lowest one
OFF_CENTER = 0.01  # [m] to the side from which a wheel is left or right
PASSIVE = re.compile("caster|castor|idler|free", re.IGNORECASE)
OMNI = re.compile("mecanum|omni|roller", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class DriveTrain:
    """The driven wheels; lengths in metres.

    Attributes:
        drive: differential, skid or omni.
        left: Joints of the left wheels from front to rear.
        right: Of the right ones.
        radius: Of the wheels.
        separation: Between left and right ones.
        wheel_base: Between the front and the rear ones.
        center: On the ground between all of them, in the root link's frame.
    """

    drive: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    radius: float
    separation: float
    wheel_base: float
    center: FloatArray


@dataclass(frozen=True, slots=True)
class _Wheel:
    joint: str
    place: FloatArray  # of its hub in the root link's frame
    radius: float | None
    name: str


def find_drive(
    model: RobotModel,
    where: str,
    tags: DriveTags | None = None,
    drive: str | None = None,
    joints: tuple[Sequence[str], Sequence[str]] | None = None,
    radius: float | None = None,
) -> DriveTrain:
    """Return the drive of a robot: as asked for, as its plugin says, or as its wheels look.

    Args:
        model: With every joint that can move.
        where: Its file, for messages.
        tags: Of its plugin.
        drive: Asked for in robot.yaml.
        joints: Left and right ones, asked for there.
        radius: Of the wheels [m], asked for there.

    Raises:
        RobotModelError: If there are no wheels to drive on.
    """
    wheels = _wheels(model)
    if joints is None and tags is not None and tags.left and tags.right:
        joints = (tags.left, tags.right)
    if joints is not None:
        left, right = (_named(side, wheels, where) for side in joints)
    else:
        left, right = _by_looks(model, wheels)
    if not left or len(left) != len(right):
        raise RobotModelError(
            f"{where}: no wheels to drive on: {len(left)} on the left and {len(right)} on the "
            "right turn about the y axis at the ground; its turning joints are "
            f"{sorted(wheels) or 'none'}; name them in robot.yaml: "
            "wheels: {left: [...], right: [...]}"
        )
    kind = drive or (tags.drive if tags is not None else None) or _kind(model, left + right)
    return _train(kind, left, right, _radius(left + right, tags, radius, where), where)


def _kind(model: RobotModel, wheels: Sequence[_Wheel]) -> str:
    if any(OMNI.search(name) for name in (model.name, *(wheel.name for wheel in wheels))):
        return "omni"
    return "differential" if len(wheels) == 2 else "skid"


def _wheels(model: RobotModel) -> dict[str, _Wheel]:
    """Return whatever turns without end, by joint."""
    places = model.root_from_groups()
    wheels = {}
    for group, place in zip(model.groups, places, strict=True):
        if group.kind in ("continuous", "revolute"):
            name = f"{group.joint} {group.name}"
            wheels[group.joint] = _Wheel(group.joint, place[:3, 3], _radius_of(group), name)
    return wheels


def _radius_of(group: RigidGroup) -> float | None:
    """Return the radius [m] about the axis of what turns, None if it has no collision shape."""
    for part in group.parts:
        if isinstance(part.shape, Cylinder | Sphere):
            return part.shape.radius
    if not group.parts:
        return None
    low, high = bounds(group.parts)
    across = (high - low)[np.argsort(np.abs(group.axis))[:2]]
    return float(across.max() / 2.0)


def _named(joints: Sequence[str], wheels: dict[str, _Wheel], where: str) -> list[_Wheel]:
    for joint in joints:
        if joint not in wheels:
            raise RobotModelError(
                f"{where}: the wheel '{joint}' is no turning joint; those are {sorted(wheels)}"
            )
    return sorted((wheels[joint] for joint in joints), key=lambda wheel: -wheel.place[0])


def _by_looks(model: RobotModel, wheels: dict[str, _Wheel]) -> tuple[list[_Wheel], list[_Wheel]]:
    """Return the left and right wheels that stand on the ground and roll forwards."""
    turning = []
    for group, place in zip(model.groups, model.root_from_groups(), strict=True):
        if group.kind != "continuous" or abs((place[:3, :3] @ group.axis)[1]) < LEVEL:
            continue
        wheel = wheels[group.joint]
        if wheel.radius is not None and not PASSIVE.search(wheel.name):
            turning.append(wheel)
    lowest = min((w.place[2] - (w.radius or 0.0) for w in turning), default=0.0)
    rolling = [w for w in turning if w.place[2] - (w.radius or 0.0) < lowest + GROUND]
    middle = np.mean([w.place[1] for w in rolling]) if rolling else 0.0
    rolling.sort(key=lambda wheel: -wheel.place[0])
    left = [w for w in rolling if w.place[1] - middle > OFF_CENTER]
    return left, [w for w in rolling if w.place[1] - middle < -OFF_CENTER]


def _radius(
    wheels: Sequence[_Wheel], tags: DriveTags | None, asked: float | None, where: str
) -> float:
    seen = [wheel.radius for wheel in wheels if wheel.radius is not None]
    if asked is not None:
        return asked
    if len(seen) == len(wheels):
        return float(statistics.median(seen))
    if tags is not None and "wheel_radius" in tags.values:
        return tags.values["wheel_radius"]
    raise RobotModelError(
        f"{where}: the wheels have no collision shape; write wheel_radius into robot.yaml"
    )


def _train(
    kind: str, left: Sequence[_Wheel], right: Sequence[_Wheel], radius: float, where: str
) -> DriveTrain:
    places = np.array([wheel.place for wheel in (*left, *right)])
    center = places.mean(axis=0)
    center[2] -= radius
    sides = [np.mean([wheel.place[1] for wheel in side]) for side in (left, right)]
    if sides[0] - sides[1] < OFF_CENTER:
        raise RobotModelError(
            f"{where}: the left wheels {[w.joint for w in left]} are not left of the right ones "
            f"{[w.joint for w in right]}"
        )
    return DriveTrain(
        kind,
        tuple(wheel.joint for wheel in left),
        tuple(wheel.joint for wheel in right),
        radius,
        float(sides[0] - sides[1]),
        float(np.ptp(places[:, 0])),
        center,
    )
