"""Reading of a robot's description (URDF): links, joints, collision shapes, masses.

What the simulation needs and no more: joints that do not move are folded away, so that a
`RobotModel` has one rigid group per joint that really moves.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from swarm_common.errors import MeshError, RobotModelError
from swarm_common.meshes import load_hull
from swarm_common.outline import bounds, volume
from swarm_common.packages import PackageFinder
from swarm_common.shapes import FloatArray, Part, Shape, Transform
from swarm_common.urdf_elements import (
    Geometry,
    Inertial,
    Joint,
    Link,
    MeshFile,
    read_joints,
    read_links,
)
from swarm_common.urdf_tree import read_tree, root_link

MOVING = ("continuous", "revolute", "prismatic")
DENSITY = 300.0  # [kg/m³] of a link whose mass is not given: a light box full of electronics
LEAST_MASS = 0.01  # [kg]
LEAST_INERTIA = 1e-9  # [kg m²] below which an inertia is taken for missing


@dataclass(frozen=True, slots=True)
class RigidGroup:
    """Links that move as one.

    Attributes:
        name: Of its first link.
        joint: Name of the joint that moves it; empty for the base.
        kind: Type of that joint.
        parent_from_group: At the joint's zero, in the frame of the group it hangs on.
        parent: Index of that group; -1 for the base.
        axis: Of the joint, in the group's frame.
        speed_limit: [rad/s] of the joint; inf if none is given.
        parts: Collision shapes in the group's frame.
        links: Name of the link of each part.
        mass: [kg]
        center: [m] of mass, in the group's frame.
        inertia: (3, 3) about the centre of mass.
    """

    name: str
    joint: str
    kind: str
    parent_from_group: Transform
    parent: int
    axis: FloatArray
    speed_limit: float
    parts: tuple[Part, ...]
    links: tuple[str, ...]
    mass: float
    center: FloatArray
    inertia: FloatArray


@dataclass(frozen=True, slots=True)
class RobotModel:
    """A robot as its description says; group 0 is the base, in the frame of the root link.

    Attributes:
        name: Of the <robot>.
        groups: Parents before children.
        fixed: root_from_link of the links of the base.
        notes: What was missing and how it was filled in.
    """

    name: str
    groups: tuple[RigidGroup, ...]
    fixed: dict[str, Transform] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def root_from_groups(self) -> list[Transform]:
        """Return where each group is in the root link's frame, joints at zero."""
        places: list[Transform] = []
        for group in self.groups:
            start = places[group.parent] if group.parent >= 0 else np.eye(4)
            places.append(start @ group.parent_from_group)
        return places


def parse_urdf(
    text: str,
    where: str,
    moving: Collection[str] | None = None,
    finder: PackageFinder | None = None,
    directory: Path = Path(),
) -> RobotModel:
    """Return the model that a URDF text describes.

    Args:
        text: The URDF.
        where: Its file, for messages.
        moving: Joints that move; the others are held at zero. None: all that can.
        finder: Of the packages of meshes.
        directory: From which relative paths of meshes start.

    Raises:
        RobotModelError: If the text is malformed; the message names `where` and the element.
    """
    root = read_tree(text, where)
    try:
        name = root.attrib["name"]
        links, joints = read_links(root), read_joints(root)
    except (ValueError, KeyError, TypeError) as cause:
        raise RobotModelError(f"{where}: malformed URDF: {cause}") from cause
    builder = _Builder(links, joints, where, moving, finder or PackageFinder(), directory)
    return builder.build(name or "robot", root_link(root))


@dataclass(slots=True)
class _Draft:
    """A group while its links are being collected."""

    name: str
    joint: str
    kind: str
    parent_from_group: Transform
    parent: int
    axis: FloatArray
    speed_limit: float
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
            self.kind,
            self.parent_from_group,
            self.parent,
            self.axis,
            self.speed_limit,
            tuple(self.parts),
            tuple(self.links),
            mass,
            center,
            inertia,
        )


class _Builder:
    """Walks the links and folds away the joints that do not move."""

    def __init__(
        self,
        links: list[Link],
        joints: list[Joint],
        where: str,
        moving: Collection[str] | None,
        finder: PackageFinder,
        directory: Path,
    ) -> None:
        self._links = {link.name: link for link in links}
        self._joints = joints
        self._where = where
        self._moving = moving
        self._finder = finder
        self._directory = directory
        self._drafts: list[_Draft] = []
        self._fixed: dict[str, Transform] = {}
        self._notes: list[str] = []

    def build(self, name: str, root: str) -> RobotModel:
        self._drafts.append(_Draft(root, "", "", np.eye(4), -1, np.zeros(3), math.inf))
        self._walk(root, 0, np.eye(4))
        groups = tuple(draft.finish() for draft in self._drafts)
        return RobotModel(name, groups, self._fixed, tuple(self._notes))

    def _walk(self, name: str, index: int, group_from_link: Transform) -> None:
        if index == 0:
            self._fixed[name] = group_from_link
        self._add_link(self._links[name], self._drafts[index], group_from_link)
        for joint in self._joints:
            if joint.parent != name:
                continue
            group_from_child = group_from_link @ joint.parent_from_child
            if self._is_moving(joint):
                self._drafts.append(_draft_of(joint, group_from_child, index, self._where))
                self._walk(joint.child, len(self._drafts) - 1, np.eye(4))
            else:
                self._walk(joint.child, index, group_from_child)

    def _is_moving(self, joint: Joint) -> bool:
        return joint.type in MOVING and (self._moving is None or joint.name in self._moving)

    def _add_link(self, link: Link, draft: _Draft, group_from_link: Transform) -> None:
        own: list[Part] = []
        where = f"{self._where}: link {link.name}"
        for collision in link.collisions:
            shape = self._shape(collision.geometry, where)
            own.append(Part(shape, collision.link_from_shape))
            draft.parts.append(Part(shape, group_from_link @ own[-1].body_from_part))
            draft.links.append(link.name)
        if link.inertial is not None:
            mass, center, tensor = _inertial(link.inertial)
            if mass <= 0.0 and (own or mass < 0.0):
                raise RobotModelError(f"{where}: its mass is {mass:g} kg; it must be positive")
            if own and mass > 0.0 and np.diag(tensor).min() < LEAST_INERTIA:
                tensor = _estimated(own, mass)[2]
                self._notes.append(f"link {link.name} has no inertia; that of its box is taken")
        elif own:
            mass, center, tensor = _estimated(own, None)
            self._notes.append(f"link {link.name} has no <inertial>; {mass:.2f} kg are assumed")
        else:
            return
        turn = group_from_link[:3, :3]
        center = turn @ center + group_from_link[:3, 3]
        draft.masses.append((mass, center, turn @ tensor @ turn.T))

    def _shape(self, geometry: Geometry, where: str) -> Shape:
        if not isinstance(geometry, MeshFile):
            return geometry
        if not geometry.filename:
            raise RobotModelError(
                f"{where}: its collision is neither box, cylinder, sphere nor mesh"
            )
        try:
            path = self._finder.resolve(geometry.filename, self._directory)
            return load_hull(path, geometry.scale)
        except (MeshError, RobotModelError) as cause:
            raise RobotModelError(f"{where}: its collision mesh: {cause}") from cause


def _draft_of(joint: Joint, parent_from_group: Transform, parent: int, where: str) -> _Draft:
    length = float(np.linalg.norm(joint.axis))
    if not length > 1e-6:
        raise RobotModelError(f"{where}: the axis of joint {joint.name} has no direction")
    return _Draft(
        joint.child,
        joint.name,
        joint.type,
        parent_from_group,
        parent,
        joint.axis / length if abs(length - 1.0) > 1e-9 else joint.axis,
        abs(joint.velocity) if joint.velocity else math.inf,
    )


def _inertial(inertial: Inertial) -> tuple[float, FloatArray, FloatArray]:
    """Return mass, centre and inertia about it, in the link's axes."""
    turn = inertial.link_from_inertial[:3, :3]
    center = inertial.link_from_inertial[:3, 3]
    return inertial.mass, center, turn @ inertial.inertia @ turn.T


def _estimated(parts: list[Part], mass: float | None) -> tuple[float, FloatArray, FloatArray]:
    """Return mass, centre and inertia of a link from the box around its shapes."""
    low, high = bounds(parts)
    x, y, z = high - low
    if mass is None:
        mass = max(LEAST_MASS, DENSITY * sum(volume(part.shape) for part in parts))
    tensor = np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) * mass / 12.0
    return mass, (low + high) / 2.0, np.maximum(tensor, np.eye(3) * 1e-8)
