"""Reading of a robot's description (URDF or xacro): links, joints, collision shapes, masses.

What the simulation needs and no more: fixed joints are folded away, so that a `RobotModel` has
one rigid group per joint that really moves.
"""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_common.errors import RobotModelError
from swarm_common.robot_io import robot_directory
from swarm_sim.scene import Body, Box, Cylinder, Part, Shape, Sphere, Transform

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
    import yourdfpy  # slow to import, and not needed by the readers of this module

    root = _check_tree(text, where)
    try:
        robot = yourdfpy.URDF.load(
            io.BytesIO(text.encode()), build_scene_graph=False, load_meshes=False
        ).robot
    except Exception as cause:  # whatever its float() and numpy calls raise
        raise RobotModelError(f"{where}: malformed URDF: {cause}") from cause
    return _Builder(robot, where).build(robot.name or "robot", root)


def _check_tree(text: str, where: str) -> str:
    """Return the root link's name; yourdfpy takes any tree, so it is checked before."""
    try:
        root = ET.fromstring(text.encode())
    except ET.ParseError as cause:
        raise RobotModelError(f"{where}: malformed URDF: {cause}") from cause
    links = [link.get("name", "") for link in root.findall("link")]
    children = set()
    for joint in root.findall("joint"):
        for tag in ("parent", "child"):
            element = joint.find(tag)
            name = "" if element is None else element.get("link", "")
            if name not in links:
                raise RobotModelError(
                    f"{where}: <{tag}> of joint {joint.get('name')} names no link: '{name}'"
                )
        children.add(name)
    roots = [name for name in links if name not in children]
    if len(roots) != 1:
        raise RobotModelError(f"{where}: expected one root link, found {roots or 'none'}")
    return roots[0]


def _expand(path: Path) -> str:
    import xacro  # slow to import, and not needed for plain URDF

    try:
        return str(xacro.process_file(str(path)).toxml())
    except Exception as cause:  # xacro raises its own and bare exceptions
        raise RobotModelError(f"{path}: xacro cannot expand it: {cause}") from cause


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
    """Walks yourdfpy's links and folds fixed joints away."""

    def __init__(self, robot: Any, where: str) -> None:
        self._links = {link.name: link for link in robot.links}
        self._joints = robot.joints
        self._where = where
        self._drafts: list[_Draft] = []
        self._fixed: dict[str, Transform] = {}

    def build(self, name: str, root: str) -> RobotModel:
        self._drafts.append(_Draft(root, "", np.eye(4), -1, np.zeros(3)))
        self._walk(root, 0, np.eye(4))
        return RobotModel(name, tuple(draft.finish() for draft in self._drafts), self._fixed)

    def _walk(self, name: str, index: int, group_from_link: Transform) -> None:
        draft = self._drafts[index]
        link = self._links[name]
        if index == 0:
            self._fixed[name] = group_from_link
        for collision in link.collisions:
            shape = _shape(collision.geometry, f"{self._where}: link {name}")
            draft.parts.append(Part(shape, group_from_link @ _origin(collision.origin)))
            draft.links.append(name)
        if link.inertial is not None:
            draft.masses.append(_inertial(link.inertial, group_from_link))
        for joint in self._joints:
            if joint.parent != name:
                continue
            group_from_child = group_from_link @ _origin(joint.origin)
            if joint.type in MOVING:
                self._drafts.append(
                    _Draft(joint.child, joint.name, group_from_child, index, joint.axis)
                )
                self._walk(joint.child, len(self._drafts) - 1, np.eye(4))
            else:
                self._walk(joint.child, index, group_from_child)


def _inertial(inertial: Any, group_from_link: Transform) -> tuple[float, FloatArray, FloatArray]:
    """Return mass, centre and inertia about it, in the group's axes."""
    group_from_inertial = group_from_link @ _origin(inertial.origin)
    turn = group_from_inertial[:3, :3]
    tensor = np.zeros((3, 3)) if inertial.inertia is None else inertial.inertia
    return float(inertial.mass or 0.0), group_from_inertial[:3, 3], turn @ tensor @ turn.T


def _origin(origin: FloatArray | None) -> Transform:
    return np.eye(4) if origin is None else origin


def _shape(geometry: Any, where: str) -> Shape:
    if geometry.box is not None:
        if len(geometry.box.size) != 3:
            raise RobotModelError(f"{where}: box size is {geometry.box.size}; expected 3 numbers")
        x, y, z = (float(edge) for edge in geometry.box.size)
        return Box((x, y, z))
    if geometry.cylinder is not None:
        return Cylinder(float(geometry.cylinder.radius), float(geometry.cylinder.length))
    if geometry.sphere is not None:
        return Sphere(float(geometry.sphere.radius))
    raise RobotModelError(f"{where}: its collision is a mesh; use box, cylinder or sphere")
