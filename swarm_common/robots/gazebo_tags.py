"""What the `<gazebo>` elements of a URDF say about drive and LiDAR, of Classic and of Sim."""

from __future__ import annotations

import contextlib
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from swarm_common.model.errors import RobotModelError

# plugin file name or system name -> drive; the first that fits counts
PLUGINS = (
    ("skid_steer", "skid"),
    ("diff_drive", "differential"),
    ("diff-drive", "differential"),
    ("diffdrive", "differential"),
    ("mecanum", "omni"),
    ("planar_move", "omni"),
    ("velocity-control", "omni"),
    ("velocitycontrol", "omni"),
)
MOVERS = ("planar_move", "velocity-control", "velocitycontrol")  # they move the body itself
CAR = re.compile("ackermann|tricycle|bicycle|four_wheel_steering", re.IGNORECASE)
CAR_CONTROLLER = re.compile(
    r"(?:ackermann|bicycle|tricycle)(?:_steering)?_controller/\w+", re.IGNORECASE
)
LEFT = (
    "left_joint", "leftJoint", "leftFrontJoint", "leftRearJoint", "front_left_joint",
    "back_left_joint", "rear_left_joint", "left_front_joint", "left_rear_joint",
)  # fmt: skip
RIGHT = tuple(name.replace("left", "right") for name in LEFT)
# value of a RobotSpec -> names of plugin parameters, and by what they are multiplied
VALUES: dict[str, tuple[tuple[str, float], ...]] = {
    "wheel_separation": (("wheel_separation", 1.0), ("wheelSeparation", 1.0)),
    "wheel_base": (("wheelbase", 1.0), ("wheel_base", 1.0)),
    "wheel_radius": (
        ("wheel_radius", 1.0),
        ("wheelRadius", 1.0),
        ("wheel_diameter", 0.5),
        ("wheelDiameter", 0.5),
    ),
    "max_vel_x": (("max_linear_velocity", 1.0),),
    "max_vel_theta": (("max_angular_velocity", 1.0),),
    "acc_lim_x": (
        ("max_linear_acceleration", 1.0),
        ("max_wheel_acceleration", 1.0),
        ("wheelAcceleration", 1.0),
    ),
    "acc_lim_theta": (("max_angular_acceleration", 1.0),),
}
RAY_SENSORS = ("ray", "gpu_ray", "lidar", "gpu_lidar")


@dataclass(frozen=True, slots=True)
class DriveTags:
    """A drive plugin: the drive, its joints, and values of a `RobotSpec` by name.

    A plugin that moves the body itself (`moves_body`) works without turning wheels.
    """

    drive: str
    left: tuple[str, ...] = ()
    right: tuple[str, ...] = ()
    values: dict[str, float] = field(default_factory=dict)
    moves_body: bool = False


@dataclass(frozen=True, slots=True)
class RaySensor:
    """A ray sensor."""

    link: str  # that carries it
    pose: tuple[float, ...] = (0.0,) * 6  # there: x y z roll pitch yaw
    values: dict[str, float] = field(default_factory=dict)  # of a `LidarSpec`, by name
    layers: int = 1  # of rays, one above the other


def read_drive(root: ET.Element, where: str) -> DriveTags | None:
    """Return what the first drive plugin says, None if there is none.

    Raises:
        RobotModelError: If a parameter of the plugin is not a number.
    """
    for plugin in root.findall("gazebo//plugin"):
        name = f"{plugin.get('filename', '')} {plugin.get('name', '')}".lower()
        drive = next((drive for key, drive in PLUGINS if key in name), None)
        if drive is None:
            continue
        values: dict[str, float] = {}
        for value, names in VALUES.items():
            for tag, factor in names:
                if value not in values and (number := _number(plugin, tag, where)) is not None:
                    values[value] = factor * number
        left, right = _texts(plugin, LEFT), _texts(plugin, RIGHT)
        if drive == "differential" and len(left) > 1:
            drive = "skid"
        moves_body = any(key in name for key in MOVERS)
        positive = {k: v for k, v in values.items() if v > 0.0}
        return DriveTags(drive, left, right, positive, moves_body)
    return None


def read_car(root: ET.Element) -> str | None:
    """Return what says that the robot steers like a car: a plugin or a controller; None if none.

    Args:
        root: Of the URDF; parameter files of ros2_control that it names are read, if they are
            there.
    """
    for plugin in root.findall("gazebo//plugin"):
        name = f"{plugin.get('filename', '')} {plugin.get('name', '')}"
        if CAR.search(name):
            return f"plugin {name.strip()}"
        for element in plugin.findall("parameters"):  # of ros2_control
            path = Path((element.text or "").strip().removeprefix("file://"))
            with contextlib.suppress(OSError, ValueError):
                text = path.read_text(encoding="utf-8", errors="replace")
                if found := CAR_CONTROLLER.search(text):
                    return f"controller {found.group()} in {path}"
    return None


def read_ray_sensors(root: ET.Element, where: str) -> list[RaySensor]:
    """Return all ray sensors on links, in the order of the file.

    Raises:
        RobotModelError: If a number of a sensor is none, or its pose is not six of them.
    """
    sensors = []
    for gazebo in root.findall("gazebo"):
        for sensor in gazebo.iter("sensor"):
            link = gazebo.get("reference", "")
            scan = _first(sensor, ("ray", "lidar"))
            if sensor.get("type") not in RAY_SENSORS or scan is None or not link:
                continue
            layers = _number(scan, "scan/vertical/samples", where)
            pose, values = _pose(sensor, where), _scan_values(sensor, scan, where)
            sensors.append(RaySensor(link, pose, values, 1 if layers is None else int(layers)))
    return sensors


def _scan_values(sensor: ET.Element, scan: ET.Element, where: str) -> dict[str, float]:
    found: dict[str, float | None] = {
        "rays": _number(scan, "scan/horizontal/samples", where),
        "angle_min": _number(scan, "scan/horizontal/min_angle", where),
        "range_min": _number(scan, "range/min", where),
        "range_max": _number(scan, "range/max", where),
        "rate": _number(sensor, "update_rate", where),
        "sigma": _number(scan, "noise/stddev", where),
    }
    last = _number(scan, "scan/horizontal/max_angle", where)
    first, rays = found["angle_min"], found["rays"]
    if last is not None and first is not None and last < first:
        first, last = last, first
        found["angle_min"] = first
    if last is not None and first is not None and rays is not None and rays >= 1.0:
        if last - first > 0.99 * math.tau:  # a full turn: its end is its beginning
            found["angle_increment"] = math.tau / rays
        else:
            found["angle_increment"] = (last - first) / max(1.0, rays - 1.0)
    return {name: value for name, value in found.items() if value is not None}


def _pose(sensor: ET.Element, where: str) -> tuple[float, ...]:
    text = sensor.findtext("pose") or "0 0 0 0 0 0"
    try:
        pose = tuple(float(word) for word in text.split())
    except ValueError:
        pose = ()
    if len(pose) != 6 or not all(map(math.isfinite, pose)):
        raise RobotModelError(f"{where}: <gazebo>: <pose> of a sensor is '{text}'; six numbers")
    return pose


def _first(element: ET.Element, tags: Iterable[str]) -> ET.Element | None:
    for tag in tags:
        if (child := element.find(tag)) is not None:
            return child
    return None


def _texts(plugin: ET.Element, tags: Iterable[str]) -> tuple[str, ...]:
    texts = [(e.text or "").strip().lstrip("/") for tag in tags for e in plugin.findall(tag)]
    return tuple(dict.fromkeys(text for text in texts if text))


def _number(element: ET.Element, path: str, where: str) -> float | None:
    text = element.findtext(path)
    if text is None or not text.strip():
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RobotModelError(f"{where}: <gazebo>: <{path}> is '{text.strip()}'; a number")
    return value
