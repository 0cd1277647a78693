"""Joints that drive a robot, and properties that follow from the places of its wheels.

Robots have to turn on the spot, which right of way and making room rely on: cars are refused.
"""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from swarm_common.model.errors import RobotModelError
from swarm_common.model.outline import bounds
from swarm_common.model.shapes import FloatArray, Part, Transform
from swarm_describe.robots.description import Origin, RigidGroup, RobotModel
from swarm_describe.robots.drive_tags import DriveTags, is_omni, is_passive
from swarm_describe.robots.tyres import Tyre, carried, tyre_of

FOOTPRINT = "base_footprint"
ROBOT_YAML = "robot.yaml"
LEVEL = 0.9  # cosine to the y axis from which a joint's axis counts as that of a wheel
GROUND = 0.02  # [m] that a wheel may end above the lowest one
TRAIL = 0.005  # [m] between a swivel's axis and its wheel, from which it is a caster
VIRTUAL_RADIUS = 0.05  # [m] that is reported for the wheels of a drive without any
SAME_AXLE = 1e-6  # [m] by which wheels of one axle may be apart: rounding of who wrote the file
OFF_CENTER = 0.01  # [m] to the side from which a wheel is left or right
OFF = 0.02  # share by which a stated length may be off what the shapes say, unmentioned
ROUGH = 0.1  # share by which it may be off a wheel whose shape is not round, and still counts
ROLLERS = 5  # turning parts on a wheel, from which it is one with rollers
# value -> what messages call it
LENGTHS = {
    "wheel_radius": "wheel_radius",
    "wheel_separation": "wheel_separation",
    "wheel_base": "wheel_base",
    "lever": "for half of wheel_separation and wheel_base together",
}
SLANT = 0.1  # cosine between an axle and the way to the middle of three wheels, at most


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
    origins: dict[str, Origin] = field(default_factory=dict)  # of values by name
    notes: dict[str, str] = field(default_factory=dict)  # which of them something else denies


@dataclass(frozen=True, slots=True)
class _Wheel:
    joint: str
    place: FloatArray  # of its tyre's middle in the root link's frame
    axle: FloatArray  # its direction there
    tyre: Tyre | None  # None without a collision shape
    has_rollers: bool
    name: str
    swivel: str = ""  # joint that turns it about an upright axis
    is_steered: bool = False  # by that joint, and not a caster

    @property
    def radius(self) -> float | None:
        return None if self.tyre is None else self.tyre.radius


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
        tags: Statement of its plugin; None without one.
        drive: Asked for in robot.yaml; None if it is not.
        joints: Left and right ones, asked for there; None if they are not.
        radius: Radius of the wheels [m], asked for there; None if it is not.
    """
    wheels = _wheels(model)
    is_asked = joints is not None
    stated = tags.source if tags is not None else ""
    named = Origin(stated)
    if joints is not None:
        named = Origin(ROBOT_YAML)
    elif tags is not None and tags.left and tags.right:
        joints = (tags.left, tags.right)
    if joints is not None:
        left, right = (_named(side, wheels, named.source, where) for side in joints)
        standing = left + right
    else:
        standing = _standing(model, wheels)
        left, right = _sides([] if _is_star(standing) else standing)
        named = Origin("the wheels that stand on the ground", True)
    is_paired = len(left) == len(right) and bool(left)
    kind, origin = _kind(model, left + right if is_paired else standing, tags, drive)
    if kind == "omni" and not is_asked:
        is_moved = tags is not None and tags.drive == "omni" and not (tags.left or tags.right)
        is_on_wheels = is_paired and not (is_moved and any(w.is_steered for w in standing))
        if not is_on_wheels and (is_moved or _is_star(standing) or not (left or right)):
            return _without_wheels(model, origin)
    if not is_asked:
        _refuse_car(standing, where)
    if not is_paired:
        raise RobotModelError(
            f"{where}: no wheels to drive on: {len(left)} on the left and {len(right)} on the "
            "right turn about the y axis at the ground; its turning joints are "
            f"{sorted(wheels) or 'none'}{_in_the_air(model, wheels)}; name them in robot.yaml: "
            "wheels: {left: [...], right: [...]}"
        )
    rolling = left + right
    size, of_size = _radius(rolling, tags, radius, where)
    train = _train(kind, left, right, size, where)
    of_places = _of_places(rolling)
    origins = {
        "drive": origin,
        "wheels": named,
        "wheel_radius": of_size,
        "wheel_separation": of_places,
        "wheel_base": of_places,
    }
    return dataclasses.replace(
        train, origins=origins, notes=dict(_differences(train, tags, rolling))
    )


def _kind(
    model: RobotModel, wheels: Sequence[_Wheel], tags: DriveTags | None, asked: str | None
) -> tuple[str, Origin]:
    """Return the drive, and what says so: robot.yaml, a plugin, the wheels, their names."""
    if asked is not None:
        return asked, Origin(ROBOT_YAML)
    if tags is not None:
        return tags.drive, Origin(tags.source)
    nothing = "no plugin or controller states the drive"
    if len(wheels) >= 3 and all(wheel.has_rollers for wheel in wheels):
        return "omni", Origin(f"{len(wheels)} wheels with rollers; {nothing}", True)
    if _is_star(wheels):
        return "omni", Origin(f"{len(wheels)} wheels around its middle; {nothing}", True)
    if len(wheels) == 2:
        return "differential", Origin(f"two wheels on the ground; {nothing}", True)
    if is_omni(model.name) or (wheels and all(is_omni(wheel.name) for wheel in wheels)):
        return "omni", Origin(f"{len(wheels)} wheels, and the names of them; {nothing}", True)
    return "skid", Origin(f"{len(wheels)} wheels on the ground; {nothing}", True)


def _is_star(wheels: Sequence[_Wheel]) -> bool:
    """Return whether the axles of three wheels or more meet in the middle between them."""
    if len(wheels) < 3:
        return False
    arms = np.array([wheel.place[:2] for wheel in wheels])
    arms -= arms.mean(axis=0)
    lengths = np.linalg.norm(arms, axis=1)
    if lengths.min() < OFF_CENTER:
        return False
    axles = np.array([wheel.axle[:2] for wheel in wheels])
    across = np.abs(arms[:, 0] * axles[:, 1] - arms[:, 1] * axles[:, 0]) / lengths
    turned = np.abs(axles[:, 0] * axles[0, 1] - axles[:, 1] * axles[0, 0])
    return bool(across.max() < SLANT and turned.max() > SLANT)


def _of_places(wheels: Sequence[_Wheel]) -> Origin:
    """Return the source of the wheels' places, for messages."""
    aside = [float(np.linalg.norm(w.tyre.offset)) for w in wheels if w.tyre is not None]
    if not aside:
        return Origin("joints of the wheels, which have no collision shapes")
    beside = f", up to {max(aside):.3g} m beside their joints" if max(aside) > 0.0 else ""
    return Origin(f"middles of the tyres{beside}")


def _differences(
    train: DriveTrain, tags: DriveTags | None, wheels: Sequence[_Wheel]
) -> Iterator[tuple[str, str]]:
    """Yield names of values of which a plugin states something else, and a sentence on each."""
    if tags is None or any(wheel.tyre is None for wheel in wheels):
        return
    seen = {
        "wheel_radius": train.radius,
        "wheel_separation": train.separation,
        "wheel_base": train.wheel_base,
        "lever": (train.separation + train.wheel_base) / 2.0,
    }
    for name, value in seen.items():
        stated = tags.values.get(name)
        if stated is None or value <= 0.0 or abs(stated - value) <= OFF * value:
            continue
        yield (
            name,
            f"{tags.source} states {LENGTHS[name]} {stated:.4g} m; the wheels' collision shapes "
            f"say {value:.4g} m, and these count, for it rolls on them",
        )


def _wheels(model: RobotModel) -> dict[str, _Wheel]:
    """Return everything on a continuous joint, by joint."""
    places = model.root_from_groups()
    wheels = {}
    for index, (group, place) in enumerate(zip(model.groups, places, strict=True)):
        if group.kind in ("continuous", "revolute"):
            more, turning = carried(model, index)
            tyre = tyre_of(group, more)
            hub = place[:3, 3] if tyre is None else place[:3, 3] + place[:3, :3] @ tyre.offset
            axle = place[:3, :3] @ group.axis
            swivel, is_steered = _swivel(model, places, group, place)
            wheels[group.joint] = _Wheel(
                group.joint,
                hub,
                axle,
                tyre,
                turning >= ROLLERS,
                f"{group.joint} {group.name}",
                swivel,
                is_steered,
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
            named = is_passive(f"{group.joint} {group.name} {wheel.joint} {wheel.name}")
            return group.joint, not is_caster and not named
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


def _without_wheels(model: RobotModel, origin: Origin) -> DriveTrain:
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
    whole = Origin("moved as a whole, on no wheels of its own")
    names = ("wheels", "wheel_radius", "wheel_separation", "wheel_base")
    origins = {"drive": origin, **dict.fromkeys(names, whole)}
    return DriveTrain("omni", (), (), VIRTUAL_RADIUS, float(high[1] - low[1]), 0.0, center, origins)


def _named(
    joints: Sequence[str], wheels: dict[str, _Wheel], source: str, where: str
) -> list[_Wheel]:
    for joint in joints:
        if joint not in wheels:
            raise RobotModelError(
                f"{where}: the wheel '{joint}' is no turning joint; those are {sorted(wheels)} "
                f"({source} names it; wheels: {{left: [...], right: [...]}} in robot.yaml wins)"
            )
    return sorted((wheels[joint] for joint in joints), key=lambda wheel: -wheel.place[0])


def _standing(model: RobotModel, wheels: dict[str, _Wheel]) -> list[_Wheel]:
    """Return the wheels that stand on the ground and roll forwards, from front to rear."""
    turning = []
    for group in model.groups:
        if group.kind != "continuous":
            continue
        wheel = wheels[group.joint]
        if wheel.radius is not None and not (wheel.swivel and not wheel.is_steered):
            turning.append(wheel)
    if not _is_star(turning):
        turning = [wheel for wheel in turning if abs(wheel.axle[1]) >= LEVEL]
    driven = [wheel for wheel in turning if not is_passive(wheel.name)]
    turning = driven or turning  # a word that all names share tells nothing of any
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
    middle = np.mean([w.place[1] for w in rolling]) if rolling else 0.0
    left = [w for w in rolling if w.place[1] - middle > OFF_CENTER]
    return left, [w for w in rolling if w.place[1] - middle < -OFF_CENTER]


def _radius(
    wheels: Sequence[_Wheel], tags: DriveTags | None, asked: float | None, where: str
) -> tuple[float, Origin]:
    """Return the wheels' radius [m], and what says so."""
    if asked is not None:
        return asked, Origin(ROBOT_YAML)
    seen = [wheel.tyre for wheel in wheels if wheel.tyre is not None]
    stated = tags.values.get("wheel_radius") if tags is not None else None
    source = Origin(tags.source if tags is not None else "")
    if len(seen) == len(wheels):
        radius = float(statistics.median(tyre.radius for tyre in seen))
        is_rough = not all(tyre.is_round for tyre in seen)
        if stated is not None and is_rough and abs(stated - radius) <= ROUGH * radius:
            return stated, source
        return radius, Origin("collision shapes of the wheels")
    if stated is not None:
        return stated, source
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
    base = float(np.ptp(places[:, 0]))
    return DriveTrain(
        kind,
        tuple(wheel.joint for wheel in left),
        tuple(wheel.joint for wheel in right),
        radius,
        float(sides[0] - sides[1]),
        base if base > SAME_AXLE else 0.0,
        center,
    )
