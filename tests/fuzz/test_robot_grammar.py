"""Each element of a robot's files is read, noted or refused: renamed, moved, doubled, it is told.

The grammar is that of the files themselves: every element and attribute of a description, every key
of a robot.yaml and a fleet.
"""

import copy
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from swarm_common.files.resources import share_directory
from swarm_common.model.errors import SwarmError
from swarm_describe.robots.fleet import load_fleet
from swarm_describe.robots.loading import account_of
from tests.fakes.foreign_robots import SDF, Folder, plugin_drive
from tests.fakes.own_robots import Own

pytestmark = pytest.mark.slow
ROBOT = (share_directory() / "robots/turtlebot3_waffle/robot.yaml").read_text(encoding="utf-8")
FLEET = """order: mixed
groups:
  - {model: turtlebot3_burger, count: 3, limits: {max_vel_x: 0.2}, mission: loading_route}
  - model: turtlebot3_waffle
    count: 2
    start: {x_min: 0.0, y_min: 0.0, x_max: 4.0, y_max: 4.0, pitch: 1.0, yaw: 0.5}
"""
# What may change without a word: names of no concern, frames and topics, what is only seen.
SILENT_TAGS = ("topic", "gz_frame_id", "surface", "vertical")
SILENT_ATTRIBUTES = {"name": ("robot", "collision", "sensor", "plugin", "model")}


def outcome(path: Path) -> str:
    """Return the result and all messages, or the refusal, without the folder."""
    try:
        account = account_of(path)
        text = repr((account.rows, account.missing, account.notes))
    except SwarmError as error:
        text = str(error)
    return text


def places(root: ET.Element) -> Iterator[tuple[ET.Element, ET.Element]]:
    for parent in root.iter():
        for child in parent:
            yield parent, child


def edited(text: str, edit: Callable[[ET.Element, ET.Element, ET.Element], None]) -> Iterator[
    tuple[str, str]
]:  # fmt: skip
    """Yield what was changed and the text, for each element."""
    count = len(list(places(ET.fromstring(text))))
    for index in range(count):
        root = ET.fromstring(text)
        parent, child = list(places(root))[index]
        if child.tag in SILENT_TAGS or parent.tag in SILENT_TAGS:
            continue
        about = f"<{child.tag}> {child.get('name', '')} in <{parent.tag}> {parent.get('name', '')}"
        before = ET.tostring(root)
        edit(root, parent, child)
        if ET.tostring(root) != before:
            yield about, ET.tostring(root, encoding="unicode")


def rename(root: ET.Element, parent: ET.Element, child: ET.Element) -> None:
    child.tag = f"{child.tag}x"


def move(root: ET.Element, parent: ET.Element, child: ET.Element) -> None:
    """Put an element where it is not known: into a neighbour's end, or up to the top."""
    parent.remove(child)
    others = [e for e in root.iter() if e.tag != parent.tag and e is not child]
    target = next((e for e in others if e.tag in ("mass", "parent")), root)
    target.append(child)


def double(root: ET.Element, parent: ET.Element, child: ET.Element) -> None:
    parent.insert(list(parent).index(child) + 1, copy.deepcopy(child))


# A second shape in the same place changes nothing; a second LiDAR of one link is a choice.
# Joints of one side are a list.
REPEATABLE = ("collision", "gazebo", "plugin", "left_joint", "right_joint")
URDF = plugin_drive().urdf


@pytest.mark.parametrize("edit", [rename, move, double])
def test_urdf(edit, tmp_path):
    silent = []
    settings = plugin_drive().settings
    before = outcome(Own(URDF, settings).write(tmp_path))
    for about, text in edited(URDF, edit):
        if edit is double and about.split(">")[0][1:] in REPEATABLE:
            continue
        if outcome(Own(text, settings).write(tmp_path)) == before:
            silent.append(about)
    assert not silent, "\n".join(silent)


def test_attributes_of_a_urdf(tmp_path):
    silent = []
    settings = plugin_drive().settings
    before = outcome(Own(URDF, settings).write(tmp_path))
    for index, element in enumerate(ET.fromstring(URDF).iter()):
        for name in element.attrib:
            if element.tag in SILENT_ATTRIBUTES.get(name, ()):
                continue
            root = ET.fromstring(URDF)
            changed = list(root.iter())[index]
            changed.set(f"{name}x", changed.attrib.pop(name))
            text = ET.tostring(root, encoding="unicode")
            if outcome(Own(text, settings).write(tmp_path)) == before:
                silent.append(f"{name} of <{element.tag}> {element.get('name', '')}")
    assert not silent, "\n".join(silent)


@pytest.mark.parametrize("edit", [rename, move, double])
def test_sdf(edit, tmp_path):
    silent = []
    before = outcome(Folder().write(tmp_path))
    for about, text in edited(SDF, edit):
        if edit is double and about.split(">")[0][1:] in REPEATABLE:
            continue
        if outcome(Folder(text).write(tmp_path)) == before:
            silent.append(about)
    assert not silent, "\n".join(silent)


def keys(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the way to each key of a YAML document."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield (*path, key)
            yield from keys(item, (*path, key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from keys(item, (*path, index))


def changed_keys(text: str) -> Iterator[tuple[str, str]]:
    """Yield each key renamed, and each moved to the top or to the end of another section."""
    data = yaml.safe_load(text)
    for way in keys(data):
        for kind in ("renamed", "moved"):
            other = copy.deepcopy(data)
            holder = other
            for step in way[:-1]:
                holder = holder[step]
            value = holder.pop(way[-1])
            if kind == "renamed":
                holder[f"{way[-1]}x"] = value
            elif len(way) > 1:
                other[way[-1]] = value
            else:
                other["lidar" if "lidar" in other else "more"] = {way[-1]: value}
            yield f"{kind} {'.'.join(map(str, way))}", yaml.safe_dump(other, sort_keys=False)


def test_robot_yaml(tmp_path):
    path = tmp_path / "robot.yaml"
    path.write_text(ROBOT, encoding="utf-8")
    before = outcome(path)
    silent = []
    for about, text in changed_keys(ROBOT):
        path.write_text(text, encoding="utf-8")
        if outcome(path) == before:
            silent.append(about)
    assert not silent, "\n".join(silent)


def test_fleet(tmp_path):
    path = tmp_path / "fleet.yaml"

    def loaded(text: str) -> str:
        path.write_text(text, encoding="utf-8")
        try:
            return repr(load_fleet(path))
        except SwarmError as error:
            return str(error)

    before = loaded(FLEET)
    assert not [about for about, text in changed_keys(FLEET) if loaded(text) == before]
