"""Reading of a robot's description (URDF): links, joints, collision shapes, masses.

What the simulation needs and no more: joints that do not move are folded away, so that a
`RobotModel` has one rigid group per joint that really moves.
"""

from __future__ import annotations

import functools
import io
import math
import sys
import xml.etree.ElementTree as ET
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from swarm_common.files.storage import kept
from swarm_common.model.errors import DescriptionError, MissingPackageError, RobotModelError
from swarm_common.model.outline import estimated_inertia
from swarm_common.model.shapes import Box, Cylinder, FloatArray, Part, Shape, Sphere, Transform
from swarm_describe.files.faults import Faults
from swarm_describe.files.meshes import load_hull
from swarm_describe.files.packages import PackageFinder
from swarm_describe.robots.urdf_tree import DESCRIBED, OF_SHAPES, read_tree, root_link
from swarm_describe.worlds.scene import Body

MOVING = ("continuous", "revolute", "prismatic")
LEAST_INERTIA = 1e-9  # [kg m²] below which an inertia is taken for missing


@dataclass(frozen=True, slots=True)
class RigidGroup:
    """Links that move as one."""

    name: str  # of its first link
    joint: str  # name of the joint that moves it; empty for the base
    kind: str  # type of that joint
    parent_from_group: Transform  # at the joint's zero, in the frame of the group it hangs on
    parent: int  # index of that group; -1 for the base
    axis: FloatArray  # of the joint, in the group's frame
    speed_limit: float  # [rad/s] of the joint; inf if none is given
    parts: tuple[Part, ...]  # collision shapes in the group's frame
    links: tuple[str, ...]  # name of the link of each part
    mass: float  # [kg]
    center: FloatArray  # [m] of mass, in the group's frame
    inertia: FloatArray  # (3, 3) about the centre of mass


@dataclass(frozen=True, slots=True)
class Origin:
    """Origin of a value of a robot."""

    source: str
    is_guess: bool = False  # made by us; nothing states it

    def __str__(self) -> str:
        return f"guessed: {self.source}" if self.is_guess else self.source


@dataclass(frozen=True, slots=True)
class RobotModel:
    """A robot as its description says; group 0 is the base, in the frame of the root link."""

    name: str  # of the <robot>
    groups: tuple[RigidGroup, ...]  # parents before children
    # root_from_link of the links of the base
    fixed: dict[str, Transform] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # what was missing and how it was filled in
    origins: dict[str, Origin] = field(default_factory=dict)  # of the values derived from it

    def root_from_groups(self) -> list[Transform]:
        """Return where each group is in the root link's frame, joints at zero."""
        places: list[Transform] = []
        for group in self.groups:
            start = places[group.parent] if group.parent >= 0 else np.eye(4)
            places.append(start @ group.parent_from_group)
        return places

    def bodies(self) -> list[Body]:
        """Return the groups with shapes as bodies in the root link's frame, joints at zero."""
        return [
            Body(group.name, place, group.parts, False, group.mass)
            for group, place in zip(self.groups, self.root_from_groups(), strict=True)
            if group.parts
        ]


def parse_urdf(
    text: str,
    where: str,
    moving: Collection[str] | None = None,
    finder: PackageFinder | None = None,
    directory: Path = Path(),
    inertia: str = DESCRIBED,
    faults: Faults | None = None,
) -> RobotModel:
    """Return the model that a URDF text describes.

    Args:
        moving: Joints that move; the others are held at zero. None: all that can.
        finder: Finds the packages of meshes. None: one that searches where ROS would.
        inertia: One of `INERTIA`.
        faults: Receives faults of single links, which are left out then; None: raise them.
    """
    root = read_tree(text, where, inertia)

    def read() -> tuple[RobotModel, tuple[str, ...]]:
        robot = _read_robot(root, where)
        builder = _Builder(robot, where, moving, finder or PackageFinder(), directory, inertia)
        return builder.build(robot.name or "robot", root_link(root)), tuple(builder.faults)

    if root.find(".//collision//mesh") is not None:  # the files may change
        model, messages = read()
    else:
        joints = "all" if moving is None else repr(sorted(moving))
        parts: list[str | bytes] = [*_code(), where, joints, inertia, ET.tostring(root)]
        model, messages = kept("robots", parts, read)
    found = Faults(where, RobotModelError) if faults is None else faults
    found.tell(messages)
    if faults is None:
        found.check()
    return model


@functools.cache
def _code() -> list[bytes]:
    modules = (
        sys.modules[name] for name in (__name__, Part.__module__, estimated_inertia.__module__)
    )
    return [Path(str(module.__file__)).read_bytes() for module in modules]


def _read_robot(root: ET.Element, where: str) -> Any:
    """Return yourdfpy's reading of a checked tree."""
    import yourdfpy  # slow to import, and not needed for what is in the cache

    try:
        return yourdfpy.URDF.load(
            io.BytesIO(ET.tostring(root)), build_scene_graph=False, load_meshes=False
        ).robot
    except Exception as cause:  # whatever its float() and numpy calls raise
        raise RobotModelError(f"{where}: malformed URDF: {cause}") from cause


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
            inertia += own + m * ((arm * arm).sum() * np.eye(3) - np.outer(arm, arm))
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
    """Walks yourdfpy's links and folds away the joints that do not move."""

    def __init__(
        self,
        robot: Any,
        where: str,
        moving: Collection[str] | None,
        finder: PackageFinder,
        directory: Path,
        inertia: str,
    ) -> None:
        self.faults: list[str] = []
        self._packages: list[str] = []  # that are missing
        self._searched = ""
        self._of_shapes = inertia == OF_SHAPES
        self._links = {link.name: link for link in robot.links}
        self._joints = robot.joints
        self._where = where
        self._moving = moving
        self._finder = finder
        self._directory = directory
        self._drafts: list[_Draft] = []
        self._fixed: dict[str, Transform] = {}
        self._notes: list[str] = []
        self._unsolid: list[str] = []  # links that are drawn, and have no collision shape

    def build(self, name: str, root: str) -> RobotModel:
        self._drafts.append(_Draft(root, "", "", np.eye(4), -1, np.zeros(3), math.inf))
        self._walk(root, 0, np.eye(4))
        if self._packages:
            error = MissingPackageError(self._packages, self._searched)
            self.faults.append(f"{self._where}: its collision meshes: {error}")
        groups = tuple(draft.finish() for draft in self._drafts)
        if self._unsolid:
            self._notes.append(
                f"link {', '.join(self._unsolid)}: a <visual> without <collision> is only drawn;"
                " footprint and physics do not have it"
            )
        return RobotModel(name, groups, self._fixed, tuple(self._notes))

    def _walk(self, name: str, index: int, group_from_link: Transform) -> None:
        if index == 0:
            self._fixed[name] = group_from_link
        self._add_link(self._links[name], self._drafts[index], group_from_link)
        for joint in self._joints:
            if joint.parent != name:
                continue
            group_from_child = group_from_link @ _origin(joint.origin)
            if joint.type in MOVING and (self._moving is None or joint.name in self._moving):
                self._drafts.append(self._draft_of(joint, group_from_child, index))
                self._walk(joint.child, len(self._drafts) - 1, np.eye(4))
            else:
                self._walk(joint.child, index, group_from_child)

    def _draft_of(self, joint: Any, parent_from_group: Transform, parent: int) -> _Draft:
        length = math.hypot(*joint.axis)
        if not length > 1e-6:
            self.faults.append(f"{self._where}: the axis of joint {joint.name} has no direction")
            length = 1.0
        limit = getattr(joint.limit, "velocity", None)
        return _Draft(
            joint.child,
            joint.name,
            joint.type,
            parent_from_group,
            parent,
            joint.axis / length if abs(length - 1.0) > 1e-9 else joint.axis,
            math.inf if not limit else abs(float(limit)),
        )

    def _add_link(self, link: Any, draft: _Draft, group_from_link: Transform) -> None:
        own: list[Part] = []
        where = f"{self._where}: link {link.name}"
        if link.visuals and not link.collisions:
            self._unsolid.append(link.name)
        for collision in link.collisions:
            shape = self._shape(collision.geometry, where)
            if shape is None:
                continue
            own.append(Part(shape, _origin(collision.origin)))
            draft.parts.append(Part(shape, group_from_link @ own[-1].body_from_part))
            draft.links.append(link.name)
        if link.inertial is not None:
            mass, center, tensor = _inertial(link.inertial)
            is_fixed = link.name != draft.name
            if mass < 0.0 or (mass == 0.0 and own and not is_fixed):
                self.faults.append(f"{where}: its mass is {mass:g} kg; it must be positive")
                return
            if own and mass == 0.0:  # markers and plates of some exporters
                mass, center, tensor = estimated_inertia(own, None)
                self._notes.append(f"link {link.name} has a mass of 0; {mass:.2f} kg are taken")
            if self._of_shapes:
                if own:
                    _, center, tensor = estimated_inertia(own, mass)
                tensor = tensor if own else np.zeros((3, 3))
            elif own and mass > 0.0 and np.diag(tensor).min() < LEAST_INERTIA:
                tensor = estimated_inertia(own, mass)[2]
                self._notes.append(f"link {link.name} has no inertia; that of its box is taken")
        elif own:
            mass, center, tensor = estimated_inertia(own, None)
            self._notes.append(f"link {link.name} has no <inertial>; {mass:.2f} kg are assumed")
        else:
            return
        turn = group_from_link[:3, :3]
        center = turn @ center + group_from_link[:3, 3]
        draft.masses.append((mass, center, turn @ tensor @ turn.T))

    def _shape(self, geometry: Any, where: str) -> Shape | None:
        """Return a collision shape; None, noting why, if there is none."""
        if geometry is None:
            self.faults.append(f"{where}: malformed URDF: a collision without geometry")
            return None
        if geometry.box is not None:
            x, y, z = (float(edge) for edge in geometry.box.size)
            return Box((x, y, z))
        if geometry.cylinder is not None:
            return Cylinder(float(geometry.cylinder.radius), float(geometry.cylinder.length))
        if geometry.sphere is not None:
            return Sphere(float(geometry.sphere.radius))
        if geometry.mesh is None or not geometry.mesh.filename:
            self.faults.append(f"{where}: its collision is neither box, cylinder, sphere nor mesh")
            return None
        scale = geometry.mesh.scale
        x, y, z = np.broadcast_to(1.0 if scale is None else scale, 3).tolist()
        try:
            path = self._finder.resolve(geometry.mesh.filename, self._directory)
            return load_hull(path, (x, y, z))
        except MissingPackageError as cause:
            self._packages += cause.packages
            self._searched = cause.searched
            return None
        except DescriptionError as cause:
            self.faults.append(f"{where}: its collision mesh: {cause}")
            return None


def _inertial(inertial: Any) -> tuple[float, FloatArray, FloatArray]:
    link_from_inertial = _origin(inertial.origin)
    turn = link_from_inertial[:3, :3]
    tensor = np.zeros((3, 3)) if inertial.inertia is None else np.asarray(inertial.inertia, float)
    return float(inertial.mass or 0.0), link_from_inertial[:3, 3], turn @ tensor @ turn.T


def _origin(origin: FloatArray | None) -> Transform:
    return np.eye(4) if origin is None else origin
