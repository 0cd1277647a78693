"""Drive and LiDAR in the `<gazebo>` elements of a URDF, of Classic and of Sim."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from swarm_common.model.errors import close_names
from swarm_common.model.shapes import Transform
from swarm_describe.files.values import number_in, pose_of
from swarm_describe.robots.drive_tags import DriveTags, drive_of, is_steered

LEFT = tuple(
    """
    left_joint leftJoint leftFrontJoint leftRearJoint front_left_joint back_left_joint
    rear_left_joint left_front_joint left_rear_joint frontLeftJoint rearLeftJoint backLeftJoint
    """.split()
)
RIGHT = tuple(name.replace("left", "right").replace("Left", "Right") for name in LEFT)
# value of a RobotSpec -> names of plugin parameters; a diameter counts half
# RMF's slotcar has base_width, tire_radius and nominal_...; <max_velocity> and <max_acceleration>
# limit both motions
VALUES = {
    "wheel_separation": "wheel_separation wheelSeparation base_width",
    "wheel_base": "wheelbase wheel_base",
    "wheel_radius": "wheel_radius wheelRadius wheel_diameter wheelDiameter tire_radius",
    "max_vel_x": "max_linear_velocity max_velocity nominal_drive_speed",
    "max_vel_theta": "max_angular_velocity max_velocity nominal_turn_speed",
    "acc_lim_x": "max_linear_acceleration max_acceleration "
    "max_wheel_acceleration wheelAcceleration nominal_drive_acceleration",
    "acc_lim_theta": "max_angular_acceleration max_acceleration nominal_turn_acceleration",
}
# Parameters of these plugins that concern topics, frames, forces and the like.
OF_NO_CONCERN = re.compile(
    r"(odom|tf_?|.*_?topic.*|.*topic(name)?|.*frame.*|.*publish.*|ros|namespace|robotnamespace|"
    r"update_?rate|.*torque.*|min_.*|max_(.*_)?jerk|num_wheel_pairs|covariance.*|.*covariance.*|"
    r"odometry.*|broadcast_?tf|always_?on|.*debug.*|legacy_?mode|command_?timeout|cmd_?vel.*|"
    r"rosdebuglevel|.*gain.*|.*_p|.*_i|.*_d|initial_(linear|angular)|link_name|alwayson|max_(drive|turn)_acceleration|"
    r"stop_(distance|radius)|nominal_(voltage|capacity)|steering|reversible)",
    re.IGNORECASE,
)
STEERING = "steering"  # parameter of RMF's slotcar
RAY_SENSORS = ("ray", "gpu_ray", "lidar", "gpu_lidar")
ROUNDED = 0.005  # [rad] by which a full turn may be less: 6.28, or 3.14 to either side
OTHER_SENSORS = tuple(
    """
    air_pressure air_speed altimeter boundingbox_camera camera contact custom depth depth_camera
    force_torque gps imu logical_camera magnetometer multicamera navsat rfid rfidtag rgbd
    rgbd_camera segmentation sonar segmentation_camera thermal thermal_camera wide_angle_camera
    wideanglecamera wireless_receiver wireless_transmitter
    """.split()
)


@dataclass(frozen=True, slots=True)
class RaySensor:
    """A ray sensor."""

    link: str  # that carries it
    pose: Transform  # link_from_sensor
    values: dict[str, float] = field(default_factory=dict)  # of a `LidarSpec`, by name
    layers: int = 1  # of rays, one above the other


def read_drive(root: ET.Element, where: str, notes: list[str]) -> DriveTags | None:
    """Return the statements of the first drive plugin, None if there is none."""
    found: DriveTags | None = None
    for plugin in root.findall("gazebo//plugin"):
        name = plugin_name(plugin)
        drive = drive_of(name)
        if drive is None or is_steered(plugin.findtext(STEERING, "")):
            continue
        if found is not None:
            notes.append(f"plugin {name} is not used: {found.source} comes before it")
            continue
        values: dict[str, float] = {}
        for value, names in VALUES.items():
            for tag in names.split():
                if value not in values and (number := _number(plugin, tag, where)) is not None:
                    values[value] = (0.5 if "iameter" in tag else 1.0) * number
        left, right = _texts(plugin, LEFT), _texts(plugin, RIGHT)
        if drive == "differential" and len(left) > 1:
            drive = "skid"
        for value in [value for value, number in values.items() if number <= 0.0]:
            notes.append(f"plugin {name}: {value} is {values.pop(value):g}, which is not used")
        notes += _unknown(plugin, name)
        found = DriveTags(drive, f"plugin {name}", left, right, values)
    return found


def plugin_name(plugin: ET.Element) -> str:
    """Return the class of a plugin if it names one, else its file.

    In Gazebo Classic `name` is of the user's choice, and says nothing of what the plugin does.
    """
    name = plugin.get("name", "")
    file = plugin.get("filename", "").rpartition("/")[2]
    return name if "::" in name or not file else file


def _unknown(plugin: ET.Element, name: str) -> Iterator[str]:
    """Yield a note on each parameter that drive plugins do not have."""
    known = {*LEFT, *RIGHT, *" ".join(VALUES.values()).split()}
    for child in plugin:
        is_foreign = "}" in str(child.tag)  # of another namespace
        if child.tag not in known and not is_foreign and not OF_NO_CONCERN.fullmatch(child.tag):
            close = close_names(str(child.tag), known, 1)
            advice = f"; did you mean <{close[0]}>?" if close else ""
            yield f"plugin {name}: <{child.tag}> is not known and not used{advice}"
    for tag in known - {*LEFT, *RIGHT}:
        if len(plugin.findall(tag)) > 1:
            yield f"plugin {name}: <{tag}> occurs twice; the first counts"


def read_steering(root: ET.Element) -> str | None:
    """Return the plugin that says that the robot steers its wheels, None if none does."""
    for plugin in root.findall("gazebo//plugin"):
        name, text = plugin_name(plugin), plugin.findtext(STEERING, "")
        if is_steered(name) or (drive_of(name) is not None and is_steered(text)):
            return f"plugin {name}"
    return None


def read_ray_sensors(root: ET.Element, where: str, notes: list[str]) -> list[RaySensor]:
    """Return all ray sensors on links, in the order of the file."""
    sensors = []
    links = {link.get("name") for link in root.findall("link")}
    for gazebo in root.findall("gazebo"):
        for sensor in gazebo.iter("sensor"):
            link = gazebo.get("reference", "")
            scan = _first(sensor, ("ray", "lidar"))
            kind = sensor.get("type", "")
            is_ray = kind in RAY_SENSORS
            if not is_ray and scan is None:
                if kind not in OTHER_SENSORS:
                    notes.append(f"sensor {sensor.get('name')}: type '{kind}' is not known")
                continue
            wrong = (
                f"type '{kind}' is none of {', '.join(RAY_SENSORS)}" if not is_ray
                else "it has no <ray> or <lidar>" if scan is None
                else "its <gazebo> has no reference to a link" if not link
                else f"there is no link '{link}'" if link not in links else ""
            )  # fmt: skip
            if wrong or scan is None:
                notes.append(f"ray sensor {sensor.get('name')} is not used: {wrong}")
                continue
            layers = _number(scan, "scan/vertical/samples", where)
            pose = pose_of(sensor, f"{where}: <gazebo>: a sensor")
            values = _scan_values(sensor, scan, where)
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
    share = _number(scan, "scan/horizontal/resolution", where)
    if share is not None and share > 0.0 and found["rays"] is not None:
        found["rays"] = float(round(found["rays"] * share))
    last = _number(scan, "scan/horizontal/max_angle", where)
    first, rays = found["angle_min"], found["rays"]
    if last is not None and first is not None and last < first:
        first, last = last, first
        found["angle_min"] = first
    if last is not None and first is not None and rays is not None and rays >= 1.0:
        if last - first > math.tau - ROUNDED:  # a full turn: its end is its beginning
            found["angle_increment"] = math.tau / rays
        else:
            found["angle_increment"] = (last - first) / max(1.0, rays - 1.0)
    return {name: value for name, value in found.items() if value is not None}


def _first(element: ET.Element, tags: Iterable[str]) -> ET.Element | None:
    for tag in tags:
        if (child := element.find(tag)) is not None:
            return child
    return None


def _texts(plugin: ET.Element, tags: Iterable[str]) -> tuple[str, ...]:
    texts = [(e.text or "").strip().lstrip("/") for tag in tags for e in plugin.findall(tag)]
    return tuple(dict.fromkeys(text for text in texts if text))


def _number(element: ET.Element, path: str, where: str) -> float | None:
    return number_in(element, path, f"{where}: <gazebo>", is_finite=True)
