"""A robot model as the ROS parameters `robot.*` of its navigator, and back."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from typing import Any

from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import ConfigError, RobotModelError
from swarm_common.model.records import LidarSpec, RobotSpec
from swarm_common.model.shapes import Transform, quaternion_of

WORLDS_OWN = ("wheels_left", "wheels_right", "sensors")  # of no use to a navigator


def robot_parameters(spec: RobotSpec) -> dict[str, Any]:
    """Return `{name: value}` without the prefix `robot.`; the footprint as text, as in Nav2."""
    values = dataclasses.asdict(spec)
    parts = {name: values.pop(name) or {} for name in ("lidar", "battery")}
    parts["battery"].pop("initial", None)
    for name in WORLDS_OWN:
        del values[name]
    values["footprint"] = json.dumps([list(point) for point in spec.footprint])
    for part, items in parts.items():
        values.update({f"{part}.{name}": value for name, value in items.items()})
    return values


def frames_parameter(frames: Mapping[str, Transform]) -> str:
    """Return the places of a robot's links as the text of its navigator's parameter `frames`.

    Returns:
        JSON: x, y, z [m] and the quaternion x, y, z, w by name.
    """
    return json.dumps(
        {
            name: [round(float(v), 9) for v in (*place[:3, 3], *quaternion_of(place[:3, :3]))]
            for name, place in frames.items()
        }
    )


def frames_from_parameter(text: str) -> dict[str, tuple[float, ...]]:
    """Return the frames in a text of `frames_parameter`: seven numbers by the name of the link."""
    try:
        frames = {
            str(name): tuple(float(value) for value in place)
            for name, place in json.loads(text or "{}").items()
        }
    except (AttributeError, TypeError, ValueError) as error:
        raise ConfigError(f"frames is malformed: {error}") from None
    for name, place in frames.items():
        if len(place) != 7 or not all(map(math.isfinite, place)):
            raise ConfigError(f"frames: {name} is {place}; expected x, y, z and a quaternion")
    return frames


def robot_from_parameters(values: Mapping[str, Any]) -> RobotSpec:
    """Return the robot model in parameters written by `robot_parameters`."""
    parts: dict[str, dict[str, Any]] = {"": {}, "lidar": {}, "battery": {}}
    for name, value in values.items():
        part, _, key = name.rpartition(".")
        parts.setdefault(part, {})[key] = value
    own, lidar, battery = parts.pop(""), parts.pop("lidar"), parts.pop("battery")
    if parts:
        raise RobotModelError(f"the parameters robot.* describe no robot: {min(parts)} is unknown")
    try:
        own["footprint"] = tuple((float(x), float(y)) for x, y in json.loads(own["footprint"]))
        if battery:
            own["battery"] = BatterySpec(**battery)
        return RobotSpec(**own, lidar=LidarSpec(**lidar))
    except (ConfigError, KeyError, TypeError, ValueError) as error:
        raise RobotModelError(f"the parameters robot.* describe no robot: {error}") from None
