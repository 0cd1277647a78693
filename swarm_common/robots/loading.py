"""Robot models: what world and navigator must agree on, from `robot.yaml` and the description.

What `robot.yaml` says counts; the rest is derived from the URDF or xacro. A `robot.yaml` that says
everything spares the reading of the description.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarm_common.files.yaml_io import check_keys
from swarm_common.model.errors import RobotModelError
from swarm_common.model.faults import Faults
from swarm_common.model.records import RobotSpec
from swarm_common.robots.derived import Asked, Described, describe, with_scan_frame
from swarm_common.robots.description import RobotModel, parse_urdf
from swarm_common.robots.source import ROBOT_FILE, RobotSource, find_robot, robot_names
from swarm_common.robots.spec import (
    KNOWN,
    LIDAR_REQUIRED,
    REQUIRED,
    parse_drive,
    parse_inertia,
    parse_wheels,
    positive,
    spec_of,
)

__all__ = [
    "ROBOT_FILE", "Robot", "description", "load_robot", "load_robot_model", "open_robot",
    "robot_names",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Robot:
    """All about a robot model."""

    spec: RobotSpec  # what world and navigator must agree on
    urdf: str  # its description
    model: RobotModel  # its bodies, in base_footprint


def load_robot(name_or_path: str | Path) -> RobotSpec:
    """Return what world and navigator must agree on about a robot.

    Args:
        name_or_path: Name of a folder in `robots/`, or a path to a folder, URDF, xacro or
            `robot.yaml`.

    Raises:
        UnknownNameError: If there is no such model, or robot.yaml has an unknown key.
        RobotModelError: If a value is missing or impossible; all that is wrong is told at once.
    """
    source = find_robot(name_or_path)
    faults = Faults(source.where, RobotModelError)
    return _specified(source, faults)[0]


def open_robot(name_or_path: str | Path) -> Robot:
    """Return all about a robot.

    Args:
        name_or_path: Name of a folder in `robots/`, or a path to a folder, URDF, xacro or
            `robot.yaml`.

    Raises:
        UnknownNameError: If there is no such model, or robot.yaml has an unknown key.
        RobotModelError: If a value is missing or impossible, or the description unusable.
    """
    source = find_robot(name_or_path)
    faults = Faults(source.where, RobotModelError)
    spec, described = _specified(source, faults)
    if described is not None:
        text, model = described.urdf, described.model
    else:
        text = source.text()
        moving = (*spec.wheels_left, *spec.wheels_right)
        directory = source.settings.parent if source.urdf is None else source.urdf.parent
        inertia = _asked(source, faults).inertia
        model = parse_urdf(text, source.where, moving, source.finder(), directory, inertia)
    return Robot(spec, with_scan_frame(text, model, spec.lidar), model)


def description(name_or_path: str | Path) -> str:
    """Return a robot's description as URDF text.

    Args:
        name_or_path: Name of a folder in `robots/`, or a path to a folder, URDF, xacro or
            `robot.yaml`.

    Raises:
        UnknownNameError: If there is no such model, or robot.yaml has an unknown key.
        RobotModelError: If a value is missing or impossible, or the description unusable.
    """
    return open_robot(name_or_path).urdf


def load_robot_model(name_or_path: str | Path) -> RobotModel:
    """Return the bodies of a robot.

    Args:
        name_or_path: Name of a folder in `robots/`, or a path to a folder, URDF, xacro or
            `robot.yaml`.

    Raises:
        UnknownNameError: If there is no such model, or robot.yaml has an unknown key.
        RobotModelError: If a value is missing or impossible, or the description unusable.
    """
    return open_robot(name_or_path).model


def _specified(source: RobotSource, faults: Faults) -> tuple[RobotSpec, Described | None]:
    """Return a model, and its description if that was asked.

    Raises:
        SwarmError: Of all that is wrong.
    """
    data, described = source.data, None
    with faults.caught():
        check_keys(data, KNOWN, str(source.settings))
    asked = _asked(source, faults)
    values: dict[str, Any] = dict(data)
    if not _is_complete(data):
        if source.urdf is None:
            faults.tell([_undescribed(source)])
        else:
            described = describe(source, asked, faults)
        values = _merged(source, described, faults)
    spec = spec_of(source, values, faults)
    faults.check()
    assert spec is not None
    return spec, described


def _is_complete(data: Mapping[str, Any]) -> bool:
    """Whether a robot.yaml says everything itself."""
    lidar = data.get("lidar")
    return all(name in data for name in REQUIRED) and (
        not isinstance(lidar, dict) or all(name in lidar for name in LIDAR_REQUIRED)
    )


def _undescribed(source: RobotSource) -> str:
    return (
        f"{source.settings} lacks {', '.join(_missing(source.data))}; there is no description "
        "beside it to derive that from"
    )


def _asked(source: RobotSource, faults: Faults) -> Asked:
    """Return what robot.yaml says about what else follows from the description."""
    data, where = source.data, str(source.settings)
    lidar = data.get("lidar")
    asked = Asked(lidar=lidar if isinstance(lidar, dict) else {})
    readers: dict[str, Callable[[Any], Any]] = {
        "drive": lambda value: parse_drive(value, where),
        "wheels": lambda value: parse_wheels(value, where),
        "wheel_radius": lambda value: positive(value, f"{where}: wheel_radius"),
        "inertia": lambda value: parse_inertia(value, where),
    }
    for name, reader in readers.items():
        if name in data:
            with faults.caught():
                asked = dataclasses.replace(asked, **{name: reader(data[name])})
    return asked


def _merged(source: RobotSource, described: Described | None, faults: Faults) -> dict[str, Any]:
    """Return the values of robot.yaml over those of the description.

    A value that is in neither is a fault; its message names the file and the keys. If the
    description is unusable, only limits are reported as missing, because most descriptions lack
    them.
    """
    seen = {} if described is None else described.values
    merged = {**seen, **source.data}
    own = source.data.get("lidar")
    if own is None or isinstance(own, dict):
        merged["lidar"] = {**seen.get("lidar", {}), **(own or {})}
    missing = [name for name in _missing(merged) if described is not None]
    if missing:
        faults.tell(
            [
                f"{source.where} does not tell {', '.join(missing)}; write "
                f"{'them' if len(missing) > 1 else 'it'} into {source.settings.absolute()}"
            ]
        )
    if any(name.startswith("lidar.") for name in _missing(merged)):
        del merged["lidar"]
    return merged


def _missing(values: Mapping[str, Any]) -> list[str]:
    missing = [name for name in REQUIRED if name not in values]
    lidar = values.get("lidar")
    if isinstance(lidar, dict):
        missing += [f"lidar.{name}" for name in LIDAR_REQUIRED if name not in lidar]
    return missing
