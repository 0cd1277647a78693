"""Each element of a robot's files is read, noted or refused: renamed, moved, doubled, it is told.

The grammar is that of the files themselves: every element and attribute of a description.
"""

import copy
import xml.etree.ElementTree as ET

import pytest

from swarm_common.model.errors import SwarmError
from swarm_describe.robots.loading import account_of
from tests.fakes.foreign_robots import SDF, Folder, plugin_drive
from tests.fakes.own_robots import Own

pytestmark = pytest.mark.slow
# What may change without a word: names of no concern, frames and topics, what is only seen.
SILENT_TAGS = ("topic", "gz_frame_id", "surface", "vertical")
SILENT_ATTRIBUTES = {"name": ("robot", "collision", "sensor", "plugin", "model")}


def outcome(path):
    """Return the result and all messages, or the refusal, without the folder."""
    try:
        account = account_of(path)
        text = repr((account.rows, account.missing, account.notes))
    except SwarmError as error:
        text = str(error)
    return text


def places(root):
    for parent in root.iter():
        for child in parent:
            yield parent, child


def edited(text, edit):  # fmt: skip
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


def rename(root, parent, child):
    child.tag = f"{child.tag}x"


def move(root, parent, child):
    """Put an element where it is not known: into a neighbour's end, or up to the top."""
    parent.remove(child)
    others = [e for e in root.iter() if e.tag != parent.tag and e is not child]
    target = next((e for e in others if e.tag in ("mass", "parent")), root)
    target.append(child)


def double(root, parent, child):
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
