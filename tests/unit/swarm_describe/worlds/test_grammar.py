"""Every element of a world is read, counted, of no account, or named; xacro is expanded."""

import pytest

from swarm_common.model.errors import WorldError
from swarm_describe.worlds.reader import load_world, read_world

SHAPE = "<geometry><box><size>1 1 1</size></box></geometry>"
LINK = f"<link name='l'><collision name='c'>{SHAPE}</collision></link>"
MODEL = f"<model name='m'><static>1</static>{LINK}</model>"
XACRO = """<?xml version="1.0"?>
<sdf version="1.8" xmlns:xacro="{uri}">
  <xacro:arg name="headless" default="true"/>
  <xacro:macro name="rack" params="n x">
    <model name="rack_${{n}}"><static>true</static><pose>${{x}} 0 0.5 0 0 0</pose>{link}</model>
  </xacro:macro>
  <world name="hall">
    <xacro:rack n="1" x="${{2 * 1.5}}"/>
    <xacro:if value="$(arg headless)"><xacro:rack n="2" x="-3"/></xacro:if>
    {more}
  </world>
</sdf>
"""


def write(folder, inside, around=""):
    path = folder / "w.sdf"
    path.write_text(f"<sdf version='1.7'><world name='w'>{inside}</world>{around}</sdf>")
    return path


@pytest.mark.parametrize(
    ("inside", "note"),
    [
        ("<gravty>0 0 -9.8</gravty>", "<gravty> in <world> is ignored; did you mean <gravity>?"),
        ("<gz:policies/><gz:policies/>", "ignored: 2 <gz:policies>"),
        ("some words", "the text 'some words' in <world> is ignored"),

        (MODEL.replace("static", "statik"), "did you mean <static>?"),
        (MODEL.replace("</static>", "</static><static>0</static>"), "a second <static>"),

        (MODEL.replace("</size>", "</size><radius>1</radius>"), "<radius> in <box>"),
        (MODEL.replace(SHAPE, "<geometry/>"), "is empty: nothing is there"),
        (
            MODEL.replace("<coll", "<inertial><mas>3</mas></inertial><coll"),
            "did you mean <mass>?",
        ),
        (
            MODEL.replace("</model>", "<joint name='j'/><joint name='j'/></model>"),
            "2 <joint> in model 'm' are called 'j'",
        ),
        (
            "<state world_name='w'><model name='m'><poes>1 0 0 0 0 0</poes></model></state>",
            "did you mean <pose>?",
        ),
        ("<state/><state/>", "of 2 <state>, the last one"),


    ],
)  # fmt: skip
def test_what_is_not_read_is_told(tmp_path, inside, note):
    notes = "\n".join(read_world(write(tmp_path, inside)).notes)
    assert note in notes


@pytest.mark.parametrize(
    ("inside", "around", "message"),
    [
        (f"<group>{MODEL}</group>", "", "<group> in <world> holds a <model>, but is not read"),
        (f"<modle name='m'>{LINK}</modle>", "", "did you mean <model>?"),
        (LINK, "", "<link> in <world> is not read"),
        (MODEL.replace("link", "lnik"), "", "<lnik> in model 'm' holds a <collision>"),
        (MODEL.replace(SHAPE, SHAPE + SHAPE), "", "a second <geometry>"),
        (
            MODEL.replace("</box>", "</box><sphere><radius>2</radius></sphere>"),
            "",
            "holds box, sphere; expected one shape",
        ),
        (MODEL, f"<world name='x'>{MODEL}</world>", "a second <world> in <sdf>"),
        (MODEL, MODEL.replace("'m'", "'beside'"), "<model> in <sdf>"),
        ("{% for i in range(3) %}" + MODEL + "{% endfor %}", "", "is the file a template?"),
        (f"<include><uri>model://x</uri>{LINK}</include>", "", "<link> in an <include>"),
        (f"<state><model name='m'>{SHAPE}</model></state>", "", "<geometry> in <model> 'm'"),
    ],
)
def test_what_may_be_solid_is_not_lost(tmp_path, inside, around, message):
    with pytest.raises(WorldError, match=r"w\.sdf") as caught:
        read_world(write(tmp_path, inside, around))
    assert message in str(caught.value)


def test_a_group_or_a_shape_of_another_program_may_be_left_out(tmp_path):
    world = write(tmp_path, f"<group>{MODEL}</group>{MODEL.replace(chr(39) + 'm', chr(39) + 'n')}")
    file = read_world(world, skip_broken=True)
    assert [body.name for body in file.bodies] == ["n::l"]
    assert "left out, because it is unusable: <group>" in file.notes[0]
    inside = MODEL.replace("<box>", "<drake:capsule/><box>")
    file = read_world(write(tmp_path, inside))
    assert len(file.bodies[0].parts) == 1
    assert file.notes == ("w.sdf: ignored: 1 <drake:capsule>",)


@pytest.mark.parametrize("uri", ["http://www.ros.org/wiki/xacro", "http://ros.org/wiki/xacro"])
@pytest.mark.parametrize("name", ["hall.sdf.xacro", "hall.world.xacro", "hall.sdf", "hall.world"])
def test_xacro_is_expanded(tmp_path, name, uri):
    (tmp_path / "more.xacro").write_text(
        f"<r xmlns:xacro='{uri}'><xacro:macro name='wall' params='x'>{MODEL}</xacro:macro></r>"
    )
    more = "<xacro:include filename='more.xacro'/><xacro:wall x='1'/>"
    (tmp_path / name).write_text(XACRO.format(link=LINK, uri=uri, more=more))
    scene = load_world(tmp_path / name)
    assert scene.name == "hall"
    assert [body.name for body in scene.bodies] == ["rack_1::l", "rack_2::l", "m::l"]
    assert scene.bodies[0].world_from_body[0, 3] == 3.0
    assert scene.notes == ()


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("<xacro:shelf/>", "unknown macro name: xacro:shelf"),
        ("<xacro:rack n='1'/>", "Undefined parameters [x]"),
        ("<xacro:include filename='gone.xacro'/>", "gone.xacro"),
        ("<xacro:if value='$(arg lamp)'/>", "$(arg lamp) has no value; give it a default="),
        ("<xacro:include filename='$(find racks)/a.xacro'/>", "racks"),
        ("<model>", "line"),
    ],
)
def test_what_xacro_refuses_is_one_message(tmp_path, more, message):
    path = tmp_path / "hall.sdf.xacro"
    path.write_text(XACRO.format(link=LINK, uri="http://www.ros.org/wiki/xacro", more=more))
    with pytest.raises(WorldError) as caught:
        load_world(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
    assert "xacro_args" not in str(caught.value)
