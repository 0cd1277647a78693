"""What a robot's description says about it: drive, footprint, LiDAR, and limits where it can."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.beacon import FOOTPRINT_POINTS
from swarm_common.drive_train import DriveTrain, find_drive
from swarm_common.errors import RobotModelError, SwarmError
from swarm_common.gazebo_tags import DriveTags, LidarTags, read_drive, read_lidar
from swarm_common.outline import outline_around, placed_corners
from swarm_common.packages import PackageFinder
from swarm_common.robot_model import RobotModel, parse_urdf
from swarm_common.robot_source import RobotSource
from swarm_common.shapes import FloatArray, Part, transform_from_xyz_rpy
from swarm_common.urdf_tree import read_tree, root_link

BASE = "base_footprint"
SAME_PLACE = 0.005  # [m] by which the description's base_footprint may be off the wheels' centre
TILT = 0.1  # [rad] by which a scan plane may lean


@dataclass(frozen=True, slots=True)
class Described:
    """A robot as its description says it.

    Attributes:
        urdf: The description with base_footprint as its root, on the ground between the wheels.
        model: Its bodies; only the driven wheels move.
        values: Of a `RobotSpec` by name, as far as they follow; `lidar` is a mapping.
    """

    urdf: str
    model: RobotModel
    values: dict[str, Any]


def describe(
    source: RobotSource,
    drive: str | None = None,
    wheels: tuple[Sequence[str], Sequence[str]] | None = None,
    wheel_radius: float | None = None,
    lidar_frame: str | None = None,
) -> Described:
    """Return what follows from a description; the arguments are what robot.yaml says.

    Raises:
        RobotModelError: If the description is unusable.
    """
    where, finder = source.where, source.finder()
    text = source.text()
    directory = source.settings.parent if source.urdf is None else source.urdf.parent
    root = read_tree(text, where)
    place_meshes(root, finder, directory)
    drive_tags = read_drive(root, where)
    every = parse_urdf(text, where, None, finder, directory)
    train = find_drive(every, where, drive_tags, drive, wheels, wheel_radius)
    based = _with_base(root, train.center)
    moving = (*train.left, *train.right)
    model = parse_urdf(based, where, moving, finder, directory)
    _check_body(model, where)
    values: dict[str, Any] = _of_train(train) | _limits(train, drive_tags, every)
    values |= _of_body(model, where)
    lidar = _lidar(model, read_lidar(root, where), lidar_frame, where)
    if lidar:
        values["lidar"] = lidar
    return Described(based, model, values)


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
    if any(link.get("name") == BASE for link in root.findall("link")):
        other = f"{BASE}_of_model"
        top = other if top == BASE else top
        for element in root.iter():
            for name in ("name", "link", "reference"):
                if element.tag in ("link", "parent", "child", "gazebo") and (
                    element.get(name) == BASE
                ):
                    element.set(name, other)
    joint = ET.Element("joint", name=f"{BASE}_joint", type="fixed")
    x, y, z = (-center).tolist()
    ET.SubElement(joint, "parent", link=BASE)
    ET.SubElement(joint, "child", link=top)
    ET.SubElement(joint, "origin", xyz=f"{x:.9g} {y:.9g} {z:.9g}", rpy="0 0 0")
    root.insert(0, joint)
    root.insert(0, ET.Element("link", name=BASE))
    return ET.tostring(root, encoding="unicode")


def _check_body(model: RobotModel, where: str) -> None:
    for group in model.groups:
        if group.mass <= 0.0:
            raise RobotModelError(
                f"{where}: link {group.name} has no mass; give it an <inertial> or a <collision>"
            )


def _of_train(train: DriveTrain) -> dict[str, Any]:
    return {
        "drive": train.drive,
        "wheel_radius": train.radius,
        "wheel_separation": train.separation,
        "wheel_base": train.wheel_base,
        "wheels_left": train.left,
        "wheels_right": train.right,
    }


def _limits(train: DriveTrain, tags: DriveTags | None, model: RobotModel) -> dict[str, float]:
    """Return the limits that the plugin or the wheels' joints give."""
    known = dict(tags.values) if tags is not None else {}
    limits: dict[str, float] = {
        name: known[name]
        for name in ("max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta")
        if name in known
    }
    joints = (*train.left, *train.right)
    speed = min(group.speed_limit for group in model.groups if group.joint in joints)
    half = (train.separation + (train.wheel_base if train.drive == "omni" else 0.0)) / 2.0
    if math.isfinite(speed):
        limits.setdefault("max_vel_x", speed * train.radius)
        limits.setdefault("max_vel_theta", speed * train.radius / half)
    if "acc_lim_x" in limits:
        limits.setdefault("acc_lim_theta", limits["acc_lim_x"] / half)
    return limits


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


def _lidar(
    model: RobotModel, tags: LidarTags | None, frame: str | None, where: str
) -> dict[str, Any]:
    """Return the values of a `LidarSpec`, as far as they follow."""
    link = frame or (tags.link if tags is not None else None)
    if link is None:
        return {}
    if link not in model.fixed:
        raise RobotModelError(
            f"{where}: the LiDAR's link '{link}' is none of the body's: {sorted(model.fixed)}"
        )
    place = model.fixed[link]
    values: dict[str, Any] = {}
    if tags is not None and tags.link == link:
        place = place @ transform_from_xyz_rpy(*tags.pose)
        values = dict(tags.values)
    if place[2, 2] < math.cos(TILT):
        raise RobotModelError(
            f"{where}: the LiDAR on link '{link}' is tilted by "
            f"{math.degrees(math.acos(max(-1.0, place[2, 2]))):.0f} degrees; write the pose of its "
            "scan plane into robot.yaml, lidar: {x: ..., y: ..., z: ..., yaw: ...}"
        )
    x, y, z = place[:3, 3].tolist()
    yaw = math.atan2(place[1, 0], place[0, 0])
    return values | {"x": x, "y": y, "z": z, "yaw": yaw, "frame": link}
