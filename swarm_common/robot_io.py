"""Reading of `robot.yaml`: what world and navigator must agree on about a robot model."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

from swarm_common.errors import RobotModelError
from swarm_common.records import LidarSpec, RobotSpec
from swarm_common.resources import find_resource, resource_names
from swarm_common.yaml_io import check_keys, number, numbers, read_yaml

ROBOT_FILE = "robot.yaml"
DRIVES = ("differential", "skid", "omni")
OPTIONAL = ("model", "max_vel_y", "acc_lim_y", "wheel_base", "wheels_left", "wheels_right")
POSITIVE = (
    "max_vel_x",
    "max_vel_theta",
    "acc_lim_x",
    "acc_lim_theta",
    "wheel_radius",
    "wheel_separation",
    "height",
)


def robot_names() -> list[str]:
    """Return the names of the robot models that ship with the project."""
    return resource_names("robot", ROBOT_FILE)


def robot_directory(name_or_path: str | Path) -> Path:
    """Return the folder of a robot model: `robot.yaml` and its description."""
    return find_resource("robot", name_or_path, ROBOT_FILE).parent


def load_robot(name_or_path: str | Path) -> RobotSpec:
    """Return a robot model.

    Args:
        name_or_path: Name of a folder in `robots/`, or a path to a folder or `robot.yaml`.

    Raises:
        UnknownNameError: If there is no such model, or the file has an unknown key.
        RobotModelError: If a value is missing or impossible.
    """
    path = find_resource("robot", name_or_path, ROBOT_FILE)
    data = read_yaml(path, RobotModelError)
    known = [field.name for field in fields(RobotSpec)]
    check_keys(data, known, str(path))
    missing = [name for name in known if name not in data and name not in OPTIONAL]
    if missing:
        raise RobotModelError(f"{path} lacks {', '.join(missing)}")
    if data["drive"] not in DRIVES:
        raise RobotModelError(f"{path}: drive is {data['drive']!r}; expected one of {DRIVES}")
    return RobotSpec(
        model=str(data.get("model", path.parent.name)),
        drive=data["drive"],
        footprint=_footprint(data["footprint"], f"{path}: footprint"),
        lidar=_lidar(data["lidar"], f"{path}: lidar"),
        **{name: _positive(data[name], f"{path}: {name}") for name in POSITIVE},
    )


def _positive(value: object, what: str) -> float:
    result = number(value, what, RobotModelError)
    if result <= 0.0:
        raise RobotModelError(f"{what} is {result}; it must be positive")
    return result


def _footprint(value: object, what: str) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list) or not 3 <= len(value) <= 8:
        raise RobotModelError(f"{what} is {value!r}; expected a list of 3 to 8 points [x, y]")
    points = [numbers(p, 2, f"{what}[{i}]", RobotModelError) for i, p in enumerate(value)]
    for index, (x, y) in enumerate(points):
        before, after = points[index - 1], points[(index + 1) % len(points)]
        turn = (x - before[0]) * (after[1] - y) - (y - before[1]) * (after[0] - x)
        if turn <= 0.0:
            raise RobotModelError(
                f"{what} turns right at point {index} ({x}, {y}); "
                "expected a convex polygon, counter-clockwise"
            )
    return tuple((x, y) for x, y in points)


def _lidar(value: object, what: str) -> LidarSpec:
    if not isinstance(value, dict):
        raise RobotModelError(f"{what} is {value!r}; expected x, y, z, rays, rate, ...")
    data: dict[str, Any] = value
    check_keys(data, [field.name for field in fields(LidarSpec)], what)
    missing = [name for name in ("x", "y", "z") if name not in data]
    if missing:
        raise RobotModelError(f"{what} lacks {', '.join(missing)}")
    values = {key: number(item, f"{what}.{key}", RobotModelError) for key, item in data.items()}
    rays = int(values.pop("rays", 360))
    spec = LidarSpec(rays=rays, **values)
    if rays < 1 or spec.rate <= 0.0 or spec.sigma < 0.0 or spec.range_max <= spec.range_min:
        raise RobotModelError(f"{what} is impossible: {spec}")
    return spec
