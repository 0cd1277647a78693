"""Limits of a robot's drive in the parameter files of ros2_control.

A file has nodes with `ros__parameters`, or, as ros_control has it, the controllers at its top.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import MissingPackageError, RobotModelError, SwarmError
from swarm_describe.files.packages import PackageFinder
from swarm_describe.robots.drive_tags import DriveTags, drive_of, is_steered, words
from swarm_describe.robots.gazebo_tags import plugin_name

CONTROL = re.compile("ros2?_?control", re.IGNORECASE)  # in the name of a plugin
PARAMETERS = "ros__parameters"
PREFIX = re.compile(r"\$\([^)]*\)|\$\{[^}]*\}|<[^>]*>")  # of a joint, filled in by a launch file
SIDES = ("left", "right")
# value of a RobotSpec -> names of a controller's parameters
VALUES: dict[str, tuple[str, ...]] = {
    "wheel_separation": ("wheel_separation",),
    "wheel_base": ("wheel_base", "wheelbase"),
    "wheel_radius": ("wheel_radius", "kinematics.wheels_radius"),
    "lever": ("kinematics.sum_of_robot_center_projection_on_X_Y_axis",),
    "max_vel_x": ("linear.x.max_velocity",),
    "max_vel_y": ("linear.y.max_velocity",),
    "max_vel_theta": ("angular.z.max_velocity",),
    "acc_lim_x": ("linear.x.max_acceleration",),
    "acc_lim_y": ("linear.y.max_acceleration",),
    "acc_lim_theta": ("angular.z.max_acceleration",),
}
MULTIPLIERS = {
    "wheel_separation": ("wheel_separation_multiplier",),
    "wheel_radius": ("left_wheel_radius_multiplier", "wheel_radius_multiplier"),
}


@dataclass(frozen=True, slots=True)
class Controllers:
    """Known facts of a robot's controllers."""

    tags: DriveTags | None = None  # of the one that drives the robot
    steering: str | None = None  # the one that steers wheels
    notes: tuple[str, ...] = ()  # what could not be read, or is not used


@dataclass(slots=True)
class _Found:
    tags: DriveTags | None = None
    steering: str | None = None
    notes: list[str] = field(default_factory=list)


def read_controllers(
    root: ET.Element, given: Sequence[Path], finder: PackageFinder, directory: Path
) -> Controllers:
    """Return the facts in the parameter files of ros2_control that a robot names."""
    found = _Found()
    for path in given:
        _take(read_yaml(path, RobotModelError), path, found)
    for plugin in root.findall("gazebo//plugin"):
        if CONTROL.search(f"{plugin.get('filename')} {plugin.get('name')}") is None:
            continue
        for element in plugin.findall("parameters"):
            text = (element.text or "").strip()
            try:
                path = finder.resolve(text, directory)
                _take(read_yaml(path, RobotModelError), path, found)
            except (SwarmError, MissingPackageError) as cause:
                found.notes.append(
                    f"plugin {plugin_name(plugin)}: its <parameters> are not used: {cause}"
                )
    if found.tags is None and not given and root.find("ros2_control") is not None:
        found.notes.append(
            "it has <ros2_control>, and names no file that says which controller drives it; "
            "robot.yaml can: controllers: [path/to/controllers.yaml]"
        )
    return Controllers(found.tags, found.steering, tuple(found.notes))


def _take(data: Mapping[str, Any], path: Path, found: _Found) -> None:
    nodes = {name: _flat(values) for name, values in _nodes(data)}
    for name, kind in _kinds(nodes):
        source = f"controller {kind} ({name}) in {path.name}"
        drive = drive_of(kind)
        if drive is None:
            if is_steered(kind) and found.steering is None:
                found.steering = source
            continue
        if found.tags is not None:
            found.notes.append(f"{source} is not used: {found.tags.source} comes before it")
            continue
        found.tags = _tags(drive, nodes.get(name, {}), source, found.notes)


def _nodes(data: Mapping[str, Any], name: str = "") -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the name of each node, without its namespace, and its parameters."""
    for key, value in data.items():
        if not isinstance(value, Mapping):
            continue
        if key == PARAMETERS:
            yield name, value
            continue
        last = str(key).rpartition("/")[2]
        if "type" in value and isinstance(value["type"], str):  # as ros_control has it
            yield last, value
        yield from _nodes(value, last)


def _flat(values: Mapping[str, Any], start: str = "") -> dict[str, Any]:
    """Return nested parameters by their full names."""
    flat: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{start}{key}.")
        else:
            flat[f"{start}{key}"] = value
    return flat


def _kinds(nodes: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    for node, values in nodes.items():
        for key, value in values.items():
            name, _, last = key.rpartition(".")
            if last == "type" and isinstance(value, str):
                yield name or node, value


def _tags(drive: str, values: Mapping[str, Any], source: str, notes: list[str]) -> DriveTags:
    left, right = ([*_joints(values, side)] for side in SIDES)
    read: dict[str, float] = {}
    for name, keys in VALUES.items():
        for key in keys:
            number = _number(values, key, source, notes)
            if number is not None and name not in read and _is_in_force(values, key):
                read[name] = number
        for key in MULTIPLIERS.get(name, ()):
            if name in read:
                read[name] *= _number(values, key, source, notes) or 1.0
    if drive == "differential" and len(left) > 1:
        drive = "skid"
    return DriveTags(drive, source, tuple(left), tuple(right), read)


def _joints(values: Mapping[str, Any], side: str) -> Iterator[str]:
    """Yield the names of the joints of one side: every parameter whose name says joint or wheel."""
    for key, value in values.items():
        names = value if isinstance(value, list) else [value]
        said = words(key.rpartition(".")[2])
        if side not in said or not {"wheel", "wheels", "joint"} & {*said} or "state" in said:
            continue
        for name in names:
            if isinstance(name, str) and name:
                yield PREFIX.sub("", name).lstrip("/")


def _is_in_force(values: Mapping[str, Any], key: str) -> bool:
    """Report whether a limit is switched on, as `has_velocity_limits` and the like state."""
    axis, _, last = key.rpartition(".")
    switch = values.get(f"{axis}.has_{last.removeprefix('max_')}_limits", True)
    return switch is not False


def _number(values: Mapping[str, Any], key: str, source: str, notes: list[str]) -> float | None:
    value = values.get(key)
    if value is None or (isinstance(value, float) and math.isnan(value)):  # not set
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        notes.append(f"{source}: {key} is {value!r}, which is not used")
        return None
    return float(value)
