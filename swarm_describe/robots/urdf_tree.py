"""A URDF text as a checked XML tree: one root, no loops, every number finite.

yourdfpy takes any tree and any number, so what would make nonsense is refused before it.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator

import numpy as np

from swarm_common.model.errors import RobotModelError
from swarm_common.model.shapes import Transform, transform_from_xyz_rpy
from swarm_describe.files.faults import Faults

DESCRIBED, OF_SHAPES = INERTIA = ("described", "shapes")  # where inertias come from
MAX_LINKS = 500
MAX_NUMBER = 1e5  # metres, kilograms: nothing on a robot is larger
NUMBERS = {"xyz": 3, "rpy": 3, "size": 3, "scale": 3, "radius": 1, "length": 1}
INERTIAS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
POSITIVE = ("size", "radius", "length")
PLACEHOLDER = re.compile(r"\$\{(?:namespace|robot_namespace|ns|prefix|tf_prefix|frame_prefix)\}")
NAMES = ("name", "link", "reference", "joint")
JOINTS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


def read_tree(text: str, where: str, inertia: str = DESCRIBED) -> ET.Element:
    """Return the checked tree of a URDF text; placeholders of namespaces are taken out.

    Args:
        inertia: One of `INERTIA`; with those of the shapes, the described ones become 0.
    """
    try:
        root = ET.fromstring(PLACEHOLDER.sub("", text).encode())
    except (ET.ParseError, ValueError) as cause:
        raise RobotModelError(f"{where}: malformed URDF: {cause}") from cause
    if root.tag != "robot":
        raise RobotModelError(f"{where}: expected <robot>, found <{root.tag}>")
    _strip_slashes(root)
    if inertia == OF_SHAPES:
        for element in root.iter("inertia"):
            element.attrib = dict.fromkeys(INERTIAS, "0")
    faults = Faults(where, RobotModelError)
    faults.tell(f"{where}: {fault}" for fault in _link_faults(root))
    for tag in ("link", "joint"):
        for top in root.findall(tag):
            for element in top.iter():
                faults.tell(
                    f"{where}: {tag} {top.get('name')}: {fault}"
                    for fault in _number_faults(element)
                )
    faults.check()
    return root


def root_link(root: ET.Element) -> str:
    """Return the name of the link without a parent."""
    children = {child_of(joint) for joint in root.findall("joint")}
    return next(n for link in root.findall("link") if (n := link.get("name", "")) not in children)


def fixed_places(root: ET.Element) -> dict[str, Transform]:
    """Return root_from_link of every link that no moving joint parts from the root."""
    places: dict[str, Transform] = {root_link(root): np.eye(4)}
    waiting = [joint for joint in root.findall("joint") if joint.get("type") == "fixed"]
    while ready := [joint for joint in waiting if _end(joint, "parent") in places]:
        for joint in ready:
            waiting.remove(joint)
            origin = joint.find("origin")
            texts = [None if origin is None else origin.get(name) for name in ("xyz", "rpy")]
            numbers = [float(word) for text in texts for word in (text or "0 0 0").split()]
            x, y, z, roll, pitch, yaw = numbers
            place = transform_from_xyz_rpy(x, y, z, roll, pitch, yaw)
            places[child_of(joint)] = places[_end(joint, "parent")] @ place
    return places


def child_of(joint: ET.Element) -> str:
    """Return the name of a joint's child link, empty if there is none."""
    return _end(joint, "child")


def _end(joint: ET.Element, tag: str) -> str:
    element = joint.find(tag)
    return "" if element is None else element.get("link", "")


def _strip_slashes(root: ET.Element) -> None:
    """Remove the slashes that an empty namespace leaves before names."""
    for tag in ("link", "joint", "gazebo"):
        for top in root.findall(tag):
            for element in (top, *(top.findall("parent") + top.findall("child"))):
                for name in NAMES:
                    if element.get(name, "").startswith("/"):
                        element.set(name, element.get(name, "").lstrip("/"))


def _link_faults(root: ET.Element) -> Iterator[str]:
    """Yield why the joints do not make one tree of the links."""
    links = [link.get("name", "") for link in root.findall("link")]
    joints = root.findall("joint")
    is_named = True
    for kind, names in (("link", links), ("joint", [j.get("name", "") for j in joints])):
        if "" in names:
            is_named = False
            yield f"there is a {kind} without a name"
        for twin, count in Counter(name for name in names if name).items():
            if count > 1:
                is_named = False
                yield f"there are {count} {kind}s called '{twin}'"
    if not 1 <= len(links) <= MAX_LINKS:
        yield f"{len(links)} links; expected 1 to {MAX_LINKS}"
        return
    known = set(links)
    parents: dict[str, tuple[str, str]] = {}  # by child: joint, parent link
    is_tree = is_named
    for joint in joints:
        name = joint.get("name", "")
        if joint.get("type") not in JOINTS:
            yield (
                f"joint {name} is of type '{joint.get('type')}'; "
                f"expected one of {', '.join(JOINTS)}"
            )
        for tag in ("parent", "child"):
            if (end := _end(joint, tag)) not in known:
                is_tree = False
                yield f"<{tag}> of joint {name} names no link: '{end}'"
        child = child_of(joint)
        if child in parents:
            is_tree = False
            yield f"link {child} hangs on two joints, {parents[child][0]} and {name}"
        parents[child] = (name, _end(joint, "parent"))
    if is_tree:  # otherwise later errors would only repeat this one
        yield from _loop_faults(links, parents)


def _loop_faults(links: list[str], parents: dict[str, tuple[str, str]]) -> Iterator[str]:
    settled: set[str] = set()
    has_loop = False
    for link in links:
        chain: list[str] = []
        while link in parents and link not in settled:
            if link in chain:
                loop = [parents[name][0] for name in chain[chain.index(link) :]]
                has_loop = True
                yield (
                    f"the joints {', '.join(reversed(loop))} form a loop; expected a tree of links"
                )
                break
            chain.append(link)
            link = parents[link][1]
        settled.update(chain)
    roots = [name for name in links if name not in parents]
    if len(roots) != 1 and not has_loop:
        yield f"expected one root link, found {roots or 'none'}"


def _number_faults(element: ET.Element) -> Iterator[str]:
    """Yield what is wrong with the numbers of one element."""
    counts = dict(NUMBERS)
    if element.tag == "mass":
        counts = {"value": 1}
    elif element.tag == "inertia":
        counts = dict.fromkeys(INERTIAS, 1)
    for name, count in counts.items():
        text = element.get(name)
        if text is None:
            continue
        what = f"<{element.tag}> {name} is '{text}'"
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            yield f"{what}: malformed URDF; expected numbers"
            continue
        if len(values) != count and not (name == "scale" and len(values) == 1):
            yield f"{what}; expected {count} number{'s' if count > 1 else ''}"
        elif not all(math.isfinite(v) and abs(v) <= MAX_NUMBER for v in values):
            yield f"{what}; expected finite numbers up to {MAX_NUMBER:g}"
        elif name in POSITIVE and min(values) <= 0.0:
            yield f"{what}; it must be positive"
        elif name == "scale" and 0.0 in values:
            yield f"{what}; it must not be 0"
