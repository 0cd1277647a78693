"""Worlds with one element renamed, moved or doubled: result or messages change.

A few of each run always; 20,000 with `FUZZ_EXAMPLES=20000 pytest tests/fuzz --timeout=0`.
"""

import copy
import functools
import xml.etree.ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.model.errors import SwarmError
from swarm_common.model.shapes import Mesh
from swarm_describe.worlds.grammar import KINDS, RULES
from swarm_describe.worlds.reader import read_world
from tests.fakes.gazebo_package import write_package
from tests.fuzz.byte_mutation import FUZZ

COLLISION = (
    "<collision name='{0}'><pose>0.1 0.2 0.3 0 0 0</pose><geometry>{1}</geometry>"
    "<surface><friction><{2}><{3}>0.4</{3}></{2}></friction></surface></collision>"
)
SHAPES = (
    "<box><size>0.3 0.4 0.5</size></box>",
    "<cylinder><radius>0.2</radius><length>0.7</length></cylinder>",
    "<sphere><radius>0.3</radius></sphere>",
    "<capsule><radius>0.1</radius><length>0.4</length></capsule>",
    "<cone><radius>0.2</radius><length>0.6</length></cone>",
    "<ellipsoid><radii>0.2 0.3 0.4</radii></ellipsoid>",
    "<polyline><point>0 0</point><point>1 0</point><point>1 1</point><height>2</height></polyline>",
    "<mesh><uri>model://barrier/meshes/barrier.dae</uri><scale>0.1 0.2 0.3</scale></mesh>",
)
VISUAL = (
    "<visual name='v'><pose>0 0 0.4 0 0 0</pose><geometry><box><size>0.2 0.2 0.3</size></box>"
    "</geometry><material>{0}</material></visual>"
)
LINK = (
    "<model name='one'><pose>0 1 0 0 0 0</pose><link name='l'><pose>0 0 1 0 0 0</pose><inertial>"
    "<mass>3</mass></inertial>{0}</link></model>"
)
BODIES = [
    LINK.format(COLLISION.format("c", shape, *(("ode", "mu"), ("bullet", "friction"))[index % 2]))
    for index, shape in enumerate(SHAPES)
]
PLANE = (
    "<model name='ground'><static>true</static><link name='l'><collision name='c'><geometry>"
    "<plane><normal>0 0.1 1</normal></plane></geometry></collision></link></model>"
)
OTHERS = (
    f"""<frame name="gate"><pose>1 2 0 0 0 0.5</pose></frame>
  <model name="two"><pose relative_to="gate">5 0 1 0 0 0</pose>
    <link name="a">{COLLISION.format("c", SHAPES[0], "ode", "mu")}</link>
    <link name="b"><pose>0 1 0 0 0 0</pose>{VISUAL.format("<diffuse>0 0 1</diffuse>")}</link>
    <joint name="j" type="fixed"><parent>a</parent><child>b</child></joint></model>
  <light name="lamp"/><plugin name="p" filename="f"/>""",
    f"""<model name="outer"><pose>-4 0 0 0 0 0</pose>
    <frame name="end"><pose>0 3 0 0 0 0.5</pose></frame>
    <model name="inner"><static>1</static><pose relative_to="end">1 0 0 0 0 0</pose><link name="l">
      {COLLISION.format("c", SHAPES[0], "ode", "mu")}
      {VISUAL.format("<diffuse>1 0 0 1</diffuse>")}{VISUAL.format("<ambient>0 1 0 1</ambient>")}
      {VISUAL.format("<script><name>Gazebo/Wood</name></script>")}</link></model>
    <include><uri>model://table</uri><name>left</name><pose>0 -3 0 0 0 0</pose>
    <static>0</static></include></model>
  <include><uri>model://table</uri><name>loose</name><pose>0 9 0 0 0 0</pose>
    <static>0</static><placement_frame>leg</placement_frame></include>""",
    """<actor name="clerk"><script><trajectory id="0" type="walk">
    <waypoint><time>0.5</time><pose>-2 0 0 0 0 0</pose></waypoint>
    <waypoint><time>4</time><pose>-2 4 0 0 0 1.5</pose></waypoint>
    <waypoint><time>9</time><pose>-4 4 0 0 0 1.5</pose></waypoint></trajectory></script>
    <link name="body"><collision name="c"><geometry><box><size>2 1 1.8</size></box></geometry>
    </collision></link></actor>""",
    f"""<model name="one"><link name="l"><pose>0 2 0 0 0 0</pose>
      {COLLISION.format("c", SHAPES[0], "ode", "mu")}</link><link name="k">
      {COLLISION.format("c", SHAPES[1], "ode", "mu")}</link></model>
    <state world_name="w"><model name="one"><pose>6 1 1 0 0 0</pose><scale>1 1 2</scale>
      <link name="k"><pose>8 1 1 0 0 0</pose></link></model>
    <insertions><model name="put"><pose>0 -9 1 0 0 0</pose><link name="l"><pose>0 0 1 0 0 1</pose>
      {COLLISION.format("c", SHAPES[2], "ode", "mu")}</link></model></insertions>
    <deletions><name>gone</name></deletions></state>""",
)
WORLDS = tuple(
    f"<sdf version='1.9'><world name='w'>{text}</world></sdf>" for text in (PLANE, *BODIES, *OTHERS)
)
# Twice the same is the same once: a place that is passed twice at a time, a model deleted twice.
IDEMPOTENT = {
    *(("trajectory", "waypoint"), ("polyline", "point")),
    *(("deletions", "name"), ("state", "deletions")),
}


def told(body):
    parts = [
        (p.shape.vertices.tobytes() if isinstance(p.shape, Mesh) else repr(p.shape),
         p.body_from_part.tobytes())
        for p in body.parts
    ]  # fmt: skip
    visuals = [(repr(v.shape), v.color, v.body_from_visual.tobytes()) for v in body.visuals]
    rest = (body.name, body.is_static, body.mass, body.friction, body.world_from_body.tobytes())
    return rest, parts, visuals


def outcome(path, text):
    """Return all that comes of a world: bodies, actors and notes, or the message."""
    path.write_text(text)
    try:
        file = read_world(path)
    except SwarmError as error:
        return str(error)
    return [told(body) for body in file.bodies], file.actors, file.notes


@functools.cache
def untouched(path, root):
    found = outcome(path, ET.tostring(root, "unicode"))
    assert isinstance(found, tuple), found
    return found


@pytest.fixture(scope="module", name="world")
def world_fixture(tmp_path_factory):
    return write_package(tmp_path_factory.mktemp("grammar")).with_name("own.world")


def read_elements(parent, kind="sdf", at=()):
    """Yield the elements that are read or counted, as indices, with their parent's kind and tag."""
    rule = RULES.get(kind)
    for index, child in enumerate(parent):
        if rule is None or child.tag in rule.quiet:
            continue
        here = (*at, index)
        yield here, kind, child.tag
        if child.tag not in rule.noted:
            inner = KINDS.get((kind, child.tag), child.tag) or child.tag
            yield from read_elements(child, inner, here)


def element_at(root, at):
    for index in at:
        root = root[index]
    return root


ROOTS = tuple(ET.fromstring(text) for text in WORLDS)
ELEMENTS = {root: list(read_elements(root)) for root in ROOTS}


def test_the_worlds_use_the_whole_grammar():
    used = {tag for elements in ELEMENTS.values() for _, _, tag in elements}
    wanted = {tag for rule in RULES.values() for tag in rule.once | rule.many}
    assert wanted - used <= {"submesh", "empty"}


@st.composite
def two_places(draw):
    elements = ELEMENTS[root := draw(st.sampled_from(ROOTS))]
    return root, draw(st.sampled_from(elements)), draw(st.sampled_from(elements))


@FUZZ
@given(places=two_places(), how=st.sampled_from(["rename", "misspell", "double", "move"]))
def test_an_element_of_a_world(world, places, how):
    intact, (at, kind, tag), target = places
    root = copy.deepcopy(intact)
    parent, element = element_at(root, at[:-1]), element_at(root, at)
    if how == "double":
        if (kind, tag) in IDEMPOTENT:
            return
        parent.insert(at[-1] + 1, copy.deepcopy(element))
    elif how == "move":
        goal = element_at(root, target[0])
        if goal is parent or goal in element.iter() or is_as_good(kind, tag, target):
            return
        parent.remove(element)
        goal.append(element)
    else:
        element.tag = "thing" if how == "rename" else tag[:-1] + "q"
    after = outcome(world, ET.tostring(root, "unicode"))
    assert untouched(world, intact) != after, (how, at, kind, tag, target)


def is_as_good(kind, tag, target):
    rule = RULES.get(KINDS.get(target[1:], target[2]) or target[2])
    is_counted = rule is not None and tag in rule.noted
    return is_counted or (kind, target[2]) in (("insertions", "world"), ("state model", "model"))
