"""Content of `robot.yaml`, and a `RobotSpec` from its values and those derived, each checked."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import UNSET, Meta, UnsetType

from swarm_common.files.convert import convert, over, texts_of
from swarm_common.model.battery import BatterySpec
from swarm_common.model.beacon import FOOTPRINT_POINTS
from swarm_common.model.errors import ConfigError, RobotModelError, SwarmError
from swarm_common.model.records import LidarSpec, RobotSpec
from swarm_common.model.schema import Name, Point, Schema, told
from swarm_common.model.sensors import SensorErrors
from swarm_describe.files.faults import Faults

REQUIRED = (
    "drive", "max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "wheel_radius",
    "wheel_separation", "footprint", "lidar", "height",
)  # fmt: skip
SIDEWAYS = ("max_vel_y", "acc_lim_y")  # of omnidirectional drives
VALUES = (  # of a robot, in the order in which they are shown
    "model", "drive", "wheels", "wheel_radius", "wheel_separation", "wheel_base",
    "max_vel_x", "max_vel_y", "max_vel_theta", "acc_lim_x", "acc_lim_y", "acc_lim_theta",
    "footprint", "height", "lidar", "inertia",
)  # fmt: skip
LIDAR_REQUIRED = ("x", "y", "z")
SMALLEST = 1e-4  # [m], [m/s], ...
LARGEST = 50.0  # [m], [m/s], ...: nothing about a robot on the ground is more

Size = Annotated[float, Meta(ge=SMALLEST, le=LARGEST)]
Texts = tuple[str, ...]
Joints = Annotated[Texts, told("a list of joints", min_length=1)]
Files = Annotated[Texts, told("a list of files")]
Corners = Annotated[
    tuple[Point, ...],
    told(
        f"a list of 3 to {FOOTPRINT_POINTS} points [x, y]",
        min_length=3,
        max_length=FOOTPRINT_POINTS,
    ),
]
BaseLength = Annotated[
    float,
    told(
        f"a number, 0 or from {SMALLEST:g} to {LARGEST:g}",
        lambda value: value == 0.0 or value >= SMALLEST,
        ge=0.0,
        le=LARGEST,
    ),
]


class DrivenJoints(Schema):
    """Driven joints."""

    left: Joints
    right: Joints


class RobotFile(Schema):
    """Content of the file; the description has what is not set."""

    model: Name | UnsetType = UNSET
    description: str | UnsetType = UNSET  # file, relative to this one
    packages: Annotated[Texts, told("a list of folders")] | UnsetType = UNSET
    xacro_args: dict[Name, str | None] | UnsetType = UNSET
    controllers: Files | UnsetType = UNSET  # parameter files of ros2_control
    inertia: Literal["described", "shapes"] | UnsetType = UNSET  # where inertias come from
    drive: Literal["differential", "skid", "omni"] | UnsetType = UNSET
    wheels: DrivenJoints | UnsetType = UNSET
    wheel_radius: Size | UnsetType = UNSET
    wheel_separation: Size | UnsetType = UNSET
    wheel_base: BaseLength | UnsetType = UNSET
    max_vel_x: Size | UnsetType = UNSET
    max_vel_y: Size | UnsetType = UNSET
    max_vel_theta: Size | UnsetType = UNSET
    acc_lim_x: Size | UnsetType = UNSET
    acc_lim_y: Size | UnsetType = UNSET
    acc_lim_theta: Size | UnsetType = UNSET
    footprint: Corners | UnsetType = UNSET
    height: Size | UnsetType = UNSET
    lidar: LidarSpec | UnsetType = UNSET
    sensors: SensorErrors | UnsetType = UNSET
    battery: BatterySpec | UnsetType = UNSET


AS_WRITTEN = tuple(texts_of(RobotFile))


def read_values(data: Mapping[str, Any], where: str | Path, faults: Faults) -> dict[str, Any]:
    """Return values of a robot by name as far as they fit; the others are told."""
    values = {}
    for name, value in data.items():
        with faults.caught():
            values[name] = value_of(name, value, where)
    return values


def value_of(name: str, value: Any, where: str | Path) -> Any:
    """Return a value of a robot by its name.

    Raises:
        SwarmError: If there is no such value, or this one does not fit.
    """
    if name == "battery":
        value = _with_both_charges(value)
    elif name == "lidar" and isinstance(value, Mapping):
        rays = value.get("rays")
        if isinstance(rays, float) and rays.is_integer():
            value = {**value, "rays": int(rays)}
    return getattr(convert({name: value}, RobotFile, Path(where), RobotModelError), name)


def spec_of(
    name: str, values: Mapping[str, Any], where: str | Path, faults: Faults
) -> RobotSpec | None:
    """Return the model that values by name describe; None if something is wrong with one.

    Args:
        name: Name of the model unless its values have one.
        values: Values known so far; without all of `REQUIRED` the others are checked all the same.
        where: File whose values these are, in messages.
        faults: Receives what is wrong; the messages name file and key.
    """
    sides = {
        name: tuple(values[name]) for name in ("wheels_left", "wheels_right") if name in values
    }
    read = read_values({n: v for n, v in values.items() if n not in sides}, where, faults)
    with faults.caught():
        check_footprint(read.get("footprint", ()), f"{where}: footprint")
    if "wheels" in read:
        sides = {"wheels_left": read["wheels"].left, "wheels_right": read["wheels"].right}
    if read.get("drive") == "omni":
        for side in SIDEWAYS:
            read.setdefault(side, read.get(side.replace("_y", "_x")))
    elif "drive" in read:
        of_others = [side for side in SIDEWAYS if side in values]
        faults.tell(
            f"{where}: {side} is for drive: omni, not for {read['drive']}" for side in of_others
        )
    if faults or any(name not in read for name in REQUIRED):
        return None
    known = {field.name for field in dataclasses.fields(RobotSpec)}
    return RobotSpec(**{"model": name, **{n: v for n, v in read.items() if n in known}, **sides})


def check_footprint(points: tuple[tuple[float, float], ...], what: str) -> None:
    """Refuse a polygon that is not convex and counter-clockwise around (0, 0)."""
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
        for a, b in zip(points, (*points[1:], *points[:1]), strict=True)
    ):
        raise RobotModelError(f"{what} does not hold the point (0, 0), about which the robot turns")


def parse_battery(
    data: object, where: str, base: BatterySpec | None = None, error: type[SwarmError] = ConfigError
) -> BatterySpec:
    """Return a battery; keys that are missing are those of `base`, that of the robot's model."""
    known = {} if base is None else dataclasses.asdict(base)
    return convert(over(known, _with_both_charges(data)), BatterySpec, where, error)


def _with_both_charges(battery: object) -> object:
    if isinstance(battery, dict) and isinstance(battery.get("initial"), int | float):
        return battery | {"initial": [battery["initial"]] * 2}
    return battery
