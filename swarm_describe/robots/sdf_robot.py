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

from swarm_common.model.errors import RobotModelError
from swarm_common.model.shapes import (
    FloatArray,
    Transform,
    inverse_of,
    rotation_of,
    transform_from_xyz_rpy,
)
from swarm_describe.robots.urdf_tree import number_in

ENDLESS = 1e4  # [rad] from which the limits of a revolute joint are none
# type of a joint in SDF -> in URDF; those that a robot's casters have are held still
KINDS = {
    "fixed": "fixed", "revolute": "revolute", "continuous": "continuous", "prismatic": "prismatic",
    "ball": "fixed", "universal": "fixed", "screw": "fixed", "revolute2": "fixed",
    "gearbox": "fixed",
}  # fmt: skip
MODEL = ("", "__model__")  # names of the model's own frame


def find_model_file(folder: Path) -> Path | None:
    """Return the SDF file of a model's folder: the newest that model.config names; None without."""
    config = folder / "model.config"
    if not config.is_file():
        return folder / "model.sdf" if (folder / "model.sdf").is_file() else None
    try:
        root = ET.fromstring(config.read_bytes())
    except (OSError, ET.ParseError) as cause:
        raise RobotModelError(f"{config}: malformed: {cause}") from cause
    named = [(_version(e.get("version", "")), (e.text or "").strip()) for e in root.findall("sdf")]
    if not named:
        raise RobotModelError(f"{config} names no <sdf> file")
    path = folder / max(named)[1]
    if not path.is_file():
        raise RobotModelError(f"{config} names {path}, which is not there")
    return path


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(".") if part.isdigit())


def urdf_of(root: ET.Element, where: str) -> str:
    """Return an SDF model as URDF text.

    What its elements hold that nothing reads, `grammar` tells.
    """
    if root.find("world") is not None:
        raise RobotModelError(f"{where} is a world; a robot is an <sdf> with one <model>")
    models = root.findall("model")
    if len(models) != 1:
        raise RobotModelError(f"{where}: found {len(models)} <model> in <sdf>; expected one")
    return ET.tostring(_Converter(models[0], where).urdf(), encoding="unicode")


class _Converter:
    """One model, its frames, and the URDF that is made of it."""

    def __init__(self, model: ET.Element, where: str) -> None:
        self._model = model
        self._where = f"{where}: model '{model.get('name', '')}'"
        for tag in ("model", "include"):
            if model.find(tag) is not None:
                raise RobotModelError(
                    f"{self._where} holds other models (<{tag}>), which are not read; write their "
                    "links and joints into it"
                )
        if (model.findtext("static") or "").strip() in ("true", "1"):
            raise RobotModelError(f"{self._where} is <static>, so it cannot drive")
        self._joints = [j for j in model.findall("joint") if _text(j, "parent") != "world"]
        self._frames: dict[str, tuple[Transform, str]] = {}
        for link in model.findall("link"):
            self._add(link, "")
        for joint in model.findall("joint"):
            self._add(joint, _text(joint, "child"))
        for frame in model.findall("frame"):
            self._add(frame, frame.get("attached_to", ""))

    def urdf(self) -> ET.Element:
        robot = ET.Element("robot", name=self._model.get("name") or "robot")
        moving = {_text(j, "child"): j for j in self._joints if _kind(j) != "fixed"}
        places: dict[str, Transform] = {}  # model_from_link, as the URDF has it
        for link in self._model.findall("link"):
            name = link.get("name", "")
            place = self._frame(name)
            if name in moving:  # a URDF's link is where its joint is
                place = place.copy()
                place[:3, 3] = self._frame(moving[name].get("name", ""))[:3, 3]
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
        tensor = inertial.find("inertia")
        values = {}
        for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
            value = None if tensor is None else number_in(tensor, name, here)
            values[name] = repr(value or 0.0)
        ET.SubElement(made, "inertia", values)
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
        diffuse = solid.findtext("material/diffuse")
        if diffuse is not None and not is_collision:
            rgba = _numbers(diffuse if len(diffuse.split()) == 4 else f"{diffuse} 1", 4, here)
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
        parent, child = _text(joint, "parent"), _text(joint, "child")
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
        values = _numbers("0 0 1" if xyz is None else xyz.text or "", 3, f"{here}: <xyz>")
        given = "" if xyz is None else xyz.get("expressed_in", "")
        is_of_model = (axis.findtext("use_parent_model_frame") or "").strip() in ("true", "1")
        frame = self._frame(given if given or is_of_model else joint.get("name", ""))
        turned: FloatArray = place[:3, :3].T @ frame[:3, :3] @ np.array(values)
        turned[np.abs(turned) < 1e-9] = 0.0
        return turned

    def _add(self, element: ET.Element, base: str) -> None:
        name = element.get("name", "")
        pose = element.find("pose")
        given = "" if pose is None else pose.get("relative_to", "")
        place = _pose(element, f"{self._where}, {element.tag} '{name}'")
        self._frames.setdefault(name, (place, given or base))

    def _frame(self, name: str, chain: tuple[str, ...] = ()) -> Transform:
        """Return model_from_frame."""
        if name in MODEL:
            return np.eye(4)
        if name not in self._frames:
            raise RobotModelError(
                f"{self._where}: no frame '{name}'; known: {', '.join(self._frames)}"
            )
        if name in chain:
            raise RobotModelError(f"{self._where}: the poses go round: {' -> '.join(chain)}")
        place, base = self._frames[name]
        turned: Transform = self._frame(base, (*chain, name)) @ place
        return turned

    def _in_link(
        self, element: ET.Element, link: ET.Element, place: Transform, here: str
    ) -> Transform:
        """Return where an element of a link is, in the link as the URDF has it."""
        pose = element.find("pose")
        base = "" if pose is None else pose.get("relative_to", "")
        frame = self._frame(base or link.get("name", ""))
        moved: Transform = inverse_of(place) @ frame @ _pose(element, here)
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
            size = _numbers(shape.findtext("size") or "", 3, f"{here}: <size>")
            return ET.Element("box", size=" ".join(map(repr, size)))
        if shape.tag in ("cylinder", "sphere", "capsule"):
            names = ("radius",) if shape.tag == "sphere" else ("radius", "length")
            sizes = {}
            for name in names:
                value = number_in(shape, name, here)
                if value is None:
                    raise RobotModelError(f"{here}: <{shape.tag}> has no <{name}>")
                sizes[name] = value
            if shape.tag == "capsule":  # the cylinder around it
                sizes["length"] += 2.0 * sizes["radius"]
            tag = "cylinder" if shape.tag == "capsule" else shape.tag
            return ET.Element(tag, {name: repr(value) for name, value in sizes.items()})
        if shape.tag == "mesh":
            made = ET.Element("mesh", filename=(shape.findtext("uri") or "").strip())
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


def _text(element: ET.Element, tag: str) -> str:
    return (element.findtext(tag) or "").strip()


def _pose(element: ET.Element, here: str) -> Transform:
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return np.eye(4)
    if pose.get("rotation_format") == "quat_xyzw":
        x, y, z, *q = _numbers(pose.text or "", 7, f"{here}: <pose>")
        place: Transform = np.eye(4)
        norm = math.hypot(*q) or 1.0
        place[:3, :3] = rotation_of(*(part / norm for part in q))
        place[:3, 3] = (x, y, z)
        return place
    x, y, z, *angles = _numbers(pose.text or "", 6, f"{here}: <pose>")
    if pose.get("degrees") in ("true", "1"):
        angles = [math.radians(angle) for angle in angles]
    roll, pitch, yaw = angles
    return transform_from_xyz_rpy(x, y, z, roll, pitch, yaw)


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


def _numbers(text: str, count: int, what: str) -> list[float]:
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise RobotModelError(f"{what} is '{text.strip()}'; expected {count} numbers")
    return values
