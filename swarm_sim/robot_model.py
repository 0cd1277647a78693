"""Reading of a robot's description (URDF or xacro): links, joints, collision shapes, masses.

What the simulation needs and no more: fixed joints are folded away, so that a `RobotModel` has
one rigid group per joint that really moves.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swarm_common.errors import RobotModelError
from swarm_common.robot_io import robot_directory
from swarm_sim.scene import (
    Body,
    Box,
    Cylinder,
    Part,
    Shape,
    Sphere,
    Transform,
    transform_from_xyz_rpy,
)

FloatArray = NDArray[np.float64]
DESCRIPTIONS = ("model.urdf.xacro", "model.urdf")
MOVING = ("continuous", "revolute", "prismatic")


@dataclass(frozen=True, slots=True)
class RigidGroup:
    """Links that move as one.

    Attributes:
        name: Of its first link.
        joint: Name of the joint that moves it; empty for the base.
        parent_from_group: At the joint's zero, in the frame of the group it hangs on.
        parent: Index of that group; -1 for the base.
        axis: Of the joint, in the group's frame.
        parts: Collision shapes in the group's frame.
        links: Name of the link of each part.
        mass: [kg]
        center: [m] of mass, in the group's frame.
        inertia: (3, 3) about the centre of mass.
    """

    name: str
    joint: str
    parent_from_group: Transform
    parent: int
    axis: FloatArray
    parts: tuple[Part, ...]
    links: tuple[str, ...]
    mass: float
    center: FloatArray
    inertia: FloatArray


@dataclass(frozen=True, slots=True)
class RobotModel:
    """A robot as its description says; group 0 is the base, in the frame of the root link."""

    name: str
    groups: tuple[RigidGroup, ...]
    fixed: dict[str, Transform] = field(default_factory=dict)  # root_from_link of base links

    def bodies(self) -> list[Body]:
        """Return all groups as bodies in the root link's frame, joints at zero."""
        root_from_group: list[Transform] = []
        for group in self.groups:
            start = root_from_group[group.parent] if group.parent >= 0 else np.eye(4)
            root_from_group.append(start @ group.parent_from_group)
        return [
            Body(group.name, root_from_group[i], group.parts, False, group.mass)
            for i, group in enumerate(self.groups)
            if group.parts
        ]


def description(name_or_path: str | Path) -> str:
    """Return a robot's description as URDF text, xacro expanded.

    Raises:
        RobotModelError: If there is none or xacro refuses it.
    """
    directory = robot_directory(name_or_path)
    for name in DESCRIPTIONS:
        path = directory / name
        if path.is_file():
            return _expand(path) if name.endswith(".xacro") else path.read_text(encoding="utf-8")
    raise RobotModelError(f"{directory} has no {' or '.join(DESCRIPTIONS)}")


def load_robot_model(name_or_path: str | Path) -> RobotModel:
    """Return the model of a robot in `robots/` or of a path."""
    return parse_urdf(description(name_or_path), str(robot_directory(name_or_path)))


def parse_urdf(text: str, where: str) -> RobotModel:
    """Return the model that a URDF text describes.

    Raises:
        RobotModelError: If the text is malformed; the message names `where` and the element.
    """
    try:
        root = ET.fromstring(text)
    except ET.ParseError as cause:
        raise RobotModelError(f"{where}: malformed URDF: {cause}") from cause
    links = {link.get("name", ""): link for link in root.findall("link")}
    joints = root.findall("joint")
    children = {_target(joint, "child", links, where) for joint in joints}
    roots = [name for name in links if name not in children]
    if len(roots) != 1:
        raise RobotModelError(f"{where}: expected one root link, found {roots or 'none'}")
    by_parent: dict[str, list[ET.Element]] = {name: [] for name in links}
    for joint in joints:
        by_parent[_target(joint, "parent", links, where)].append(joint)
    return _Builder(links, by_parent, where).build(root.get("name", "robot"), roots[0])


def _expand(path: Path) -> str:
    import xacro  # slow to import, and not needed for plain URDF

    try:
        return str(xacro.process_file(str(path)).toxml())
    except Exception as cause:  # xacro raises its own and bare exceptions
        raise RobotModelError(f"{path}: xacro cannot expand it: {cause}") from cause


def _target(joint: ET.Element, tag: str, links: dict[str, ET.Element], where: str) -> str:
    element = joint.find(tag)
    name = "" if element is None else element.get("link", "")
    if name not in links:
        raise RobotModelError(
            f"{where}: <{tag}> of joint {joint.get('name')} names no link: '{name}'"
        )
    return name


@dataclass(slots=True)
class _Draft:
    """A group while its links are being collected."""

    name: str
    joint: str
    parent_from_group: Transform
    parent: int
    axis: FloatArray
    parts: list[Part] = field(default_factory=list)
    links: list[str] = field(default_factory=list)
    masses: list[tuple[float, FloatArray, FloatArray]] = field(default_factory=list)

    def finish(self) -> RigidGroup:
        mass = sum(m for m, _, _ in self.masses)
        center = np.zeros(3)
        if mass > 0.0:
            center = sum((m * c for m, c, _ in self.masses), center) / mass
        inertia = np.zeros((3, 3))
        for m, c, own in self.masses:  # parallel axes
            arm = c - center
            inertia += own + m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        return RigidGroup(
            self.name,
            self.joint,
            self.parent_from_group,
            self.parent,
            self.axis,
            tuple(self.parts),
            tuple(self.links),
            mass,
            center,
            inertia,
        )


class _Builder:
    """Walks the link tree and folds fixed joints away."""

    def __init__(
        self, links: dict[str, ET.Element], by_parent: dict[str, list[ET.Element]], where: str
    ) -> None:
        self._links = links
        self._by_parent = by_parent
        self._where = where
        self._drafts: list[_Draft] = []
        self._fixed: dict[str, Transform] = {}

    def build(self, name: str, root: str) -> RobotModel:
        self._drafts.append(_Draft(root, "", np.eye(4), -1, np.zeros(3)))
        self._walk(root, 0, np.eye(4))
        return RobotModel(name, tuple(draft.finish() for draft in self._drafts), self._fixed)

    def _walk(self, name: str, index: int, group_from_link: Transform) -> None:
        draft = self._drafts[index]
        where = f"{self._where}: link {name}"
        link = self._links[name]
        if index == 0:
            self._fixed[name] = group_from_link
        for collision in link.findall("collision"):
            group_from_part = group_from_link @ _origin(collision, where)
            draft.parts.append(Part(_shape(collision, where), group_from_part))
            draft.links.append(name)
        inertial = link.find("inertial")
        if inertial is not None:
            draft.masses.append(_inertial(inertial, group_from_link, where))
        for joint in self._by_parent[name]:
            child = _target(joint, "child", self._links, self._where)
            group_from_child = group_from_link @ _origin(joint, where)
            if joint.get("type") in MOVING:
                axis = _vector(joint.find("axis"), "xyz", 3, "1 0 0", where)
                self._drafts.append(
                    _Draft(child, joint.get("name", ""), group_from_child, index, np.array(axis))
                )
                self._walk(child, len(self._drafts) - 1, np.eye(4))
            else:
                self._walk(child, index, group_from_child)


def _inertial(
    inertial: ET.Element, group_from_link: Transform, where: str
) -> tuple[float, FloatArray, FloatArray]:
    group_from_inertial = group_from_link @ _origin(inertial, where)
    (mass,) = _vector(inertial.find("mass"), "value", 1, "0", where)
    element = inertial.find("inertia")
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    xx, xy, xz, yy, yz, zz = (_vector(element, key, 1, "0", where)[0] for key in keys)
    turn = group_from_inertial[:3, :3]
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return mass, group_from_inertial[:3, 3], turn @ tensor @ turn.T


def _shape(collision: ET.Element, where: str) -> Shape:
    geometry = collision.find("geometry")
    element = None if geometry is None else next(iter(geometry), None)
    if element is None:
        raise RobotModelError(f"{where}: a <collision> has no shape")
    if element.tag == "box":
        x, y, z = _vector(element, "size", 3, "", where)
        return Box((x, y, z))
    if element.tag == "cylinder":
        (radius,), (length,) = (_vector(element, key, 1, "", where) for key in ("radius", "length"))
        return Cylinder(radius, length)
    if element.tag == "sphere":
        return Sphere(_vector(element, "radius", 1, "", where)[0])
    raise RobotModelError(f"{where}: <{element.tag}> is not supported; use box, cylinder or sphere")


def _origin(element: ET.Element, where: str) -> Transform:
    origin = element.find("origin")
    return transform_from_xyz_rpy(
        *_vector(origin, "xyz", 3, "0 0 0", where), *_vector(origin, "rpy", 3, "0 0 0", where)
    )


def _vector(
    element: ET.Element | None, key: str, count: int, default: str, where: str
) -> list[float]:
    text = default if element is None else element.get(key, default)
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count:
        tag = "" if element is None else element.tag
        raise RobotModelError(f"{where}: {key} of <{tag}> is '{text}'; expected {count} numbers")
    return values
