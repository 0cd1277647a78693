"""Robot models: what world and navigator must agree on, from `robot.yaml` and the description.

What `robot.yaml` says counts; the rest is derived from the URDF or xacro. A `robot.yaml` that says
everything spares the reading of the description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarm_common.errors import RobotModelError
from swarm_common.records import RobotSpec
from swarm_common.robot_derived import Described, describe
from swarm_common.robot_model import RobotModel, parse_urdf
from swarm_common.robot_source import ROBOT_FILE, RobotSource, find_robot, robot_names
from swarm_common.robot_spec import (
    KNOWN,
    LIDAR_REQUIRED,
    REQUIRED,
    parse_drive,
    parse_wheels,
    positive,
    spec_of,
)
from swarm_common.yaml_io import check_keys

__all__ = [
    "ROBOT_FILE", "Robot", "description", "load_robot", "load_robot_model", "open_robot",
    "robot_directory", "robot_names",
]  # fmt: skip


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
        return spec_of(source, source.data)
    return spec_of(source, _merged(source, _described(source)))


def open_robot(name_or_path: str | Path) -> Robot:
    """Return all about a robot; see `load_robot`."""
    source = _source(name_or_path)
    if not _is_complete(source.data):
        described = _described(source)
        return Robot(spec_of(source, _merged(source, described)), described.urdf, described.model)
    spec = spec_of(source, source.data)
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
        parse_drive(data["drive"], where) if "drive" in data else None,
        parse_wheels(data["wheels"], where) if "wheels" in data else None,
        None if radius is None else positive(radius, f"{where}: wheel_radius"),
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
