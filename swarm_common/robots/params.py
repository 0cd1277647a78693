"""A robot model as the ROS parameters `robot.*` of its navigator, and back."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from typing import Any

from swarm_common.model.errors import RobotModelError
from swarm_common.model.records import LidarSpec, RobotSpec

WORLDS_OWN = ("wheels_left", "wheels_right", "sensors")  # of no use to a navigator


def robot_parameters(spec: RobotSpec) -> dict[str, Any]:
    """Return `{name: value}` without the prefix `robot.`; the footprint as text, as in Nav2.

    Args:
        spec: Of the robot; what only the world needs of it is left out.
    """
    values = dataclasses.asdict(spec)
    lidar = values.pop("lidar")
    for name in WORLDS_OWN:
        del values[name]
    values["footprint"] = json.dumps([list(point) for point in spec.footprint])
    values.update({f"lidar.{name}": value for name, value in lidar.items()})
    return values


def robot_from_parameters(values: Mapping[str, Any]) -> RobotSpec:
    """Return the robot model in parameters written by `robot_parameters`.

    Args:
        values: By name, without the prefix `robot.`.

    Raises:
        RobotModelError: If a parameter is missing or unknown, or the footprint is not a polygon.
    """
    own = {name: value for name, value in values.items() if not name.startswith("lidar.")}
    lidar = {
        name.removeprefix("lidar."): value
        for name, value in values.items()
        if name.startswith("lidar.")
    }
    try:
        own["footprint"] = tuple((float(x), float(y)) for x, y in json.loads(own["footprint"]))
        return RobotSpec(**own, lidar=LidarSpec(**lidar))
    except (KeyError, TypeError, ValueError) as error:
        raise RobotModelError(f"the parameters robot.* describe no robot: {error}") from None
