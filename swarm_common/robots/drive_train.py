"""Which joints drive a robot, and what follows from where its wheels are.

Robots have to turn on the spot, which right of way and making room rely on: cars are refused.
"""

from __future__ import annotations

import re
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_common.model.errors import RobotModelError
from swarm_common.model.outline import bounds
from swarm_common.model.shapes import Cylinder, FloatArray, Part, Sphere, Transform
from swarm_common.robots.description import RigidGroup, RobotModel
from swarm_common.robots.gazebo_tags import DriveTags

FOOTPRINT = "base_footprint"
LEVEL = 0.9  # cosine to the y axis from which a joint's axis counts as that of a wheel
GROUND = 0.02  # [m] that a wheel may end above the lowest one
TRAIL = 0.005  # [m] between a swivel's axis and its wheel, from which it is a caster
VIRTUAL_RADIUS = 0.05  # [m] that is reported for the wheels of a drive without any
OFF_CENTER = 0.01  # [m] to the side from which a wheel is left or right
PASSIVE = re.compile("caster|castor|idler|free", re.IGNORECASE)
OMNI = re.compile("mecanum|omni|roller", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class DriveTrain:
    """The driven wheels; lengths in metres."""

    drive: str  # differential, skid or omni
    left: tuple[str, ...]  # joints of the left wheels from front to rear
    right: tuple[str, ...]  # of the right ones
    radius: float  # of the wheels
    separation: float  # between left and right ones
    wheel_base: float  # between the front and the rear ones
    center: FloatArray  # on the ground between all of them, in the root link's frame


@dataclass(frozen=True, slots=True)
class _Wheel:
    joint: str
    place: FloatArray  # of its hub in the root link's frame
    radius: float | None
    name: str
    swivel: str = ""  # joint that turns it about an upright axis
    is_steered: bool = False  # by that joint, and not a caster


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
        tags: Of its plugin; None without one.
        drive: Asked for in robot.yaml; None if it is not.
        joints: Left and right ones, asked for there; None if they are not.
        radius: Of the wheels [m], asked for there; None if it is not.

    Raises:
        RobotModelError: If there are no wheels to drive on, or the robot steers like a car.
    """
    wheels = _wheels(model)
    is_asked = joints is not None
    if joints is None and tags is not None and tags.left and tags.right:
        joints = (tags.left, tags.right)
    if joints is not None:
        left, right = (_named(side, wheels, where) for side in joints)
        standing = left + right
    else:
        standing = _standing(model, wheels)
        left, right = _sides(standing)
    if not is_asked:
        _refuse_car(standing, where)
    if len(left) != len(right) or not left:
        moves_body = tags is not None and tags.moves_body and drive in (None, "omni")
        if moves_body or (drive == "omni" and not is_asked and not left and not right):
            return _without_wheels(model)
    if not left or len(left) != len(right):
        raise RobotModelError(
            f"{where}: no wheels to drive on: {len(left)} on the left and {len(right)} on the "
            "right turn about the y axis at the ground; its turning joints are "
            f"{sorted(wheels) or 'none'}{_in_the_air(model, wheels)}; name them in robot.yaml: "
            "wheels: {left: [...], right: [...]}"
        )
    kind = drive or (tags.drive if tags is not None else None) or _kind(model, left + right)
    return _train(kind, left, right, _radius(left + right, tags, radius, where), where)


def _kind(model: RobotModel, wheels: Sequence[_Wheel]) -> str:
    if any(OMNI.search(name) for name in (model.name, *(wheel.name for wheel in wheels))):
        return "omni"
    return "differential" if len(wheels) == 2 else "skid"


def _wheels(model: RobotModel) -> dict[str, _Wheel]:
    """Return everything on a continuous joint, by joint."""
    places = model.root_from_groups()
    wheels = {}
    for group, place in zip(model.groups, places, strict=True):
        if group.kind in ("continuous", "revolute"):
            name = f"{group.joint} {group.name}"
            swivel, is_steered = _swivel(model, places, group, place)
            wheels[group.joint] = _Wheel(
                group.joint, place[:3, 3], radius_of(group), name, swivel, is_steered
            )
    return wheels


def _swivel(
    model: RobotModel, places: Sequence[Transform], wheel: RigidGroup, place: Transform
) -> tuple[str, bool]:
    """Return the joint that turns a wheel about an upright axis, and whether it steers it.

    A caster trails behind the axis on which it turns freely; a steered wheel stands under its own,
    or its joint has limits.
    """
    index = wheel.parent
    while index > 0:
        group = model.groups[index]
        axis = places[index][:3, :3] @ group.axis
        if group.kind in ("continuous", "revolute") and abs(axis[2]) > LEVEL:
            trail = float(np.hypot(*(place[:2, 3] - places[index][:2, 3])))
            is_caster = group.kind == "continuous" and trail > TRAIL
            named = PASSIVE.search(f"{group.joint} {group.name} {wheel.joint} {wheel.name}")
            return group.joint, not is_caster and named is None
        index = group.parent
    return "", False


def _refuse_car(wheels: Sequence[_Wheel], where: str) -> None:
    """Raise RobotModelError if wheels that stand on the ground are steered."""
    steered = [wheel for wheel in wheels if wheel.is_steered]
    if steered:
        names = ", ".join(sorted({wheel.swivel for wheel in steered}))
        raise RobotModelError(f"{where}: {car_message(f'the joints {names} steer its wheels')}")


def car_message(reason: str) -> str:
    """Return why a robot that steers like a car is refused."""
    return (
        f"it steers like a car ({reason}), and cannot turn on the spot; the navigator needs robots "
        "that can, to make room for each other. If it can, tell what drives it in robot.yaml: "
        "drive: differential, wheels: {left: [...], right: [...]}"
    )


def _without_wheels(model: RobotModel) -> DriveTrain:
    """Return an omnidirectional drive of a body that is moved as a whole."""
    parts = [
        Part(part.shape, place @ part.body_from_part)
        for group, place in zip(model.groups, model.root_from_groups(), strict=True)
        for part in group.parts
    ]
    low, high = bounds(parts) if parts else (np.zeros(3), np.full(3, 0.1))
    center = np.array([0.0, 0.0, low[2]])
    if FOOTPRINT in model.fixed:
        center = np.array(model.fixed[FOOTPRINT][:3, 3])
    return DriveTrain("omni", (), (), VIRTUAL_RADIUS, float(high[1] - low[1]), 0.0, center)


def radius_of(group: RigidGroup) -> float | None:
    """Return the radius [m] of a turning group about its axis, None without a collision shape."""
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


def _standing(model: RobotModel, wheels: dict[str, _Wheel]) -> list[_Wheel]:
    """Return the wheels that stand on the ground and roll forwards, from front to rear."""
    turning = []
    for group, place in zip(model.groups, model.root_from_groups(), strict=True):
        if group.kind != "continuous" or abs((place[:3, :3] @ group.axis)[1]) < LEVEL:
            continue
        wheel = wheels[group.joint]
        is_caster = PASSIVE.search(wheel.name) or (wheel.swivel and not wheel.is_steered)
        if wheel.radius is not None and not is_caster:
            turning.append(wheel)
    lowest = min((w.place[2] - (w.radius or 0.0) for w in turning), default=0.0)
    rolling = [w for w in turning if w.place[2] - (w.radius or 0.0) < lowest + GROUND]
    return sorted(rolling, key=lambda wheel: -wheel.place[0])


def _in_the_air(model: RobotModel, wheels: dict[str, _Wheel]) -> str:
    """Return a remark on wheels that end too far above the lowest one to stand on the ground."""
    ends = {j: w.place[2] - w.radius for j, w in wheels.items() if w.radius is not None}
    lowest = min(ends.values(), default=0.0)
    high = [f"{j} ends {1e3 * (z - lowest):.0f} mm" for j, z in ends.items() if z > lowest + GROUND]
    return f"; {', '.join(high)} above the lowest one" if high else ""


def _sides(rolling: Sequence[_Wheel]) -> tuple[list[_Wheel], list[_Wheel]]:
    """Return the left and the right ones of wheels."""
    middle = np.mean([w.place[1] for w in rolling]) if rolling else 0.0
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
