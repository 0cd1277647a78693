"""A URDF text as a checked XML tree: one root, no loops, every number finite.

yourdfpy takes any tree and any number, so what would make nonsense is refused before it.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections import Counter

from swarm_common.errors import RobotModelError

MAX_LINKS = 500
MAX_NUMBER = 1e5  # metres, kilograms: nothing on a robot is larger
NUMBERS = {"xyz": 3, "rpy": 3, "size": 3, "scale": 3, "radius": 1, "length": 1}
INERTIAS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
POSITIVE = ("size", "radius", "length")
PLACEHOLDER = re.compile(r"\$\{(?:namespace|robot_namespace|ns|prefix|tf_prefix|frame_prefix)\}")
NAMES = ("name", "link", "reference", "joint")
JOINTS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


def read_tree(text: str, where: str) -> ET.Element:
    """Return the checked tree of a URDF text; placeholders of namespaces are taken out.

    Raises:
        RobotModelError: If the text is malformed; the message names `where` and the element.
    """
    try:
        root = ET.fromstring(PLACEHOLDER.sub("", text).encode())
    except (ET.ParseError, ValueError) as cause:
        raise RobotModelError(f"{where}: malformed URDF: {cause}") from cause
    if root.tag != "robot":
        raise RobotModelError(f"{where}: expected <robot>, found <{root.tag}>")
    _strip_slashes(root)
    check_links(root, where)
    for link in root.findall("link"):
        for element in link.iter():
            _check_numbers(element, f"{where}: link {link.get('name')}")
    for joint in root.findall("joint"):
        for element in joint.iter():
            _check_numbers(element, f"{where}: joint {joint.get('name')}")
    return root


def root_link(root: ET.Element) -> str:
    """Return the name of the link without a parent, of a checked tree."""
    children = {child_of(joint) for joint in root.findall("joint")}
    return next(n for link in root.findall("link") if (n := link.get("name", "")) not in children)


def child_of(joint: ET.Element) -> str:
    """Return the name of a joint's child link, empty if there is none."""
    return _end(joint, "child")


def _end(joint: ET.Element, tag: str) -> str:
    element = joint.find(tag)
    return "" if element is None else element.get("link", "")


def _strip_slashes(root: ET.Element) -> None:
    """Take off the slashes that an empty namespace leaves before names."""
    for tag in ("link", "joint", "gazebo"):
        for top in root.findall(tag):
            for element in (top, *(top.findall("parent") + top.findall("child"))):
                for name in NAMES:
                    if element.get(name, "").startswith("/"):
                        element.set(name, element.get(name, "").lstrip("/"))


def check_links(root: ET.Element, where: str) -> None:
    """Check that the joints make one tree of the links.

    Raises:
        RobotModelError: Naming the link or joint that does not belong.
    """
    links = [link.get("name", "") for link in root.findall("link")]
    joints = root.findall("joint")
    for kind, names in (("link", links), ("joint", [j.get("name", "") for j in joints])):
        if "" in names:
            raise RobotModelError(f"{where}: there is a {kind} without a name")
        for twin, count in Counter(names).most_common(1):
            if count > 1:
                raise RobotModelError(f"{where}: there are {count} {kind}s called '{twin}'")
    if not 1 <= len(links) <= MAX_LINKS:
        raise RobotModelError(f"{where}: {len(links)} links; expected 1 to {MAX_LINKS}")
    known = set(links)
    parents: dict[str, tuple[str, str]] = {}  # by child: joint, parent link
    for joint in joints:
        name = joint.get("name", "")
        if joint.get("type") not in JOINTS:
            raise RobotModelError(
                f"{where}: joint {name} is of type '{joint.get('type')}'; "
                f"expected one of {', '.join(JOINTS)}"
            )
        for tag in ("parent", "child"):
            if (end := _end(joint, tag)) not in known:
                raise RobotModelError(f"{where}: <{tag}> of joint {name} names no link: '{end}'")
        child = child_of(joint)
        if child in parents:
            raise RobotModelError(
                f"{where}: link {child} hangs on two joints, {parents[child][0]} and {name}"
            )
        parents[child] = (name, _end(joint, "parent"))
    _check_loops(links, parents, where)


def _check_loops(links: list[str], parents: dict[str, tuple[str, str]], where: str) -> None:
    settled: set[str] = set()
    for link in links:
        chain: list[str] = []
        while link in parents and link not in settled:
            if link in chain:
                loop = [parents[name][0] for name in chain[chain.index(link) :]]
                raise RobotModelError(
                    f"{where}: the joints {', '.join(reversed(loop))} form a loop; "
                    "expected a tree of links"
                )
            chain.append(link)
            link = parents[link][1]
        settled.update(chain)
    roots = [name for name in links if name not in parents]
    if len(roots) != 1:
        raise RobotModelError(f"{where}: expected one root link, found {roots or 'none'}")


def _check_numbers(element: ET.Element, where: str) -> None:
    counts = dict(NUMBERS)
    if element.tag == "mass":
        counts = {"value": 1}
    elif element.tag == "inertia":
        counts = dict.fromkeys(INERTIAS, 1)
    for name, count in counts.items():
        text = element.get(name)
        if text is None:
            continue
        what = f"{where}: <{element.tag}> {name} is '{text}'"
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            raise RobotModelError(f"{what}: malformed URDF; expected numbers") from None
        if len(values) != count and not (name == "scale" and len(values) == 1):
            raise RobotModelError(f"{what}; expected {count} number{'s' if count > 1 else ''}")
        if not all(math.isfinite(v) and abs(v) <= MAX_NUMBER for v in values):
            raise RobotModelError(f"{what}; expected finite numbers up to {MAX_NUMBER:g}")
        if name in POSITIVE and min(values) <= 0.0:
            raise RobotModelError(f"{what}; it must be positive")
        if name == "scale" and 0.0 in values:
            raise RobotModelError(f"{what}; it must not be 0")
