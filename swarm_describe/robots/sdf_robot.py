"""A robot described in SDF, as Gazebo's models are: its links and joints as a URDF tree.

An SDF model names poses in frames of its own, a URDF a tree of joints. Where a link hangs is worked
out from these frames; sensors and plugins become `<gazebo>` elements, which the readers of drives
and LiDARs know.
"""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from swarm_common.model.errors import DescriptionError, RobotModelError
from swarm_common.model.shapes import FloatArray, Transform, inverse_of
from swarm_describe.files.model_paths import ModelPaths
from swarm_describe.files.values import (
    color_of,
    flag_of,
    floats_of,
    number_in,
    pose_of,
    sizes_of,
    text_of,
)
from swarm_describe.robots.urdf_tree import INERTIAS
from swarm_describe.worlds.frames import Scope, base_of
from swarm_describe.worlds.models import model_file
from swarm_describe.worlds.source import Source

ENDLESS = 1e4  # [rad] from which the limits of a revolute joint are none
# type of a joint in SDF -> in URDF; those that a robot's casters have are held still
KINDS = {
    "fixed": "fixed", "revolute": "revolute", "continuous": "continuous", "prismatic": "prismatic",
    "ball": "fixed", "universal": "fixed", "screw": "fixed", "revolute2": "fixed",
    "gearbox": "fixed",
}  # fmt: skip


def find_model_file(folder: Path) -> Path | None:
    """Return the SDF file of a model's folder; None if it is no such folder."""
    if not any((folder / name).is_file() for name in ("model.config", "model.sdf")):
        return None
    try:
        return model_file(folder, Source(folder, ModelPaths(folder)))
    except DescriptionError as cause:
        raise RobotModelError(str(cause)) from cause


def urdf_of(root: ET.Element, where: str) -> str:
    """Return an SDF model as URDF text.

    What its elements hold that nothing reads, `grammar` tells.
    """
    if root.find("world") is not None:
        raise RobotModelError(f"{where} is a world; a robot is an <sdf> with one <model>")
    models = root.findall("model")
    if len(models) != 1:
        raise RobotModelError(f"{where}: found {len(models)} <model> in <sdf>; expected one")
    try:
        return ET.tostring(_Converter(models[0]).urdf(), encoding="unicode")
    except DescriptionError as cause:
        raise RobotModelError(f"{where}: {cause}") from cause


class _Converter:
    """One model, its frames, and the URDF that is made of it."""

    def __init__(self, model: ET.Element) -> None:
        self._model = model
        self._where = f"model '{model.get('name', '')}'"
        for tag in ("model", "include"):
            if model.find(tag) is not None:
                raise RobotModelError(
                    f"{self._where} holds other models (<{tag}>), which are not read; write their "
                    "links and joints into it"
                )
        if flag_of(model, "static"):
            raise RobotModelError(f"{self._where} is <static>, so it cannot drive")
        self._joints = [j for j in model.findall("joint") if text_of(j, "parent") != "world"]
        self._scope = Scope(self._where)
        self._scope.add_all(model)

    def urdf(self) -> ET.Element:
        robot = ET.Element("robot", name=self._model.get("name") or "robot")
        moving = {text_of(j, "child"): j for j in self._joints if _kind(j) != "fixed"}
        places: dict[str, Transform] = {}  # model_from_link, as the URDF has it
        for link in self._model.findall("link"):
            name = link.get("name", "")
            place = self._scope.frame(name)
            if name in moving:  # a URDF's link is where its joint is
                place = place.copy()
                place[:3, 3] = self._scope.frame(moving[name].get("name", ""))[:3, 3]
            places[name] = place
            robot.append(self._link(link, place, robot))
        for joint in self._joints:
            robot.append(self._joint(joint, places))
        gazebo = ET.SubElement(robot, "gazebo")
        for child in self._model:
            if child.tag == "plugin":
                gazebo.append(copy.deepcopy(child))
        return robot

    def _link(self, link: ET.Element, place: Transform, robot: ET.Element) -> ET.Element:
        made = ET.Element("link", link.attrib)
        here = f"{self._where}, link '{link.get('name')}'"
        for child in link:
            if child.tag == "inertial":
                made.append(self._inertial(child, link, place, here))
            elif child.tag in ("collision", "visual"):
                solid = self._solid(child, link, place, here)
                if solid is not None:
                    made.append(solid)
            elif child.tag == "sensor":
                gazebo = ET.SubElement(robot, "gazebo", reference=link.get("name", ""))
                gazebo.append(self._sensor(child, link, place, here))
        return made

    def _inertial(
        self, inertial: ET.Element, link: ET.Element, place: Transform, here: str
    ) -> ET.Element:
        made = ET.Element("inertial")
        made.append(_origin(self._in_link(inertial, link, place, here)))
        mass = number_in(inertial, "mass", here)
        ET.SubElement(made, "mass", value=repr(1.0 if mass is None else mass))
        values = {name: number_in(inertial, f"inertia/{name}", here) or 0.0 for name in INERTIAS}
        ET.SubElement(made, "inertia", {name: repr(value) for name, value in values.items()})
        return made

    def _solid(
        self, solid: ET.Element, link: ET.Element, place: Transform, here: str
    ) -> ET.Element | None:
        here = f"{here}, {solid.tag} '{solid.get('name')}'"
        geometry = solid.find("geometry")
        is_collision = solid.tag == "collision"
        if geometry is None and is_collision:
            raise RobotModelError(f"{here} has no <geometry>")
        shape = None if geometry is None else _shape(geometry, here, is_collision)
        if shape is None:
            return None
        made = ET.Element(solid.tag, name=solid.get("name", ""))
        made.append(_origin(self._in_link(solid, link, place, here)))
        ET.SubElement(made, "geometry").append(shape)
        rgba = None if is_collision else color_of(solid.find("material/diffuse"), here)
        if rgba is not None:
            material = ET.SubElement(made, "material", name=f"{link.get('name')}_color")
            ET.SubElement(material, "color", rgba=" ".join(map(repr, rgba)))
        return made

    def _sensor(
        self, sensor: ET.Element, link: ET.Element, place: Transform, here: str
    ) -> ET.Element:
        made = copy.deepcopy(sensor)
        for pose in made.findall("pose"):
            made.remove(pose)
        xyz, rpy = _xyz_rpy(self._in_link(sensor, link, place, here))
        ET.SubElement(made, "pose").text = f"{xyz} {rpy}"
        return made

    def _joint(self, joint: ET.Element, places: dict[str, Transform]) -> ET.Element:
        name, kind = joint.get("name", ""), _kind(joint)
        here = f"{self._where}, joint '{name}'"
        parent, child = text_of(joint, "parent"), text_of(joint, "child")
        if kind not in KINDS.values():
            raise RobotModelError(f"{here} is of type '{kind}'; expected {', '.join(KINDS)}")
        for end in (parent, child):
            if end not in places:
                raise RobotModelError(
                    f"{here}: there is no link '{end}'; known: {', '.join(places)}"
                )
        made = ET.Element("joint", name=name, type=kind)
        ET.SubElement(made, "parent", link=parent)
        ET.SubElement(made, "child", link=child)
        made.append(_origin(inverse_of(places[parent]) @ places[child]))
        if kind != "fixed":
            axis = joint.find("axis")
            if axis is None:
                raise RobotModelError(f"{here} has no <axis>")
            x, y, z = self._axis(axis, joint, here, places[child])
            ET.SubElement(made, "axis", xyz=f"{x:.12g} {y:.12g} {z:.12g}")
            speed = number_in(axis, "limit/velocity", here)
            if speed is not None and 0.0 < speed < ENDLESS:
                ET.SubElement(made, "limit", velocity=repr(speed), effort="0")
        return made

    def _axis(self, axis: ET.Element, joint: ET.Element, here: str, place: Transform) -> FloatArray:
        """Return the axis of a joint in the frame of its child, as the URDF has it."""
        xyz = axis.find("xyz")
        values = floats_of(xyz, 3, "0 0 1", here)
        given = "" if xyz is None else xyz.get("expressed_in", "")
        is_of_model = flag_of(axis, "use_parent_model_frame")
        frame = self._scope.frame(given if given or is_of_model else joint.get("name", ""))
        turned: FloatArray = place[:3, :3].T @ frame[:3, :3] @ np.array(values)
        turned[np.abs(turned) < 1e-9] = 0.0
        return turned

    def _in_link(
        self, element: ET.Element, link: ET.Element, place: Transform, here: str
    ) -> Transform:
        """Return where an element of a link is, in the link as the URDF has it."""
        frame = self._scope.frame(base_of(element, self._scope, link.get("name", "")))
        moved: Transform = inverse_of(place) @ frame @ pose_of(element, here)
        return moved


def _kind(joint: ET.Element) -> str:
    """Return the type of a joint as the URDF has it; one that SDF does not have as it is."""
    kind = joint.get("type", "")
    if kind != "revolute":
        return KINDS.get(kind, kind)
    where = f"joint '{joint.get('name')}'"
    lower = number_in(joint, "axis/limit/lower", where)
    upper = number_in(joint, "axis/limit/upper", where)
    is_held = lower is not None and upper is not None and upper - lower < ENDLESS
    return "revolute" if is_held else "continuous"


def _shape(geometry: ET.Element, here: str, is_collision: bool) -> ET.Element | None:
    """Return a shape as the URDF has it; None for one that is only seen, or a ground plane."""
    for shape in geometry:
        if shape.tag == "box":
            return ET.Element("box", size=" ".join(map(repr, sizes_of(shape, "size", 3, here))))
        if shape.tag in ("cylinder", "sphere", "capsule"):
            names = ("radius",) if shape.tag == "sphere" else ("radius", "length")
            sizes = {name: sizes_of(shape, name, 1, here)[0] for name in names}
            if shape.tag == "capsule":  # the cylinder around it
                sizes["length"] += 2.0 * sizes["radius"]
            tag = "cylinder" if shape.tag == "capsule" else shape.tag
            return ET.Element(tag, {name: repr(value) for name, value in sizes.items()})
        if shape.tag == "mesh":
            made = ET.Element("mesh", filename=text_of(shape, "uri"))
            if (scale := shape.findtext("scale")) is not None:
                made.set("scale", " ".join(scale.split()))
            return made
        if is_collision:
            raise RobotModelError(
                f"{here}: its shape is <{shape.tag}>; expected box, cylinder, sphere, capsule, mesh"
            )
    if is_collision:
        raise RobotModelError(f"{here} has an empty <geometry>")
    return None


def _origin(place: Transform) -> ET.Element:
    xyz, rpy = _xyz_rpy(place)
    return ET.Element("origin", xyz=xyz, rpy=rpy)


def _xyz_rpy(place: Transform) -> tuple[str, str]:
    turn = place[:3, :3]
    pitch = math.atan2(-turn[2, 0], math.hypot(turn[0, 0], turn[1, 0]))
    if math.hypot(turn[0, 0], turn[1, 0]) > 1e-9:
        roll = math.atan2(turn[2, 1], turn[2, 2])
        yaw = math.atan2(turn[1, 0], turn[0, 0])
    else:  # straight up or down: only the sum of both turns counts
        roll, yaw = math.atan2(-turn[1, 2], turn[1, 1]), 0.0
    return _written(place[:3, 3]), _written((roll, pitch, yaw))


def _written(values: FloatArray | tuple[float, ...]) -> str:
    return " ".join(f"{0.0 if abs(value) < 1e-12 else float(value):.12g}" for value in values)
