"""A `RobotSpec` from values by name, each checked: those of `robot.yaml` and those derived."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from swarm_common.files.yaml_io import check_keys, field_values, number, numbers
from swarm_common.model.beacon import FOOTPRINT_POINTS
from swarm_common.model.errors import RobotModelError
from swarm_common.model.records import LidarSpec, RobotSpec
from swarm_common.model.sensors import IDEAL, SensorErrors
from swarm_describe.files.faults import Faults
from swarm_describe.robots.battery_io import parse_battery
from swarm_describe.robots.sensors_io import sensor_errors
from swarm_describe.robots.source import RobotSource
from swarm_describe.robots.urdf_tree import INERTIA

DRIVES = ("differential", "skid", "omni")
REQUIRED = (
    "drive", "max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "wheel_radius",
    "wheel_separation", "footprint", "lidar", "height",
)  # fmt: skip
POSITIVE = tuple(name for name in REQUIRED if name not in ("drive", "footprint", "lidar"))
SIDEWAYS = ("max_vel_y", "acc_lim_y")  # of omnidirectional drives
FILES = ("description", "packages", "xacro_args", "controllers", "wheels", "inertia")
VALUES = (  # of a robot, in the order in which they are shown
    "model", "drive", "wheels", "wheel_radius", "wheel_separation", "wheel_base",
    "max_vel_x", "max_vel_y", "max_vel_theta", "acc_lim_x", "acc_lim_y", "acc_lim_theta",
    "footprint", "height", "lidar", "inertia",
)  # fmt: skip
KNOWN = ("model", *REQUIRED, *SIDEWAYS, "wheel_base", "sensors", "battery", *FILES)
LIDAR_REQUIRED = ("x", "y", "z")
MOST_POINTS = FOOTPRINT_POINTS
LOWEST_SCAN = 0.01  # [m] of a LiDAR above the ground, which it would see otherwise
SMALLEST = 1e-4  # [m], [m/s], ...: nor less
LARGEST = 50.0  # [m], [m/s], ...: nothing about a robot on the ground is more


def spec_of(source: RobotSource, values: Mapping[str, Any], faults: Faults) -> RobotSpec | None:
    """Return the model that values by name describe; None if something is wrong with one.

    Args:
        values: Values known so far; without all of `REQUIRED` the others are checked all the same.
        faults: Receives what is wrong; the messages name file and key.
    """
    where = str(source.settings if source.settings.is_file() else source.where)
    read: dict[str, Any] = {"model": source.name}
    for name, reader in _READERS.items():
        if name in values:
            with faults.caught():
                read[name] = reader(values[name], f"{where}: {name}")
    wheels: dict[str, Any] = {
        name: tuple(values[name]) for name in ("wheels_left", "wheels_right") if name in values
    }
    if "wheels" in values:
        with faults.caught():
            left, right = parse_wheels(values["wheels"], where)
            wheels = {"wheels_left": left, "wheels_right": right}
    if "drive" in read:
        with faults.caught():
            read |= _sideways(values, read["drive"], where)
    if faults or any(name not in read for name in REQUIRED):
        return None
    return RobotSpec(**read, **wheels)


def _sideways(values: Mapping[str, Any], drive: str, where: str) -> dict[str, Any]:
    """Return the limits sideways; those of an omnidirectional drive are those forwards."""
    if drive != "omni":
        for name in SIDEWAYS:
            if name in values:
                raise RobotModelError(f"{where}: {name} is for drive: omni, not for {drive}")
        return {}
    return {
        name: positive(value, f"{where}: {name}")
        for name in SIDEWAYS
        if (value := values.get(name, values.get(name.replace("_y", "_x")))) is not None
    }


def parse_drive(value: object, where: str) -> str:
    """Return a drive."""
    if value not in DRIVES:
        raise RobotModelError(f"{where}: drive is {value!r}; expected one of {DRIVES}")
    return str(value)


def parse_inertia(value: object, where: str) -> str:
    """Return where inertias come from."""
    if value not in INERTIA:
        raise RobotModelError(f"{where}: inertia is {value!r}; expected one of {INERTIA}")
    return str(value)


def parse_files(value: object, settings: Path, key: str) -> tuple[Path, ...]:
    """Return files that a key of robot.yaml lists."""
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        raise RobotModelError(f"{settings}: {key} is {value!r}; expected a list of files")
    paths = tuple(settings.parent / name for name in value)
    for path in paths:
        if not path.is_file():
            raise RobotModelError(f"{settings}: {key}: there is no file {path}")
    return paths


def _name(value: object, what: str) -> str:
    if not isinstance(value, str) or not value.strip():
        raise RobotModelError(f"{what} is {value!r}; expected a name")
    return value


def parse_wheels(value: object, where: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the left and the right driven joints."""
    what = f"{where}: wheels"
    if not isinstance(value, dict):
        raise RobotModelError(f"{what} is {value!r}; expected left: [joint], right: [joint]")
    check_keys(value, ("left", "right"), what)
    sides = [value.get("left"), value.get("right")]
    for side in sides:
        if not isinstance(side, list) or not side or not all(isinstance(n, str) for n in side):
            raise RobotModelError(f"{what} is {value!r}; expected left: [joint], right: [joint]")
    return tuple(sides[0] or ()), tuple(sides[1] or ())


def positive(value: object, what: str) -> float:
    """Return a positive number of sensible size."""
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
    readers = {"frame": _name}
    values = field_values(LidarSpec, value, what, RobotModelError, readers=readers)
    if values["z"] < LOWEST_SCAN:
        raise RobotModelError(
            f"{what}.z is {values['z']:.3g} m: the LiDAR would look along the ground; write how "
            "high its scan plane is into robot.yaml, lidar: {z: ...}"
        )
    if (rays := values.get("rays", 360)) != int(rays):
        raise RobotModelError(f"{what}.rays is {rays}; expected a whole number")
    spec = LidarSpec(**{**values, "rays": int(rays)})
    if (
        not 1 <= rays <= 100_000
        or not 0.01 <= spec.rate <= 1000.0
        or spec.sigma < 0.0
        or spec.range_min < 0.0
        or spec.range_max <= spec.range_min
        or spec.angle_increment < 1e-6
        or max(abs(spec.x), abs(spec.y), abs(spec.z)) > LARGEST
    ):
        raise RobotModelError(f"{what} is impossible: {spec}")
    return spec


def _wheel_base(value: object, what: str) -> float:
    return 0.0 if value in (0, 0.0) and value is not False else positive(value, what)


def _sensors(value: object, what: str) -> SensorErrors:
    return sensor_errors(value, what, IDEAL, RobotModelError)


_READERS: dict[str, Callable[[Any, str], Any]] = {
    "model": _name,
    "drive": lambda value, what: parse_drive(value, what.removesuffix(": drive")),
    **dict.fromkeys(POSITIVE, positive),
    "footprint": _footprint,
    "lidar": _lidar,
    "wheel_base": _wheel_base,
    "sensors": _sensors,
    "battery": lambda value, what: parse_battery(value, what, error=RobotModelError),
}
