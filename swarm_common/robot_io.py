"""Robot models: what world and navigator must agree on, from `robot.yaml` and the description.

What `robot.yaml` says counts; the rest is derived from the URDF or xacro. A `robot.yaml` that says
everything spares the reading of the description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from swarm_common.errors import RobotModelError
from swarm_common.records import LidarSpec, RobotSpec
from swarm_common.robot_derived import Described, describe
from swarm_common.robot_model import RobotModel, parse_urdf
from swarm_common.robot_source import ROBOT_FILE, RobotSource, find_robot, robot_names
from swarm_common.sensors import IDEAL, sensor_errors
from swarm_common.yaml_io import check_keys, number, numbers

__all__ = [
    "ROBOT_FILE", "Robot", "description", "load_robot", "load_robot_model", "open_robot",
    "robot_directory", "robot_names",
]  # fmt: skip

DRIVES = ("differential", "skid", "omni")
REQUIRED = (
    "drive", "max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "wheel_radius",
    "wheel_separation", "footprint", "lidar", "height",
)  # fmt: skip
POSITIVE = tuple(name for name in REQUIRED if name not in ("drive", "footprint", "lidar"))
SIDEWAYS = ("max_vel_y", "acc_lim_y")  # of omnidirectional drives
FILES = ("description", "packages", "xacro_args", "wheels")
KNOWN = ("model", *REQUIRED, *SIDEWAYS, "wheel_base", "sensors", *FILES)
LIDAR_REQUIRED = ("x", "y", "z")
MOST_POINTS = 8  # of a footprint
SMALLEST = 1e-4  # [m], [m/s], ...: nor less
LARGEST = 50.0  # [m], [m/s], ...: nothing about a robot on the ground is more


@dataclass(frozen=True, slots=True)
class Robot:
    """All about a robot model.

    Attributes:
        spec: What world and navigator must agree on.
        urdf: Its description.
        model: Its bodies, in base_footprint.
    """

    spec: RobotSpec
    urdf: str
    model: RobotModel


def robot_directory(name_or_path: str | Path) -> Path:
    """Return the folder of a robot model's settings."""
    return find_robot(name_or_path).settings.parent


def load_robot(name_or_path: str | Path) -> RobotSpec:
    """Return what world and navigator must agree on about a robot.

    Args:
        name_or_path: Name of a folder in `robots/`, or a path to a folder, URDF, xacro or
            `robot.yaml`.

    Raises:
        UnknownNameError: If there is no such model, or robot.yaml has an unknown key.
        RobotModelError: If a value is missing or impossible.
    """
    source = _source(name_or_path)
    if _is_complete(source.data):
        return _spec(source, source.data)
    return _spec(source, _merged(source, _described(source)))


def open_robot(name_or_path: str | Path) -> Robot:
    """Return all about a robot; see `load_robot`."""
    source = _source(name_or_path)
    if not _is_complete(source.data):
        described = _described(source)
        return Robot(_spec(source, _merged(source, described)), described.urdf, described.model)
    spec = _spec(source, source.data)
    text = source.text()
    moving = (*spec.wheels_left, *spec.wheels_right)
    directory = source.settings.parent if source.urdf is None else source.urdf.parent
    model = parse_urdf(text, source.where, moving, source.finder(), directory)
    return Robot(spec, text, model)


def description(name_or_path: str | Path) -> str:
    """Return a robot's description as URDF text."""
    return open_robot(name_or_path).urdf


def load_robot_model(name_or_path: str | Path) -> RobotModel:
    """Return the bodies of a robot."""
    return open_robot(name_or_path).model


def _source(name_or_path: str | Path) -> RobotSource:
    source = find_robot(name_or_path)
    check_keys(source.data, KNOWN, str(source.settings))
    return source


def _is_complete(data: Mapping[str, Any]) -> bool:
    """Whether a robot.yaml says everything itself."""
    lidar = data.get("lidar")
    return all(name in data for name in REQUIRED) and (
        not isinstance(lidar, dict) or all(name in lidar for name in LIDAR_REQUIRED)
    )


def _described(source: RobotSource) -> Described:
    """Return what the description says, given what robot.yaml says."""
    data, where = source.data, str(source.settings)
    if source.urdf is None:
        missing = _missing(data)
        raise RobotModelError(
            f"{where} lacks {', '.join(missing)}; there is no description beside it to derive "
            "that from"
        )
    radius = data.get("wheel_radius")
    frame = data["lidar"].get("frame") if isinstance(data.get("lidar"), dict) else None
    return describe(
        source,
        _drive(data["drive"], where) if "drive" in data else None,
        _wheels(data["wheels"], where) if "wheels" in data else None,
        None if radius is None else _positive(radius, f"{where}: wheel_radius"),
        None if frame is None else str(frame),
    )


def _merged(source: RobotSource, described: Described) -> dict[str, Any]:
    """Return the values of robot.yaml over those of the description.

    Raises:
        RobotModelError: If something is in neither; the message names the file and the keys.
    """
    merged = {**described.values, **source.data}
    own, seen = source.data.get("lidar"), described.values.get("lidar", {})
    if own is None or isinstance(own, dict):
        merged["lidar"] = {**seen, **(own or {})}
    missing = _missing(merged)
    if missing:
        raise RobotModelError(
            f"{source.where} does not tell {', '.join(missing)}; write "
            f"{'them' if len(missing) > 1 else 'it'} into {source.settings.absolute()}"
        )
    return merged


def _missing(values: Mapping[str, Any]) -> list[str]:
    missing = [name for name in REQUIRED if name not in values]
    lidar = values.get("lidar")
    if isinstance(lidar, dict):
        missing += [f"lidar.{name}" for name in LIDAR_REQUIRED if name not in lidar]
    return missing


def _spec(source: RobotSource, values: Mapping[str, Any]) -> RobotSpec:
    where = str(source.settings if source.settings.is_file() else source.where)
    drive = _drive(values["drive"], where)
    wheels: dict[str, Any] = {
        name: tuple(values[name]) for name in ("wheels_left", "wheels_right") if name in values
    }
    if "wheels" in values:
        left, right = _wheels(values["wheels"], where)
        wheels = {"wheels_left": left, "wheels_right": right}
    base = values.get("wheel_base", 0.0)
    limits: dict[str, Any] = {
        name: _positive(values[name], f"{where}: {name}") for name in POSITIVE
    }
    return RobotSpec(
        model=_name(values.get("model", source.name), f"{where}: model"),
        drive=drive,
        footprint=_footprint(values["footprint"], f"{where}: footprint"),
        lidar=_lidar(values["lidar"], f"{where}: lidar"),
        wheel_base=_positive(base, f"{where}: wheel_base") if base else 0.0,
        sensors=sensor_errors(
            values.get("sensors", {}), f"{where}: sensors", IDEAL, RobotModelError
        ),
        **limits,
        **_sideways(values, drive, where),
        **wheels,
    )


def _sideways(values: Mapping[str, Any], drive: str, where: str) -> dict[str, Any]:
    """Return the limits sideways; those of an omnidirectional drive are those forwards."""
    if drive != "omni":
        for name in SIDEWAYS:
            if name in values:
                raise RobotModelError(f"{where}: {name} is for drive: omni, not for {drive}")
        return {}
    return {
        name: _positive(values.get(name, values[name.replace("_y", "_x")]), f"{where}: {name}")
        for name in SIDEWAYS
    }


def _drive(value: object, where: str) -> str:
    if value not in DRIVES:
        raise RobotModelError(f"{where}: drive is {value!r}; expected one of {DRIVES}")
    return str(value)


def _name(value: object, what: str) -> str:
    if not isinstance(value, str) or not value.strip():
        raise RobotModelError(f"{what} is {value!r}; expected a name")
    return value


def _wheels(value: object, where: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    what = f"{where}: wheels"
    if not isinstance(value, dict):
        raise RobotModelError(f"{what} is {value!r}; expected left: [joint], right: [joint]")
    check_keys(value, ("left", "right"), what)
    sides = [value.get("left"), value.get("right")]
    for side in sides:
        if not isinstance(side, list) or not side or not all(isinstance(n, str) for n in side):
            raise RobotModelError(f"{what} is {value!r}; expected left: [joint], right: [joint]")
    return tuple(sides[0] or ()), tuple(sides[1] or ())


def _positive(value: object, what: str) -> float:
    result = number(value, what, RobotModelError)
    if not SMALLEST <= result <= LARGEST:
        raise RobotModelError(
            f"{what} is {result:g}; it must be positive, from {SMALLEST:g} to {LARGEST:g}"
        )
    return result


def _footprint(value: object, what: str) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list) or not 3 <= len(value) <= MOST_POINTS:
        raise RobotModelError(
            f"{what} is {value!r}; expected a list of 3 to {MOST_POINTS} points [x, y]"
        )
    points = [numbers(p, 2, f"{what}[{i}]", RobotModelError) for i, p in enumerate(value)]
    for index, (x, y) in enumerate(points):
        before, after = points[index - 1], points[(index + 1) % len(points)]
        turn = (x - before[0]) * (after[1] - y) - (y - before[1]) * (after[0] - x)
        if not turn > 0.0 or max(abs(x), abs(y)) > LARGEST:
            raise RobotModelError(
                f"{what} turns right at point {index} ({x}, {y}); "
                "expected a convex polygon, counter-clockwise"
            )
    if any(
        (b[0] - a[0]) * a[1] - (b[1] - a[1]) * a[0] > 0.0
        for a, b in zip(points, (*points[1:], points[0]), strict=True)
    ):
        raise RobotModelError(f"{what} does not hold the point (0, 0), about which the robot turns")
    return tuple((x, y) for x, y in points)


def _lidar(value: object, what: str) -> LidarSpec:
    if not isinstance(value, dict):
        raise RobotModelError(f"{what} is {value!r}; expected x, y, z, rays, rate, ...")
    data: dict[str, Any] = value
    check_keys(data, [field.name for field in fields(LidarSpec)], what)
    missing = [name for name in LIDAR_REQUIRED if name not in data]
    if missing:
        raise RobotModelError(f"{what} lacks {', '.join(missing)}")
    frame = _name(data.get("frame", "base_scan"), f"{what}.frame")
    values = {
        key: number(item, f"{what}.{key}", RobotModelError)
        for key, item in data.items()
        if key != "frame"
    }
    rays = int(values.pop("rays", 360))
    spec = LidarSpec(rays=rays, frame=frame, **values)
    if (
        not 1 <= rays <= 100_000
        or not 0.01 <= spec.rate <= 1000.0
        or spec.sigma < 0.0
        or spec.range_min < 0.0
        or spec.range_max <= spec.range_min
        or abs(spec.angle_increment) < 1e-6
        or max(abs(spec.x), abs(spec.y), abs(spec.z)) > LARGEST
    ):
        raise RobotModelError(f"{what} is impossible: {spec}")
    return spec
