"""Facts in a robot's description: drive, footprint, LiDAR, and limits where it has them."""

from __future__ import annotations

import copy
import itertools
import math
import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.model.beacon import FOOTPRINT_POINTS
from swarm_common.model.errors import RobotModelError, SwarmError
from swarm_common.model.outline import outline_around, placed_corners
from swarm_common.model.records import LidarSpec
from swarm_common.model.shapes import FloatArray, Part, Transform, transform_from_xyz_rpy
from swarm_describe.files.faults import Faults
from swarm_describe.files.packages import PackageFinder
from swarm_describe.robots.controllers import Controllers, read_controllers
from swarm_describe.robots.description import Origin, RobotModel, parse_urdf
from swarm_describe.robots.drive_tags import DriveTags
from swarm_describe.robots.drive_train import DriveTrain, car_message, find_drive
from swarm_describe.robots.gazebo_tags import RaySensor, read_drive, read_ray_sensors, read_steering
from swarm_describe.robots.grammar import description_notes
from swarm_describe.robots.lidar_choice import choose_lidar
from swarm_describe.robots.source import RobotSource
from swarm_describe.robots.urdf_tree import DESCRIBED, read_tree, root_link

BASE = "base_footprint"
SAME_PLACE = 0.005  # [m] by which the description's base_footprint may be off the wheels' centre
SCAN = "base_scan"  # frame of the scans
SAME_SCAN = 1e-4  # [m] and of a direction, between that frame and the LiDAR's place
# What the limits of joints and plugins are believed up to; more is written where nobody knows.
FASTEST_WHEEL = 50.0  # [rad/s], nearly 500 turns a minute
FASTEST = 3.0  # [m/s] of a robot among others
SHAPES = Origin("collision shapes")
LIMITS = ("max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta")
SIDEWAYS = ("max_vel_y", "acc_lim_y")


@dataclass(frozen=True, slots=True)
class Described:
    """A robot's data as far as its description has them."""

    urdf: str  # the description with base_footprint as its root, on the ground between the wheels
    model: RobotModel  # its bodies; only the driven wheels move
    values: dict[str, Any]  # of a `RobotSpec` by name, as far as they follow; `lidar` is a mapping
    doubts: dict[str, str]  # by name: what was said of a value, and is not believed


@dataclass(frozen=True, slots=True)
class Asked:
    """Settings of robot.yaml, which override the description; None where it has none."""

    drive: str | None = None  # of `DRIVES`
    wheels: tuple[Sequence[str], Sequence[str]] | None = None  # left and right joints
    wheel_radius: float | None = None  # [m]
    lidar: Mapping[str, Any] = field(default_factory=dict)  # the section of that name
    controllers: Sequence[Path] = ()  # parameter files of ros2_control
    stated: Collection[str] = ()  # names of all values there
    inertia: str = DESCRIBED  # where inertias come from, one of `INERTIA`


def describe(source: RobotSource, asked: Asked, faults: Faults) -> Described | None:
    """Return the facts that follow from a description; None if something of it is unusable."""
    try:
        return _describe(source, asked, faults)
    except SwarmError as error:
        faults.add(error)
        return None


def _describe(source: RobotSource, asked: Asked, faults: Faults) -> Described | None:
    where, finder = source.where, source.finder()
    text, notes = source.read()
    directory = source.settings.parent if source.urdf is None else source.urdf.parent
    root = read_tree(text, where, asked.inertia)
    notes += description_notes(root)
    place_meshes(root, finder, directory)
    tags, steering = _stated_drive(root, source, asked, directory, notes, faults)
    if steering is not None and asked.wheels is None and tags is None:
        faults.tell([f"{where}: {car_message(steering)}"])
    known = bool(faults)
    text = ET.tostring(root, encoding="unicode")  # as the model is read: a fault is told once
    every = parse_urdf(text, where, None, finder, directory, asked.inertia, faults)
    train: DriveTrain | None = None
    try:
        train = find_drive(every, where, tags, asked.drive, asked.wheels, asked.wheel_radius)
    except RobotModelError as error:
        if bool(faults) == known and steering is None:  # else what is missing may be what it lacks
            faults.add(error)
    center = np.zeros(3) if train is None else train.center
    based = _with_base(root, center)
    moving = () if train is None else (*train.left, *train.right)
    model = parse_urdf(based, where, moving, finder, directory, asked.inertia, faults)
    if bool(faults) == known:  # else the mass may be that of a mesh that is missing
        faults.tell(
            f"{where}: link {group.name} has no mass; give it an <inertial> or a <collision>"
            for group in model.groups
            if group.mass <= 0.0
        )
    values: dict[str, Any] = {}
    origins: dict[str, Origin] = {}
    doubts: dict[str, str] = {}
    if train is not None:
        limits = _Limits(train, tags, every)
        values |= _of_train(train) | limits.values
        origins |= train.origins | limits.origins
        doubts |= train.notes | limits.doubts
        with faults.caught():
            values |= _of_body(model, where)
            origins |= dict.fromkeys(("footprint", "height"), SHAPES)
    with faults.caught():
        sensors = read_ray_sensors(ET.fromstring(based), where, notes)
        lidar, remarks = choose_lidar(model, sensors, asked.lidar, where)
        notes += remarks
        if lidar:
            values["lidar"] = lidar
            origins["lidar"] = _of_lidar(lidar, sensors)
    if faults or train is None:
        return None
    doubts = {name: text for name, text in doubts.items() if name not in asked.stated}
    notes += [text for name, text in doubts.items() if name in (*values, "lever")]
    notes += _guesses(values, origins, asked)
    model = replace(model, notes=(*model.notes, *dict.fromkeys(notes)), origins=origins)
    return Described(based, model, values, doubts)


def _stated_drive(
    root: ET.Element,
    source: RobotSource,
    asked: Asked,
    directory: Path,
    notes: list[str],
    faults: Faults,
) -> tuple[DriveTags | None, str | None]:
    """Return the drive that a plugin or a controller states, and which one steers wheels."""
    plugin: DriveTags | None = None
    controllers = Controllers()
    with faults.caught():
        plugin = read_drive(root, source.where, notes)
    with faults.caught():
        finder = source.finder()
        controllers = read_controllers(root, asked.controllers, finder, directory)
    notes += controllers.notes
    steering = read_steering(root) or controllers.steering
    tags = controllers.tags
    if plugin is None or tags is None:
        return plugin or tags, steering
    if tags.drive != plugin.drive:
        notes.append(f"{tags.source} is not used: {plugin.source} comes before it")
        return plugin, steering
    more = {name: value for name, value in tags.values.items() if name not in plugin.values}
    joined = replace(
        plugin,
        left=plugin.left or tags.left,
        right=plugin.right or tags.right,
        values=plugin.values | more,
        origins=dict.fromkeys(more, tags.source),
    )
    return joined, steering


def _of_lidar(lidar: Mapping[str, Any], sensors: Sequence[RaySensor]) -> Origin:
    link = lidar["frame"]
    if any(sensor.link == link for sensor in sensors):
        return Origin(f"ray sensor on link {link}")
    return Origin(f"place of link {link}")


def _guesses(
    values: Mapping[str, Any], origins: Mapping[str, Origin], asked: Asked
) -> Iterator[str]:
    """Yield a sentence on each value that we had to guess."""
    for name, origin in origins.items():
        if not origin.is_guess or name in asked.stated or name == "wheels":
            continue
        value = values[name]
        text = value if isinstance(value, str) else f"{value:.4g}"
        yield f"{name} is {text} ({origin}); {name}: in robot.yaml wins"


def place_meshes(root: ET.Element, finder: PackageFinder, directory: Path) -> None:
    """Let every mesh that is found be named by its file: viewers need not know the packages."""
    for mesh in root.iter("mesh"):
        try:
            path = finder.resolve(mesh.get("filename", ""), directory)
        except SwarmError:
            continue  # only collision meshes have to be there
        mesh.set("filename", path.absolute().as_uri())


def _with_base(root: ET.Element, center: FloatArray) -> str:
    """Return the description with base_footprint on the ground between the wheels as its root."""
    top = root_link(root)
    if top == BASE and np.abs(center).max() <= SAME_PLACE:
        return ET.tostring(root, encoding="unicode")
    root = copy.deepcopy(root)
    links = {link.get("name") for link in root.findall("link")}
    if BASE in links:
        other = _free(f"{BASE}_of_model", links)
        top = other if top == BASE else top
        _rename_link(root, BASE, other)
    name = _free(f"{BASE}_joint", {joint.get("name") for joint in root.findall("joint")})
    joint = ET.Element("joint", name=name, type="fixed")
    x, y, z = (-center).tolist()
    ET.SubElement(joint, "parent", link=BASE)
    ET.SubElement(joint, "child", link=top)
    ET.SubElement(joint, "origin", xyz=f"{x:.9g} {y:.9g} {z:.9g}", rpy="0 0 0")
    root.insert(0, joint)
    root.insert(0, ET.Element("link", name=BASE))
    return ET.tostring(root, encoding="unicode")


def scan_place(lidar: LidarSpec) -> Transform:
    """Return base_footprint_from_scan."""
    roll = math.pi if lidar.upside_down else 0.0
    return transform_from_xyz_rpy(lidar.x, lidar.y, lidar.z, roll, 0.0, lidar.yaw)


def with_scan_frame(urdf: str, model: RobotModel, lidar: LidarSpec) -> str:
    """Return a description, perhaps the same, in which the link base_scan is where the LiDAR is.

    That is the frame of the scans. Viewers read from the description where it is.
    """
    roll = math.pi if lidar.upside_down else 0.0
    place = scan_place(lidar)
    seen = model.fixed.get(SCAN)
    if seen is not None and np.abs(seen - place).max() <= SAME_SCAN:
        return urdf
    root = ET.fromstring(urdf)
    links = {link.get("name") for link in root.findall("link")}
    if SCAN in links:
        _rename_link(root, SCAN, _free(f"{SCAN}_of_model", links))
    name = _free(f"{SCAN}_joint", {joint.get("name") for joint in root.findall("joint")})
    joint = ET.SubElement(root, "joint", name=name, type="fixed")
    ET.SubElement(joint, "parent", link=root_link(root))
    ET.SubElement(joint, "child", link=SCAN)
    xyz = f"{lidar.x:.9g} {lidar.y:.9g} {lidar.z:.9g}"
    ET.SubElement(joint, "origin", xyz=xyz, rpy=f"{roll:.9g} 0 {lidar.yaw:.9g}")
    ET.SubElement(root, "link", name=SCAN)
    return ET.tostring(root, encoding="unicode")


def _free(name: str, taken: Collection[str | None]) -> str:
    """Return the name, changed if it is taken already."""
    numbered = (f"{name}_{number}" for number in itertools.count(2))
    return next(one for one in itertools.chain([name], numbered) if one not in taken)


def _rename_link(root: ET.Element, old: str, new: str) -> None:
    for element in root.iter():
        for name in ("name", "link", "reference"):
            is_link = element.tag in ("link", "parent", "child", "gazebo")
            if is_link and element.get(name) == old:
                element.set(name, new)


def _of_train(train: DriveTrain) -> dict[str, Any]:
    return {
        "drive": train.drive,
        "wheel_radius": train.radius,
        "wheel_separation": train.separation,
        "wheel_base": train.wheel_base,
        "wheels_left": train.left,
        "wheels_right": train.right,
    }


class _Limits:
    """The limits that a plugin, a controller or the wheels' joints give."""

    def __init__(self, train: DriveTrain, tags: DriveTags | None, model: RobotModel) -> None:
        self.values: dict[str, float] = {}
        self.origins: dict[str, Origin] = {}
        self.doubts: dict[str, str] = {}  # by the value that is left out, or told, because of it
        half = (train.separation + (train.wheel_base if train.drive == "omni" else 0.0)) / 2.0
        if tags is not None:
            self._take_stated(tags, (*LIMITS, *(SIDEWAYS if train.drive == "omni" else ())))
        self._take_joints(train, model, half)
        if "acc_lim_x" in self.values and "acc_lim_theta" not in self.values:
            self.values["acc_lim_theta"] = self.values["acc_lim_x"] / half
            self.origins["acc_lim_theta"] = Origin(
                f"acc_lim_x over {half:.3g} m from the middle to the wheels", True
            )

    def _take_stated(self, tags: DriveTags, names: Sequence[str]) -> None:
        for name in names:
            if name not in tags.values:
                continue
            value, source = tags.values[name], tags.origins.get(name, tags.source)
            if name in ("max_vel_x", "max_vel_y") and value > FASTEST:
                self.doubts[name] = (
                    f"{source} states {value:g} m/s, which is not believed: "
                    f"robots among others drive up to {FASTEST:g} m/s"
                )
                continue
            self.values[name] = value
            self.origins[name] = Origin(source)

    def _take_joints(self, train: DriveTrain, model: RobotModel, half: float) -> None:
        joints = (*train.left, *train.right)
        wheels = [group for group in model.groups if group.joint in joints]
        slowest = min(wheels, key=lambda group: group.speed_limit, default=None)
        if slowest is None or not math.isfinite(slowest.speed_limit):
            return
        speed = slowest.speed_limit * train.radius
        stated = f"velocity limit {slowest.speed_limit:g} rad/s of joint {slowest.joint}"
        names = [name for name in ("max_vel_x", "max_vel_theta") if name not in self.values]
        if slowest.speed_limit > FASTEST_WHEEL or speed > FASTEST:
            for name in names:
                self.doubts.setdefault(
                    name,
                    f"the {stated} would be {speed:.3g} m/s, and is taken for a placeholder: "
                    f"limits up to {FASTEST_WHEEL:g} rad/s and {FASTEST:g} m/s are believed",
                )
            return
        for name in names:
            self.values[name] = speed / (1.0 if name == "max_vel_x" else half)
            self.origins[name] = Origin(
                f"{stated}, times the wheels' radius {train.radius:.4g} m"
                + ("" if name == "max_vel_x" else f", over {half:.3g} m to the wheels"),
                True,
            )


def _of_body(model: RobotModel, where: str) -> dict[str, Any]:
    parts = [
        Part(part.shape, place @ part.body_from_part)
        for group, place in zip(model.groups, model.root_from_groups(), strict=True)
        for part in group.parts
    ]
    points = placed_corners(parts)
    if not len(points):
        raise RobotModelError(f"{where}: no link has a <collision>; the robot has no body")
    try:
        footprint = outline_around(points[:, :2], FOOTPRINT_POINTS)
    except ValueError as cause:
        raise RobotModelError(f"{where}: its collision shapes have no footprint: {cause}") from None
    return {"footprint": [list(point) for point in footprint], "height": float(points[:, 2].max())}
