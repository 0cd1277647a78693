"""Links and joints of a checked URDF tree, as records: what the simulation needs of them.

The same values, to the bit, as those of yourdfpy, which is a second slower to import: it is made
for showing robots, and brings trimesh, networkx and most of scipy with it.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

import numpy as np

from swarm_common.shapes import Box, Cylinder, FloatArray, Sphere, Transform


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A mesh that a geometry names; `scale` along x, y, z."""

    filename: str
    scale: tuple[float, float, float]


Geometry = Box | Cylinder | Sphere | MeshFile


@dataclass(frozen=True, slots=True)
class Collision:
    """A collision shape of a link.

    Attributes:
        geometry: Its shape.
        link_from_shape: Where it sits.
    """

    geometry: Geometry
    link_from_shape: Transform


@dataclass(frozen=True, slots=True)
class Inertial:
    """Mass [kg] and inertia (3, 3) of a link.

    Attributes:
        mass: [kg]; 0 if none is given.
        inertia: About the centre of mass, in the axes of the inertial frame.
        link_from_inertial: Where the centre of mass is.
    """

    mass: float
    inertia: FloatArray
    link_from_inertial: Transform


@dataclass(frozen=True, slots=True)
class Link:
    """A link with its collision shapes; `inertial` is None without <inertial>."""

    name: str
    inertial: Inertial | None
    collisions: tuple[Collision, ...]


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint between two links.

    Attributes:
        name: Of the joint.
        type: As in the URDF.
        parent: Name of a link.
        child: Name of a link.
        parent_from_child: At the joint's zero.
        axis: In the child's frame, as it is written.
        velocity: Limit [rad/s or m/s]; None if none is given.
    """

    name: str
    type: str
    parent: str
    child: str
    parent_from_child: Transform
    axis: FloatArray
    velocity: float | None


def read_links(root: ET.Element) -> list[Link]:
    """Return the links of a tree that `urdf_tree.read_tree` has checked.

    Raises:
        ValueError, KeyError, IndexError, TypeError: If an element is malformed.
    """
    return [_link(element) for element in root.findall("link")]


def read_joints(root: ET.Element) -> list[Joint]:
    """Return the joints of a checked tree; raises what `read_links` does."""
    return [_joint(element) for element in root.findall("joint")]


def _link(element: ET.Element) -> Link:
    for visual in element.findall("visual"):
        _geometry(visual)  # nobody here needs it, but it must make sense
    return Link(
        element.attrib["name"],
        _inertial(element.find("inertial")),
        tuple(Collision(_geometry(each), _origin(each)) for each in element.findall("collision")),
    )


def _joint(element: ET.Element) -> Joint:
    axis, limit = element.find("axis"), element.find("limit")
    velocity = None if limit is None else limit.get("velocity")
    return Joint(
        element.attrib["name"],
        element.attrib["type"],
        _child(element, "parent").attrib["link"],
        _child(element, "child").attrib["link"],
        _origin(element),
        _numbers("1 0 0" if axis is None else axis.get("xyz", "1 0 0")),
        None if velocity is None else float(velocity),
    )


def _inertial(element: ET.Element | None) -> Inertial | None:
    if element is None:
        return None
    mass, inertia = element.find("mass"), element.find("inertia")
    tensor = np.zeros((3, 3))
    if inertia is not None:
        xx, yy, zz = (float(inertia.get(name, 1.0)) for name in ("ixx", "iyy", "izz"))
        xy, xz, yz = (float(inertia.get(name, 0.0)) for name in ("ixy", "ixz", "iyz"))
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Inertial(
        0.0 if mass is None else float(mass.get("value", 0.0)), tensor, _origin(element)
    )


def _geometry(parent: ET.Element) -> Geometry:
    element = _child(parent, "geometry")
    if len(element) == 0:
        raise ValueError(f"a {parent.tag} without geometry")
    shape = element[0]
    if shape.tag == "box":
        x, y, z = _numbers(shape.attrib["size"]).tolist()
        return Box((x, y, z))
    if shape.tag == "cylinder":
        return Cylinder(float(shape.attrib["radius"]), float(shape.attrib["length"]))
    if shape.tag == "sphere":
        return Sphere(float(shape.attrib["radius"]))
    if shape.tag == "mesh":
        scale = _numbers(shape.get("scale") or "1")
        x, y, z = np.broadcast_to(scale, 3).tolist()
        return MeshFile(shape.get("filename") or "", (x, y, z))
    raise ValueError(f"Unknown tag: {shape.tag}")


def _child(element: ET.Element, tag: str) -> ET.Element:
    child = element.find(tag)
    if child is None:
        raise ValueError(f"a {element.tag} without {tag}")
    return child


def _origin(element: ET.Element) -> Transform:
    """Return the homogeneous matrix of an element's <origin>."""
    place = np.eye(4)
    origin = element.find("origin")
    if origin is None:
        return place
    place[:3, 3] = _numbers(origin.get("xyz", "0 0 0"))
    moved: Transform = np.dot(place, _rotation(_numbers(origin.get("rpy", "0 0 0"))))
    return moved


def _rotation(angles: FloatArray) -> Transform:
    """Return the rotation by roll, pitch and yaw about fixed axes."""
    si, sj, sk = (np.sin(angle) for angle in angles)  # one by one: arrays may round otherwise
    ci, cj, ck = (np.cos(angle) for angle in angles)
    cc, cs, sc, ss = ci * ck, ci * sk, si * ck, si * sk
    turn = np.eye(4)
    turn[:3, :3] = (
        (cj * ck, sj * sc - cs, sj * cc + ss),
        (cj * sk, sj * ss + cc, sj * cs - sc),
        (-sj, cj * si, cj * ci),
    )
    return turn


def _numbers(text: str) -> FloatArray:
    return np.array([float(word) for word in text.split()])
